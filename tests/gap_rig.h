/* The simulated rig of the gap tests: sinusoids in closed loop, recorded. */
#ifndef HEXID_TESTS_GAP_RIG_H
#define HEXID_TESTS_GAP_RIG_H

#include "replay.h"

/* Records the first `tests` axes, configured by `params`, on `machine`. Returns the status of
 * replay_closed_loop(). */
static inline int gap_rig(const struct params *params, const struct params *machine, int tests, struct recording *out,
                          struct error *error) {
    struct recording like;
    recording_init(&like, params);
    like.tests = tests;
    for (int i = 0; i < tests; i++) like.test[i] = (struct recording_test){.test = i, .dof = (enum dof)i, .first = -1};
    return replay_closed_loop(machine, &like, out, error);
}

#endif
