/* The result of `hexid gap` as JSON, schema hexid.gap/1, in which values that were not evaluated
 * are null. */
#ifndef HEXID_GAP_JSON_H
#define HEXID_GAP_JSON_H

#include "gap_result.h"

/* Returns the result as text, which the caller frees, or NULL without memory. model: path of the
 * configuration with the effects found. */
char *gap_json(const struct gap_result *r, const char *model);

#endif
