/* What a test of no axis came to, a trajectory or a multisine, the last one where there
 * are several. How far the platform was from the reference is told, and not judged: no
 * limit is stated for it. */
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

/* The checks of a run that such a test can fail: it came to its end, and few
 * samples are excluded. */
void motion_judge(const struct motion_result *m, const struct params *params, struct verdict *verdict);

#endif
