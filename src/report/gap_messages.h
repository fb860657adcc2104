/* The result of hexid gap as an LCM message (lcmtypes/README.md). */
#ifndef HEXID_GAP_MESSAGES_H
#define HEXID_GAP_MESSAGES_H

#include "gap.h"

/* Returns the size, or -1 when it does not fit. What was not evaluated is NaN. Ordinary
 * threads, no heap. */
int gap_encode(const struct gap_result *result, int64_t time_ns, unsigned char *buffer, int capacity);

#endif
