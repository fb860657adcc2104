/* The model on its way: the base, fitted on the even cycles and judged on the odd ones, and the
 * effects that have joined it. Ordinary threads; heap. */
#ifndef HEXID_DIAGNOSE_H
#define HEXID_DIAGNOSE_H

#include "gap.h"
#include "hypothesis.h"

/* What a parameter has to gain, in white squares: ln of the number of values, about. */
#define DIAGNOSIS_PENALTY 8.0

struct diagnosis {
    const struct params *given;
    struct residual_data even, odd;
    struct fit_data fit, held_out;
    struct params model;                 /* fitted so far */
    bool found[EFFECTS_MAX];             /* added; what is given may have other values than that */
    int added;
    struct hypothesis addition[GAP_EFFECTS];
    int variables;                       /* base first, then those of the effects added */
    struct variable variable[FIT_VARIABLES];
    double std[FIT_VARIABLES];
    double square, held_square;          /* of the model so far; square: with what the values of the
                                          * effects cost by their priors */
    double *column;                      /* at the model, [variables][values] */
    double *gram;                        /* of the columns, with a ridge, [variables][variables] */
    double *raw;                         /* residuals at the model, [values] */
    struct hypothesis *hypothesis;
    int hypotheses;
};

/* threads: that fit the model at once; a trial has one alone until it is polished. 0, -2 or -3. */
int diagnosis_init(struct diagnosis *d, const struct params *given, const struct recording *recording, int threads, struct error *error);
void diagnosis_free(struct diagnosis *d);

/* Fits every variable of the model; column and squares are those of the result. */
bool diagnosis_refit(struct diagnosis *d, int iterations);

/* The values to report. Names are found with the base free in its box; then what base and effects
 * could explain alike is the effects': the base gets a prior about what is stated, as wide as
 * values anywhere in the box scatter about it; the noise is what the residuals say, where that is
 * less than it was taken for. */
void diagnosis_estimate(struct diagnosis *d);

/* Sum of white squares of the cycles held out; INFINITY: the model cannot make this motion. */
double diagnosis_held_square(const struct diagnosis *d, const struct params *model);

/* The hypothesis joins, the model is fitted on from this one; false where that cannot be done: all
 * is as before. */
bool diagnosis_add(struct diagnosis *d, const struct hypothesis *h, const struct params *model);

/* Takes an addition out again and fits the rest: true where that costs so little that it is not
 * needed; else all is as before. */
bool diagnosis_drop(struct diagnosis *d, int addition, double most);

#endif
