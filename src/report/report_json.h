/* Values as jansson has them, for reports. Private to src/report. */
#ifndef HEXID_REPORT_JSON_H
#define HEXID_REPORT_JSON_H

#include <jansson.h>

#include "identification_json.h"

/* A number that JSON cannot hold is null. */
json_t *report_number(double x);

/* Both take over the value. NULL when either is NULL or memory is short: what is built upon it is
 * NULL too, never a part of the result. */
json_t *report_append(json_t *array, json_t *value);
json_t *report_set(json_t *object, const char *key, json_t *value);

json_t *report_verdict(const struct verdict *v);
json_t *report_agreement(const struct agreement *a);
json_t *report_method_c(const struct method_c *c);
json_t *report_identification(const struct identification *id, const struct verdict *verdict, const struct loop_statistics *loop);

/* The object as text, and releases it; to be freed by the caller; NULL without memory. */
char *report_text(json_t *object);

#endif
