/* The verdict on what the search found: named, ambiguous, unknown, or no gap. Pure. */
#ifndef HEXID_JUDGE_H
#define HEXID_JUDGE_H

#include "gap.h"

/* White squares on held-out cycles; what is above their number is no noise. */
struct remainder {
    int values;
    double before, after;      /* excess of the base; sum of squares with the effects */
    double noise;              /* as much as noise alone makes of that sum */
    double beyond_laws;        /* weighted squares over what noise and laws make of them
                                * (goodness_beyond_laws) */
};

/* From a result that is complete but for these: fills verdict, reason and next_experiment. */
void judge(struct gap_result *r, const struct remainder *m);

#endif
