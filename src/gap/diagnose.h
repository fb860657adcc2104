/* The model under diagnosis: the base, fitted on the even cycles and judged on the odd ones, and
 * the effects added to it so far. Ordinary threads; heap. */
#ifndef HEXID_DIAGNOSE_H
#define HEXID_DIAGNOSE_H

#include "gap.h"
#include "hypothesis.h"

/* Least gain for each parameter, in white squares: about ln of the number of values. */
#define DIAGNOSIS_PENALTY 8.0

struct diagnosis {
    const struct params *given;
    struct residual_data even, odd;
    struct fit_data fit, held_out;
    struct params model;                 /* current fit */
    bool found[EFFECTS_MAX];  /* added effects; the configuration may have them with other values */
    int added;
    struct hypothesis addition[GAP_EFFECTS];
    int variables;                       /* base first, then added effects */
    struct variable variable[FIT_VARIABLES];
    double std[FIT_VARIABLES];
    double square, held_square;          /* sums of white squares of the model, on fitted and
                                          * held-out cycles; square includes the penalty of the
                                          * effects' priors */
    double *column;                      /* Jacobian at the model, [variables][values] */
    double *gram;             /* Gram matrix of the columns, with a ridge, [variables][variables] */
    double *raw;                         /* residuals at the model, [values] */
    struct hypothesis *hypothesis;
    int hypotheses;
};

/* threads: number of threads that fit the model; each trial runs on one thread until it is
 * polished. Returns 0, -2 or -3. */
int diagnosis_init(struct diagnosis *d, const struct params *given, const struct recording *recording, int threads, struct error *error);
void diagnosis_free(struct diagnosis *d);

/* Fits all variables of the model; columns and squares are updated. Returns false if the model
 * cannot make the motion. */
bool diagnosis_refit(struct diagnosis *d, int iterations);

/* Estimates the values to report. The search leaves the base free in its box. Here each base
 * variable gets a prior about its stated value, with the standard deviation of a uniform
 * distribution over its box, so that whatever base and effects explain equally well goes to the
 * effects. If the residuals show less noise than assumed, the priors are tightened accordingly. */
void diagnosis_estimate(struct diagnosis *d);

/* Sum of white squares on the held-out cycles; INFINITY if the model cannot make this motion. */
double diagnosis_held_square(const struct diagnosis *d, const struct params *model);

/* Adds a hypothesis and refits, starting from this model. On failure returns false and leaves
 * everything as it was. */
bool diagnosis_add(struct diagnosis *d, const struct hypothesis *h, const struct params *model);

/* Removes an addition and refits the rest. Returns true if that costs so little that the
 * addition is not needed; otherwise restores everything and returns false. */
bool diagnosis_drop(struct diagnosis *d, int addition, double most);

#endif
