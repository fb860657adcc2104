/* Helpers that all C tests share. */
#ifndef HEXID_TESTS_SUPPORT_H
#define HEXID_TESTS_SUPPORT_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "config.h"
#include "effect.h"
#include "params.h"
#include "random.h"
#include "units.h"

static inline double random_normal(uint64_t *state) {
    double radius = sqrt(-2 * log(0.5 + 0.5 * random_unit(state) + 1e-300));
    return radius * cos(PI * random_unit(state));
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

/* Sets every leg to the same value. */
static inline void all_legs(double of[LEGS], double value) {
    for (int leg = 0; leg < LEGS; leg++) of[leg] = value;
}

/* Returns a configuration of the simulated platform with short tests and moves, otherwise the
 * default. */
static inline struct params brisk(void) {
    struct params params;
    config_default(&params);
    params.sim.engine = ENGINE_CLOSED_FORM;
    params.tests.settle_s = 0.1, params.tests.ramp_s = 0.25, params.tests.duration_s = 0.5, params.tests.ramp_out_s = 0.2;
    params.motion.engage_s = params.motion.park_s = 2.0;
    params.motion.hold_s = 0.1;
    return params;
}

static inline struct params by_hand(void) {
    struct params params = brisk();
    params.motion.automatic = false;
    return params;
}

/* Sets joint axes of six different lengths, none of them level. */
static inline void set_joint_axes(struct params *params) {
    struct geometry_params *g = &params->geometry;
    g->upper_axis.given = g->lower_axis.given = true;
    for (int leg = 0; leg < LEGS; leg++)
        for (int i = 0; i < 3; i++) {
            g->upper_axis.leg[leg][i] = i == 2 ? 0.2 : 0.7 * sin(1.0 + 2.0 * leg + 1.4 * i);
            g->lower_axis.leg[leg][i] = i == 2 ? -0.1 : 0.5 * sin(2.0 - 1.5 * leg + 1.6 * i);
        }
}

/* Switches an effect on and sets one of its keys to this value on all legs. */
static inline void set_effect(struct params *params, const char *name, int key, double value) {
    int place = effect_find(name);
    assert_true(place >= 0);
    params->effects[place].on = true;
    for (int leg = 0; leg < LEGS; leg++) params->effects[place].value[key][leg] = value;
}

/* Returns the largest difference of two arrays; NaN if either has a NaN. */
static inline double distance(const double *a, const double *b, int count) {
    double largest = 0.0;
    for (int i = 0; i < count; i++) {
        if (isnan(a[i]) || isnan(b[i])) return (double)NAN;
        largest = fmax(largest, fabs(a[i] - b[i]));
    }
    return largest;
}

/* Ends the test as skipped; tests/run prints the reasons at the end. */
#define skip_because(reason)                     \
    do {                                         \
        print_message("# skipped: %s\n", reason); \
        skip();                                  \
    } while (0)

/* True in the fast tier (`make check`). */
static inline bool quick(void) { return getenv("CHECK") != NULL; }

/* True in the long tier (`make test-long`). */
static inline bool more_cases(void) { return getenv("MORE_CASES") != NULL; }

/* Starts a case that takes more than a third of a second of processor time; only `make test` runs
 * it. */
#define slow_case()                                                                      \
    do {                                                                                 \
        if (quick() || more_cases()) skip_because("slow cases, left to make test"); \
    } while (0)

/* Starts a case that repeats a claim for the members of a list; `make check` skips it, `make test`
 * takes a few of them, and `make test-long`, where more_cases() is true, takes all. */
#define slow_sweep()                                                       \
    do {                                                                   \
        if (quick()) skip_because("slow cases, left to make test"); \
    } while (0)

/* Returns the number of random cases: all of them under `make test`, a fifth under `make check`. */
static inline int random_cases(int all) { return quick() ? all / 5 : all; }

/* Starts a case that takes seconds although another case runs the same code; only `make test-long`
 * runs it. */
#define long_case()                                                       \
    do {                                                                  \
        if (!more_cases()) skip_because("long cases, left to make test-long"); \
    } while (0)

/* Sanitizers bring their own allocator, locks and system calls and are ten times slower. Searches
 * that take minutes are therefore run under them once, not for every claim. */
#define MINUTES_UNDER_SANITIZERS "minutes under a sanitizer, which sees the same code in shorter tests"
#define OWN_ALLOCATOR "sanitizers have an allocator, locks and system calls of their own"
#ifdef __SANITIZE_THREAD__
#define SANITIZED_THREADS 1
#else
#define SANITIZED_THREADS 0
#endif
#ifdef __SANITIZE_ADDRESS__
#define SANITIZED 1
#else
#define SANITIZED SANITIZED_THREADS
#endif

/* Starts a slow case that is there for its numbers. Other cases run the same lines, and with a
 * sanitizer they suffice. */
#define numbers_case()                                                \
    do {                                                              \
        slow_case();                                                  \
        if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS); \
    } while (0)

#endif
