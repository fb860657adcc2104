/* Results as LCM messages (lcmtypes/README.md). Each returns the size, or -1 when it does not fit.
 * Ordinary threads, no heap. */
#ifndef HEXID_IDENT_MESSAGES_H
#define HEXID_IDENT_MESSAGES_H

#include "ident.h"
#include "identification_json.h"
#include "verdict.h"

int test_result_encode(const struct test_result *t, int64_t time_ns, unsigned char *buffer, int capacity);

/* What was not evaluated is NaN. */
int identification_encode(const struct identification *id, const struct verdict *verdict, int64_t time_ns, unsigned char *buffer,
                          int capacity);

/* tests: how many so far; what is not determined is NaN. */
int method_c_encode(const struct method_c *c, int tests, int64_t time_ns, unsigned char *buffer, int capacity);

int loop_stats_encode(const struct loop_statistics *s, int64_t time_ns, unsigned char *buffer, int capacity);

#endif
