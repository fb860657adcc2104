/* The table of configuration keys, and one value of it: text -> struct params and back,
 * range-checked. The effects' keys come from effect_table, so that an effect's file is the only
 * place that knows them. Private to src/io/config*.c. Main thread. config_keys.c: the table.
 * config_value.c: values. config_check.c: what several keys must agree on. config.c: files. */
#ifndef HEXID_CONFIG_KEYS_H
#define HEXID_CONFIG_KEYS_H

#include <stddef.h>

#include "params.h"
#include "status.h"

enum {
    CONFIG_PATH_SIZE = 80,
    CONFIG_ITEMS = 3 * LEGS,
    CONFIG_ITEM_SIZE = PARAMS_TEXT_SIZE,
    CONFIG_REASON_SIZE = 240,
    CONFIG_TEXT_SIZE = 2 * CONFIG_ITEM_SIZE + 8
};

enum config_kind {
    CONFIG_REAL,
    CONFIG_INTEGER,
    CONFIG_BOOLEAN,
    CONFIG_CHOICE,    /* one of `names` */
    CONFIG_TEXT,      /* printable ASCII */
    CONFIG_AXES,      /* list of axes, each at most once */
    CONFIG_REALS,     /* `count` of them, of legs or axes: one for all, or a list */
    CONFIG_REALS_ALIKE,/* `count` of them: one for all */
    CONFIG_POINTS     /* `count` lists of x, y, z, or an empty list: none given */
};

struct config_key {
    char path[CONFIG_PATH_SIZE]; /* "control.kp": section and member of struct params */
    enum config_kind kind;
    size_t offset;               /* of the value in struct params */
    double min, max;             /* allowed, both included */
    char value[48];              /* default, as one would write it; an effect's:
                                  * the one that adds nothing */
    const char *unit;            /* "-": none */
    const char *meaning;
    const char *const *names;    /* of a choice, ended by NULL */
    int effect;                  /* its place in effect_table, -1: not an effect's */
    int count;                   /* of values or points, at most LEGS */
    bool shape;                  /* of an effect that has no such strength: how a law looks */
};

/* All keys in the order of the file, those of effects last: false past the end. */
bool config_key_at(int index, struct config_key *key);

bool config_key_find(const char *path, struct config_key *key);

/* The known key that the user may have meant, "" when none is near. */
void config_key_nearest(const char *path, char nearest[CONFIG_PATH_SIZE]);

/* One line about what holds keys: "control", "effects", "effects.valve_lag". NULL when there is
 * no such section. */
const char *config_section_title(const char *path);

/* What stands in the file or after "=": one scalar, a list, or a list of points, coordinate by
 * coordinate. Unused bytes are zero. */
struct config_value {
    bool list;
    int count;
    char item[CONFIG_ITEMS][CONFIG_ITEM_SIZE];
};

/* Lists may be so deep: of points 2. */
int config_key_depth(const struct config_key *key);

/* False: more than the key can take, too long, or with a zero byte. */
bool config_value_add(const struct config_key *key, struct config_value *value, const char *text, size_t length);

/* A value as written after "=" or as a default: commas, with or without brackets, make a list where
 * the key takes one; points need brackets. */
bool config_value_split(const struct config_key *key, const char *text, struct config_value *value);

/* Checks kind and range, then stores; an effect's key switches the effect on. False: `reason` says
 * what is wrong and what would do. */
bool config_value_set(const struct config_key *key, const struct config_value *value, struct params *params,
                      char reason[CONFIG_REASON_SIZE]);

/* The value as YAML, in the shortest form that reads back bit for bit. */
void config_value_format(const struct config_key *key, const struct params *params, char text[CONFIG_TEXT_SIZE]);

/* What the key accepts: "0..10000 1/m", "ode, closed_form". */
void config_range_format(const struct config_key *key, char text[CONFIG_TEXT_SIZE]);

/* What no single key can know: that the parts make a machine, and that the tests stay inside its
 * limits. `name` stands for the file. */
int config_check(const struct params *params, const char *name, struct error *error);

/* Whether a configuration states this key, of the few of which params keep that; of all others true
 * is answered, and nothing kept. */
bool config_is_stated(const struct config_key *key, const struct params *params);
void config_keep_stated(const struct config_key *key, struct params *params, bool stated);

#endif
