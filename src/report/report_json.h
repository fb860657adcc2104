/* Values of reports as objects of jansson. */
#ifndef HEXID_REPORT_JSON_H
#define HEXID_REPORT_JSON_H

#include <jansson.h>

#include "identification_json.h"

/* Returns a number as JSON; null if it is not finite. */
json_t *report_number(double x);

/* Both add a value to an array or an object, take over the value, and return the array or object.
 * If an argument is NULL or memory is short, they release array or object and value, and return
 * NULL. A NULL thus reaches the end of a chain of calls, so that the caller gets either the
 * complete result or NULL. */
json_t *report_append(json_t *array, json_t *value);
json_t *report_set(json_t *object, const char *key, json_t *value);

/* Return numbers as a list, and a 6x6 row-major matrix as a list of lists. */
json_t *report_vector(const double *x, int count);
json_t *report_matrix(const double *m);

json_t *report_verdict(const struct verdict *v);
json_t *report_agreement(const struct agreement *a);
json_t *report_method_c(const struct method_c *c, const struct common_gain *gain, const struct verdict *verdict);
json_t *report_identification(const struct identification *id, const struct verdicts *verdicts, const struct loop_statistics *loop);

/* Turns an object into text and releases the object. The caller frees the text. Returns NULL
 * without memory, or if the object is NULL. */
char *report_text(json_t *object);

#endif
