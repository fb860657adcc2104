/* The only place with conversion factors. Inside hexid everything is SI; degrees and percent
 * exist for people. */
#ifndef HEXID_UNITS_H
#define HEXID_UNITS_H

#include <stdint.h>

#define NS_PER_S 1000000000LL
#define NS_PER_US 1000LL
#define PI 3.14159265358979323846

static inline double seconds_from_ns(int64_t ns) { return (double)ns * 1e-9; }
static inline int64_t ns_from_seconds(double s) { return (int64_t)(s * 1e9 + (s < 0.0 ? -0.5 : 0.5)); }
static inline double us_from_ns(int64_t ns) { return (double)ns * 1e-3; }
static inline double deg_from_rad(double rad) { return rad * (180.0 / PI); }

#endif
