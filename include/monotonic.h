/* Time of a host clock that nobody can set: CLOCK_MONOTONIC. RT, any thread. */
#ifndef HEXID_MONOTONIC_H
#define HEXID_MONOTONIC_H

#include <stdint.h>
#include <time.h>

#include "units.h"

static inline int64_t monotonic_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * NS_PER_S + t.tv_nsec;
}

static inline int64_t monotonic_ms(void) { return monotonic_ns() / NS_PER_MS; }

#endif
