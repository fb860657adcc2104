/* Prints the result of `hexid tune` for people, as a section of YAML, and as JSON. Ordinary
 * threads. */
#ifndef HEXID_TUNE_REPORT_H
#define HEXID_TUNE_REPORT_H

#include <jansson.h>
#include <stdio.h>

#include "loop_tune.h"

/* Prints the table of modes with the configured and the tuned gains, and the margins with the mode
 * and pose in which each is smallest. */
void tune_report_print(FILE *out, const struct loop_tune *tune, const struct params *params);

/* Prints the section `control`, to be pasted into a configuration. */
void tune_report_section(FILE *out, const struct loop_tune *tune);

/* Writes the changes to make: "set control.kp to 18 (now 40), ..."; gains that would hardly change
 * are left out. The text is cut at `size`. */
void tune_report_remedy(const struct loop_tune *t, size_t size, char text[]);

/* Writes which requirement of loop_tune.h is missed, by how much, and which part of the machine
 * limits it; "" if all are met. */
enum { TUNE_MISS_SIZE = 400 };
void tune_report_missed(const struct loop_tune *tune, const struct params *params, char text[TUNE_MISS_SIZE]);

/* Returns the result as a JSON object, without the schema's name; NULL without memory. */
json_t *tune_report_object(const struct loop_tune *tune);

/* Returns the result as JSON text, schema hexid.tune/1. version: version of this program. The
 * caller frees the text; NULL without memory. */
char *tune_report_json(const struct loop_tune *tune, const char *version, const char *config, bool bus);

#endif
