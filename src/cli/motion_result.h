/* What a test of no axis came to, a trajectory or a multisine: nothing to identify, but did the platform follow? */
#ifndef HEXID_MOTION_RESULT_H
#define HEXID_MOTION_RESULT_H

#include "params.h"
#include "verdict.h"

struct motion_result {
    int64_t cycles;              /* of such tests, in any phase */
    int64_t samples, excluded;   /* of the evaluated part */
    double off_m, off_rad;       /* farthest from the reference on an axis, in the samples */
    bool complete;
};

/* The next cycle, of whatever kind. */
void motion_take(struct motion_result *m, const struct params *params, const struct cycle *cycle);

/* The checks of a run that such a test can fail: over, and with few samples excluded. */
void motion_judge(const struct motion_result *m, const struct params *params, struct verdict *verdict);

#endif
