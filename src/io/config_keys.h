/* The table of configuration keys, and one value of it: text -> struct params and back, range-checked. The effects' keys come from
 * effect_table, so that an effect's file is the only place that knows them. Private to src/io/config*.c and its tests. */
#ifndef HEXID_CONFIG_KEYS_H
#define HEXID_CONFIG_KEYS_H

#include <stddef.h>
#include <stdio.h>

#include "params.h"
#include "status.h"

enum { CONFIG_PATH_SIZE = 80, CONFIG_VALUE_SIZE = LCM_URL_SIZE, CONFIG_REASON_SIZE = 240 };

enum config_kind {
    CONFIG_REAL,
    CONFIG_INTEGER,
    CONFIG_BOOLEAN,
    CONFIG_CHOICE,    /* one of `names` */
    CONFIG_TEXT,
    CONFIG_AXES,      /* list of different axis names */
    CONFIG_LEGS,      /* real, one for all legs or a list of six */
    CONFIG_LEGS_ALIKE /* real, one for all legs */
};

struct config_key {
    char path[CONFIG_PATH_SIZE]; /* "control.kp": section and member of struct params */
    enum config_kind kind;
    size_t offset;               /* of the value in struct params */
    double min, max;             /* allowed, both inclusive */
    char value[48];              /* default, as one would write it */
    const char *unit;            /* "-" none */
    const char *meaning;
    const char *const *names;    /* of a choice, ended by NULL */
    int effect;                  /* its place in effect_table, -1: not an effect's */
};

/* What stands in the file or after "=": one scalar, or a list. */
struct config_value {
    bool list;
    int count;
    char item[LEGS][CONFIG_VALUE_SIZE];
};

/* All keys, those of effects last: false past the end. */
bool config_key_at(int index, struct config_key *key);

bool config_key_find(const char *path, struct config_key *key);

/* "control", "effects", "effects.valve_lag": something that holds keys. */
bool config_section_known(const char *path);

/* One line about a section, NULL when unknown. */
const char *config_section_title(const char *section);

/* The known key that the user may have meant, "" when none is near. */
void config_key_nearest(const char *path, char nearest[CONFIG_PATH_SIZE]);

/* A value as written after "=" or as a default: commas make a list where the key takes one. False: too long or too many. */
bool config_value_split(const struct config_key *key, const char *text, struct config_value *value);

/* Checks kind and range, then stores; an effect's key switches the effect on. False: `reason` says what is wrong and what would be right. */
bool config_key_set(const struct config_key *key, const struct config_value *value, struct params *params, char reason[CONFIG_REASON_SIZE]);

/* The value as YAML, shortest form that reads back bit for bit. */
void config_key_print(const struct config_key *key, const struct params *params, FILE *out);

/* "1/m, 0..1000" or "ode, closed_form". */
void config_key_print_range(const struct config_key *key, FILE *out);

/* What no single key can know: the machine fits together and the tests stay inside its limits. `name` stands for the source. */
int config_check(const struct params *params, const char *name, struct error *error);

#endif
