/* The table of configuration keys, and conversion of single values between text and struct
 * params, with range checks. The keys of effects come from effect_table, so that an effect's
 * file alone defines them. Private to src/io/config*.c and tests. Main thread. config_keys.c: the
 * table. config_value.c: values. config_check.c: checks across keys. config.c: files. */
#ifndef HEXID_CONFIG_KEYS_H
#define HEXID_CONFIG_KEYS_H

#include <stddef.h>

#include "params/text.h"
#include "status.h"
#include "types.h"

struct params;

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
    CONFIG_CHOICE,    /* one of the words in config_key.names */
    CONFIG_TEXT,      /* text in printable ASCII */
    CONFIG_AXES,      /* list of axes, each at most once */
    CONFIG_REALS,    /* `count` numbers, one for each leg or axis; a single number stands for all */
    CONFIG_REALS_ALIKE,/* `count` equal numbers, read and written as one */
    CONFIG_POINTS     /* `count` points, each a list of x, y and z; an empty list means that none
                       * are given */
};

struct config_key {
    char path[CONFIG_PATH_SIZE]; /* section and name in the file: "control.kp" */
    enum config_kind kind;
    size_t offset;               /* offset of the value in struct params */
    double min, max;             /* range of allowed values, both ends included */
    char value[48];  /* default value in YAML; for a key of an effect the value with which the
                      * effect adds nothing */
    const char *unit;            /* unit of the value; "-": it has none */
    const char *meaning;
    const char *const *names;    /* words of a CONFIG_CHOICE; ended by NULL */
    int effect;          /* index of the effect in effect_table; -1: the key belongs to no effect */
    int count;                   /* number of values or points, at most LEGS */
    bool shapes_law;         /* the key only shapes an effect's law; it has no value with which the
                              * effect adds nothing */
};

/* Gets a key by its index in the order of the file, effects last. Returns false past the end. */
bool config_key_at(int index, struct config_key *key);

bool config_key_find(const char *path, struct config_key *key);

/* Finds the known key or section nearest to a misspelt one; "" if none is near. */
void config_key_nearest(const char *path, char nearest[CONFIG_PATH_SIZE]);

/* Returns true if the key, or a section that contains it, is in this list of keys and sections,
 * which NULL ends. */
bool config_key_within(const char *path, const char *const *sections);

/* Returns a line about a section: "control", "effects", "effects.valve_lag"; NULL: there is no such
 * section. */
const char *config_section_title(const char *path);

/* Items of a value in the file or after "=": one scalar, a list, or a list of points, coordinate by
 * coordinate. Unused bytes are zero. */
struct config_value {
    bool list;
    int count;
    char item[CONFIG_ITEMS][CONFIG_ITEM_SIZE];
};

/* Returns how deep the lists that the key takes may be nested: 2 for points, else 1. */
int config_key_depth(const struct config_key *key);

/* Appends an item. Returns false if the key takes no more, or if the text is too long or has a zero
 * byte. */
bool config_value_add(const struct config_key *key, struct config_value *value, const char *text, size_t length);

/* Splits a value as it stands after "=" or as a default. Commas make a list if the key takes one,
 * with or without brackets; points need brackets. */
bool config_value_split(const struct config_key *key, const char *text, struct config_value *value);

/* Checks kind and range, then stores the value; a key of an effect switches the effect on. Returns
 * false with `reason`: the mistake, and the values that are accepted. */
bool config_value_set(const struct config_key *key, const struct config_value *value, struct params *params,
                      char reason[CONFIG_REASON_SIZE]);

/* Formats the value as YAML, in the shortest form that reads back bit for bit. */
void config_value_format(const struct config_key *key, const struct params *params, char text[CONFIG_TEXT_SIZE]);

/* Formats the accepted values of the key: "0..10000 1/m", "ode, closed_form". */
void config_range_format(const struct config_key *key, char text[CONFIG_TEXT_SIZE]);

/* Checks requirements that involve several keys: the parts must make a machine, and the tests must
 * stay inside its limits. `name` stands for the file in messages. */
int config_check(const struct params *params, const char *name, struct error *error);

/* config_is_stated() returns true if the configuration states this key; config_keep_stated()
 * records whether it does. Only the diameters of section actuator have such a record; all other
 * keys count as stated. */
bool config_is_stated(const struct config_key *key, const struct params *params);
void config_keep_stated(const struct config_key *key, struct params *params, bool stated);

#endif
