/* The verdict on the search's result: effect named, ambiguous, unknown, or no gap. Pure. */
#ifndef HEXID_JUDGE_H
#define HEXID_JUDGE_H

#include "gap.h"

/* White squares on held-out cycles. Noise gives about 1 each; the excess is above that. */
struct remainder {
    int values;
    double before, after;      /* excess of the base; sum with the effects */
    double noise;              /* largest sum that noise alone gives */
    double beyond_laws;        /* weighted squares relative to noise and errors of the laws
                                * (goodness_beyond_laws) */
};

/* Fills verdict, reason and next_experiment of an otherwise complete result. */
void judge(struct gap_result *r, const struct remainder *m);

#endif
