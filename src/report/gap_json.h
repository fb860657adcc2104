/* The result of hexid gap as JSON, schema hexid.gap/1. What was not evaluated is null. */
#ifndef HEXID_GAP_JSON_H
#define HEXID_GAP_JSON_H

#include "gap.h"

/* model: the path of the extended configuration. To be freed by the caller; NULL without memory. */
char *gap_json(const struct gap_result *r, const char *model);

#endif
