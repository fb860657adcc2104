/* The verdict on what the search found: named, ambiguous, unknown, or no gap. Pure. */
#ifndef HEXID_JUDGE_H
#define HEXID_JUDGE_H

#include "gap.h"

/* White squares on held-out cycles; what is above their number is no noise. */
struct remainder {
    int values;
    double before, after;      /* excess of the base; sum of squares with the effects */
    double noise;              /* so much of that may be noise */
    double law_error;          /* of that, as much as the laws of the effects there are may be
                                * off */
};

/* From a result that is complete but for these: fills verdict, reason and next_experiment. */
void judge(struct gap_result *r, const struct remainder *m);

#endif
