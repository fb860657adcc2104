/* The model under diagnosis: the base and the effects added to it so far, fitted on the even cycles
 * and judged on the odd ones. Ordinary threads; heap. */
#ifndef HEXID_DIAGNOSE_H
#define HEXID_DIAGNOSE_H

#include "gap_result.h"
#include "hypothesis.h"
#include "params.h"

/* Penalty for each parameter, in squared white residuals: about ln of the number of values. */
#define DIAGNOSIS_PENALTY 8.0

struct diagnosis {
    const struct params *given;
    struct residual_data even, odd;
    struct fit_data fit, held_out;
    struct params model;                 /* the base and the added effects, as fitted last */
    bool found[EFFECTS_MAX];  /* effects that were added, and clock skew if it was measured; the
                               * configuration may have them with other values */
    int added;
    struct hypothesis addition[GAP_EFFECTS];
    int variables;                       /* variables of the model: the base's first, then those of
                                          * the added effects */
    struct variable variable[FIT_VARIABLES];
    double std[FIT_VARIABLES];
    double square, held_square;          /* sums of squared white residuals of the model, on fitted
                                          * and on held-out cycles; square includes the penalty of
                                          * the priors of effects and of sensors' errors */
    double *column;                      /* [variables][values]: Jacobian of the white residuals,
                                          * computed at the model or so near to it that it holds
                                          * there */
    bool whitened_anew;                  /* the whiteners have changed since the columns were
                                          * computed */
    double *gram;             /* [variables][variables]: Gram matrix of the columns, with a ridge */
    double *raw;                         /* [values]: raw residuals at the model */
    struct hypothesis *hypothesis;
    int hypotheses;
};

/* Fits the base to the even cycles. threads: number of threads; a trial uses one of them, its final
 * polishing all. Returns 0, -2 (the recording cannot be evaluated, or its lengths are no motion of
 * the machine) or -3 (no memory). Call diagnosis_free in any case. */
int diagnosis_init(struct diagnosis *d, const struct params *given, const struct recording *recording, int threads, struct error *error);
void diagnosis_free(struct diagnosis *d);

/* Estimates the values to report. During the search the base variables, except for the sensors'
 * errors, move freely between their bounds. Here each of them gets a prior about its stated value,
 * with the standard deviation of a uniform distribution between the bounds, so that a difference
 * that an effect and the base explain equally well goes to the effect. If the residuals show less
 * noise than assumed, these priors are widened in proportion, because the white residuals then have
 * too little weight. */
void diagnosis_estimate(struct diagnosis *d);

/* Sum of squared white residuals on the held-out cycles; INFINITY if the model cannot make the
 * measured motion. */
double diagnosis_held_square(const struct diagnosis *d, const struct params *model);

/* Adds a hypothesis' effect and refits, starting from `model`. On failure returns false and leaves
 * everything as it was. */
bool diagnosis_add(struct diagnosis *d, const struct hypothesis *h, const struct params *model);

/* Replaces all added effects by the given ones and refits, starting from `model`. Returns false if
 * the model cannot make the measured motion or has too many variables, and leaves everything as it
 * was. */
bool diagnosis_assume(struct diagnosis *d, int effects, const struct hypothesis *h, const struct params *model);

/* Removes an added effect and refits the remaining variables. Returns true if the effect is not
 * needed: without it, the squared white residuals rise by less than `most` on the held-out cycles,
 * and by less than `most` plus the penalty for the effect's parameters on the fitted ones.
 * Otherwise restores everything and returns false. */
bool diagnosis_drop(struct diagnosis *d, int addition, double most);

#endif
