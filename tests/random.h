/* Random numbers of tests and benchmarks: the same sequence in every run. */
#ifndef HEXID_TESTS_RANDOM_H
#define HEXID_TESTS_RANDOM_H

#include <stdint.h>

/* Returns a random number, uniform in -1..1. */
static inline double random_unit(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(int64_t)*state / 9223372036854775808.0;
}

#endif
