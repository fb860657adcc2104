/* The verdict on the result of the search: effect named, partly named, ambiguous, unknown
 * effect, or no gap. Pure. */
#ifndef HEXID_JUDGE_H
#define HEXID_JUDGE_H

#include "gap_result.h"

/* Sums of squared white residuals on the held-out cycles. Noise gives about 1 for each value. */
struct remainder {
    int values;
    /* before: sum with the base alone, less the expected sum of noise. after: sum with the effects,
     * noise included. */
    double before, after;
    double noise;              /* largest sum that noise alone gives */
    double beyond_laws;        /* squared white residuals, divided by the most that noise and errors
                                * of the laws explain (goodness_beyond_laws) */
};

/* Fills verdict, reason and next_experiment of a result that is otherwise complete. */
void judge(struct gap_result *r, const struct remainder *m);

/* Makes the verdict partly_named, for a result whose effects come from sets (statements.h). Returns
 * false and changes nothing if a tone or most of the gap remains, or if the effects look like any
 * part that moves by itself. */
bool judge_partly(struct gap_result *r);

/* Stores the certainty of the verdict in the result. If its probability is below GAP_SURE, the
 * reason states it, with the likeliest set that contradicts the verdict, and effect_named becomes
 * partly_named. In one case effect_named becomes ambiguous instead: the contradicting set has, in
 * place of one effect, another one or several that look like it, has otherwise the same effects,
 * and the probabilities of both sets add up to GAP_SURE or more. */
void judge_certainty(struct gap_result *r, const struct remainder *m, const struct gap_certainty *certainty);

#endif
