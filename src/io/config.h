/* Configuration: YAML file and --set overrides are read into struct params and checked against
 * one table of keys (name, unit, range, meaning). libyaml parses; every message names file, line
 * and key, or "--set key". Main thread. */
#ifndef HEXID_CONFIG_H
#define HEXID_CONFIG_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "config_note.h"
#include "status.h"

struct params;

/* Sets the values of config/tian2015.yaml (a test keeps the two equal), with all effects off. */
void config_default(struct params *params);

/* Loads defaults, then the file (NULL: none), then the "key=value" settings in order; then runs the
 * checks that involve several keys. Returns 0 or -2. */
int config_load(struct params *params, const char *path, const char *const *settings, int count, struct error *error);

/* Makes the checks that only a run needs, since evaluating a log moves nothing. Refuses a mechanism
 * that hexid does not drive; a platform suspended from its legs; limits.length_min_m not below the
 * length of a fully retracted leg; ramps that are too short; and a machine that may move without a
 * controller for longer than limits.blind_time_s (blind_time.h). Returns 0 or -2. */
int config_check_motion(const struct params *params, struct error *error);

/* Loads YAML text from memory, such as that in a log; `name` stands for the file in messages. */
int config_parse(struct params *params, const char *text, size_t size, const char *name, struct error *error);

/* Returns true if the YAML text of a configuration states this key, whatever the value. Returns
 * false if the text cannot be read as a configuration. */
bool config_states(const char *text, size_t size, const char *key);

/* Applies the "key=value" settings in order to existing params, then runs the checks; `name` stands
 * for the configuration in messages. Returns 0 or -2. */
int config_override(struct params *params, const char *name, const char *const *settings, int count, struct error *error);

/* Returns true if one of the "key=value" settings gives this key. */
bool config_sets(const char *const *settings, int count, const char *key);

/* Takes the keys of section `tests` that the YAML text of another configuration states, then those
 * that the settings give; all other keys stay. If text is NULL or unreadable, only the settings
 * count; `unreadable` gets the reason, or an empty text. Then makes the checks of config_load(),
 * except whether the machine reaches the amplitudes, because recorded amplitudes were reached.
 * Returns 0 or -2. */
int config_take_tests(struct params *params, const char *text, size_t size, const char *name, const char *const *settings, int count,
                      struct error *unreadable, struct error *error);

/* Returns YAML text that config_parse() turns back into the same params, bit for bit; effects that
 * are off are left out. To be freed by the caller. NULL: no memory. */
char *config_text(const struct params *params);

/* Returns the text of config_text() below a comment line, `head`, with notes behind the values of
 * some keys. */
char *config_text_noted(const struct params *params, const char *head, const struct config_note *note, int notes);

/* Returns the text of config_text() without these keys and sections (names such as
 * "tests.frequency_hz", ended by NULL). */
char *config_text_without(const struct params *params, const char *const *left_out);

/* Finds the first key among these keys and sections (names such as "payload", ended by NULL) whose
 * values differ, with the first 60 bytes of both values as YAML. Returns false if there is none. */
struct config_difference {
    char key[80], a[64], b[64];
};
bool config_difference(const struct params *a, const struct params *b, const char *const *sections, struct config_difference *difference);

/* Returns a hash of all keys on which the closed loop and its following error depend, except the
 * gains that may change while it runs (src/core/gains.h). A client may compute the loop of a daemon
 * whose configuration has the same hash. */
uint64_t config_digest(const struct params *params);

/* Lists the keys of cylinder, valve and oil that still have the built-in machine's values although
 * the machine is another one (single axis or another geometry): "hydraulics.supply_pa 10e6, ...".
 * Writes "" if there is no such key, or for the built-in machine. */
enum { CONFIG_DEFAULTS_SIZE = 480 };
void config_defaults(const struct params *params, char text[CONFIG_DEFAULTS_SIZE]);

/* Prints every key with default, range, unit and meaning, and every effect with its law, in
 * Markdown: the generated part of docs/configuration.md. */
void config_print_keys(FILE *out);

#endif
