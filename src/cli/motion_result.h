/* The result of a test of no axis, that is a trajectory or a multisine; of the last one where there
 * are several. How far the platform was from the reference is reported, not judged: no limit is
 * stated for it. */
#ifndef HEXID_MOTION_RESULT_H
#define HEXID_MOTION_RESULT_H

#include "params.h"
#include "verdict.h"

struct motion_result {
    int64_t cycles;              /* of such tests, in any phase */
    int64_t samples, excluded;   /* of the evaluated part */
    double off_m, off_rad;       /* farthest from the reference on an axis, in the samples */
    bool complete;
    double test_time_s;          /* of the last cycle */
};

/* The next cycle, of whatever kind. */
void motion_take(struct motion_result *m, const struct params *params, const struct cycle *cycle);

/* Adds to the verdict what such a test can fail: not complete, or too many samples excluded. */
void motion_judge(const struct motion_result *m, const struct params *params, struct verdict *verdict);

#endif
