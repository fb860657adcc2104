/* Configuration: YAML file and --set overrides -> struct params, checked against one table of keys
 * (name, unit, range, meaning). libyaml reads; every message names file, line and key, or "--set
 * key". Main thread. */
#ifndef HEXID_CONFIG_H
#define HEXID_CONFIG_H

#include <stdio.h>

#include "params.h"
#include "status.h"

/* The values of config/tian2015.yaml (a test holds the two together), all effects off. */
void config_default(struct params *params);

/* Default, then the file (NULL: none), then the "key=value" settings in order; then the checks that
 * need several keys. 0 or -2. */
int config_load(struct params *params, const char *path, const char *const *settings, int count, struct error *error);

/* What moves a machine must be asked for more than what is only evaluated: a log may come from
 * anywhere, but nothing is driven without ramps, where legs that are in are too short for the
 * limits, or where the machine could move without a controller for longer than limits.blind_time_s
 * (blind_time.h). 0 or -2. */
int config_check_motion(const struct params *params, struct error *error);

/* The same from YAML text in memory; `name` stands for the file in messages. For
 * configurations kept in logs. */
int config_parse(struct params *params, const char *text, size_t size, const char *name, struct error *error);

/* The "key=value" settings in order on params that are there, then the checks; `name`
 * as above. 0 or -2. */
int config_override(struct params *params, const char *name, const char *const *settings, int count, struct error *error);

/* YAML text that config_parse turns back into the same params, bit for bit; effects only where on.
 * To be freed by the caller. */
char *config_text(const struct params *params);

/* The first key within these sections ("payload"; the list ends with NULL) whose value is not the
 * same in both, and both values as one would write them. False: there is none. */
struct config_difference {
    char key[80], a[64], b[64];
};
bool config_difference(const struct params *a, const struct params *b, const char *const *sections, struct config_difference *difference);

/* Of another machine than the built-in one (one axis, or another geometry), the keys of cylinder,
 * valve and oil that have that one's values all the same: "hydraulics.supply_pa 10e6, ...".
 * "": none, or the built-in machine. */
enum { CONFIG_DEFAULTS_SIZE = 480 };
void config_defaults(const struct params *params, char text[CONFIG_DEFAULTS_SIZE]);

/* Every key with default, range, unit and meaning, and every effect with its law, in Markdown:
 * docs/configuration.md from its first key on. */
void config_print_keys(FILE *out);

#endif
