/* The result of `hexid gap` as an LCM message (lcmtypes/README.md). */
#ifndef HEXID_GAP_MESSAGES_H
#define HEXID_GAP_MESSAGES_H

#include "gap_result.h"

/* Encodes the result; values that were not evaluated are NaN. Returns the size in bytes, or -1 if
 * the message does not fit the buffer. Ordinary threads, no heap. */
int gap_encode(const struct gap_result *result, int64_t time_ns, unsigned char *buffer, int capacity);

#endif
