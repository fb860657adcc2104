/* What the tests of control and loop share. */
#ifndef HEXID_TESTS_SUPPORT_H
#define HEXID_TESTS_SUPPORT_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "config.h"

/* -1..1, the same sequence in every run. */
static inline double random_unit(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(int64_t)*state / 9223372036854775808.0;
}

static inline int random_below(uint64_t *state, int count) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (int)((*state >> 33) % (uint64_t)count);
}

/* Fails on NaN. */
#define assert_below(value, limit)                                                                                  \
    do {                                                                                                            \
        double value_ = (value), limit_ = (limit);                                                                  \
        if (!(value_ < limit_)) fail_msg("%s = %g is not below %s = %g", #value, value_, #limit, limit_);           \
    } while (0)
#define assert_close(a, b, tolerance) assert_below(fabs((a) - (b)), tolerance)

/* Largest difference of two arrays, NaN where either has one. */
static inline double distance(const double *a, const double *b, int count) {
    double largest = 0.0;
    for (int i = 0; i < count; i++) {
        if (isnan(a[i]) || isnan(b[i])) return (double)NAN;
        largest = fmax(largest, fabs(a[i] - b[i]));
    }
    return largest;
}

/* Sanitizers take ten times the time: minutes of search are made once there, not for every claim about it. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

#endif
