/* Result of a test that belongs to no axis (a trajectory or a multisine), or of the last one if
 * there were several. The platform's deviation from the reference is reported but not judged,
 * because no limit is stated for it. */
#ifndef HEXID_MOTION_RESULT_H
#define HEXID_MOTION_RESULT_H

#include "verdict.h"

struct motion_result {
    int64_t cycles;              /* number of cycles of the test, in all its phases */
    int64_t samples, excluded;   /* numbers of samples of the evaluated part that are used, and that
                                  * are excluded */
    double off_m, off_rad;       /* largest deviation from the reference in the samples used, of any
                                  * position and of any angle */
    bool complete;               /* the evaluated part is complete */
    double test_time_s;          /* time in the test at its last cycle */
};

/* Takes the next cycle of a run; only cycles of a test without an axis count. */
void motion_take(struct motion_result *m, const struct params *params, const struct cycle *cycle);

/* Adds a reason to the verdict if the test is not complete or has too many samples excluded. */
void motion_judge(const struct motion_result *m, const struct params *params, struct verdict *verdict);

#endif
