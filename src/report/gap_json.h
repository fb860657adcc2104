/* The result of hexid gap as JSON, schema hexid.gap/1. Values not evaluated are null. */
#ifndef HEXID_GAP_JSON_H
#define HEXID_GAP_JSON_H

#include "gap.h"

/* model: path of the extended configuration. The caller frees the text. NULL without memory. */
char *gap_json(const struct gap_result *r, const char *model);

#endif
