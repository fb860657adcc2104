/* The only place with conversion factors. hexid is SI inside; degrees and percent are for
 * people. */
#ifndef HEXID_UNITS_H
#define HEXID_UNITS_H

#include <stdint.h>

#define NS_PER_S 1000000000LL
#define NS_PER_MS 1000000LL
#define NS_PER_US 1000LL
#define MS_PER_S 1000
#define PI 3.14159265358979323846

static inline double seconds_from_ns(int64_t ns) { return (double)ns * 1e-9; }
static inline int64_t ns_from_seconds(double s) { return (int64_t)(s * 1e9 + (s < 0.0 ? -0.5 : 0.5)); }
static inline double us_from_ns(int64_t ns) { return (double)ns * 1e-3; }

/* Returns a + b, limited to the range of int64_t: numbers from a log or a message may have any
 * value. */
static inline int64_t add_saturated(int64_t a, int64_t b) {
    int64_t sum;
    return !__builtin_add_overflow(a, b, &sum) ? sum : b < 0 ? INT64_MIN : INT64_MAX;
}

/* Returns the number of cycles missing between two sequence numbers; INT64_MAX if `later` is not
 * after `seq`. */
static inline int64_t cycles_between(uint64_t seq, uint64_t later) {
    uint64_t missing = later - seq - 1;
    return missing > INT64_MAX ? INT64_MAX : (int64_t)missing;
}

static inline double deg_from_rad(double rad) { return rad * (180.0 / PI); }
static inline double rad_from_deg(double deg) { return deg * (PI / 180.0); }

#endif
