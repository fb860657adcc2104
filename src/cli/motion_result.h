/* Result of a test that belongs to no axis: a trajectory or a multisine; the last one if there
 * are several. The platform's deviation from the reference is reported but not judged, because
 * no limit is stated for it. */
#ifndef HEXID_MOTION_RESULT_H
#define HEXID_MOTION_RESULT_H

#include "verdict.h"

struct motion_result {
    int64_t cycles;              /* number of cycles of the test, in all its phases */
    int64_t samples, excluded;   /* samples used, and samples excluded, of the evaluated part */
    double off_m, off_rad;       /* largest deviations from the reference in these samples, of any
                                  * position and of any angle */
    bool complete;               /* the evaluated part has come to its end */
    double test_time_s;          /* time in the test at its last cycle */
};

/* Takes the next cycle of a run; ignores cycles outside such a test. */
void motion_take(struct motion_result *m, const struct params *params, const struct cycle *cycle);

/* Adds to the verdict the failures of such a test: not complete, or too many samples excluded. */
void motion_judge(const struct motion_result *m, const struct params *params, struct verdict *verdict);

#endif
