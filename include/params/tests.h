/* Section `tests` of the configuration (params.h). */
#ifndef HEXID_PARAMS_TESTS_H
#define HEXID_PARAMS_TESTS_H

#include "params/text.h"
#include "types.h"

/* Range of a test's frequency, in tests.frequency_hz and in the head of a CSV file. */
#define TESTS_LEAST_HZ 0.01
#define TESTS_MOST_HZ 100.0

/* Range of a test's amplitude, m or rad. */
#define TESTS_LEAST_AMPLITUDE 1e-6
#define TESTS_MOST_M 1.0
#define TESTS_MOST_RAD 0.5

struct test_params {
    enum dof order[DOFS];         /* axes to test, in this order */
    int count;
    double hz[DOFS];              /* frequency of each axis's sinusoid */
    double amplitude[DOFS];       /* amplitude of each axis's sinusoid, m or rad */
    double settle_s, ramp_s, duration_s, ramp_out_s; /* durations of a test's parts; duration_s is
                                                      * that of the evaluated part */
    int harmonics;                /* number of harmonics regressed, the fundamental included */
    bool multisine;               /* one test moves all axes of `order` at once */
    char trajectory[PARAMS_TEXT_SIZE]; /* file of poses over time, which replaces the sinusoids; "":
                                        * none */
    int repeat;                   /* number of passes of the trajectory */
};

/* Returns true if axes are tested one after another, each with a sinusoid, as methods A and B need.
 * Otherwise the run is a single test that belongs to no axis. */
static inline bool tests_single(const struct test_params *t) { return !t->multisine && !t->trajectory[0]; }
static inline int tests_count(const struct test_params *t) { return tests_single(t) ? t->count : 1; }
static inline const char *tests_name(const struct test_params *t, enum dof dof) {
    return dof != DOF_NONE ? dof_names[dof] : t->trajectory[0] ? "trajectory" : t->multisine ? "multisine" : "none";
}

#endif
