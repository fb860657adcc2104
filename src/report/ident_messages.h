/* Results of an identification as LCM messages (lcmtypes/README.md). Each function returns the
 * message's size in bytes, or -1 if it does not fit the buffer. Ordinary threads, no heap. */
#ifndef HEXID_IDENT_MESSAGES_H
#define HEXID_IDENT_MESSAGES_H

#include "ident.h"
#include "identification_json.h"
#include "verdict.h"

int test_result_encode(const struct test_result *t, int64_t time_ns, unsigned char *buffer, int capacity);

/* Encodes the matrices of methods A, modified A and B, and the verdict; values that were not
 * evaluated are NaN. */
int identification_encode(const struct identification *id, const struct verdict *verdict, int64_t time_ns, unsigned char *buffer,
                          int capacity);

/* Encodes method C's result; values that are not determined are NaN. tests: number of tests
 * evaluated so far. */
int method_c_encode(const struct method_c *c, int tests, int64_t time_ns, unsigned char *buffer, int capacity);

int loop_stats_encode(const struct loop_statistics *s, int64_t time_ns, unsigned char *buffer, int capacity);

#endif
