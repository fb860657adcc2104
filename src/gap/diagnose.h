/* The search on equations: fits the base, tries every hypothesis beside it on the even cycles,
 * ranks them on all, and adds the best while its gain outweighs its parameters on the odd ones,
 * too. */
#ifndef HEXID_DIAGNOSE_H
#define HEXID_DIAGNOSE_H

#include "gap.h"
#include "hypothesis.h"

/* Fitted on the even cycles, judged on the odd ones. */
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

struct trial {
    const struct hypothesis *hypothesis;
    bool ok;
    struct params model;                 /* fitted, base moved too */
    double square, held_square;          /* as above, of this model */
    double parameters;                   /* that the data determine: the others stand where their
                                          * priors have them, and make nothing up (MacKay 1992,
                                          * the effective number of parameters) */
    double gain, held_gain;              /* of the fitted cycles, less a penalty for each
                                          * of these; of the others */
    double std[HYPOTHESIS_VARIABLES];
    bool bound;
    bool as_found;                       /* what is parallel to it stands as the model so far
                                          * has it, not as given */
    bool polished;                       /* base and effect fitted together, not only the
                                          * base moved linearly */
};

/* Of all cycles: what decides between trials. */
static inline double trial_evidence(const struct trial *t) { return t->gain + t->held_gain; }

/* Gain of the fitted cycles as it is: what parameters win there by their number they
 * lose on the others. */
double trial_rise(const struct trial *t);

int diagnosis_init(struct diagnosis *d, const struct params *given, const struct recording *recording, struct error *error);
void diagnosis_free(struct diagnosis *d);

/* Sum of white squares, of the cycles held out, by which the laws of the effects there are, given
 * or found, may be off: of each its law_error's share (effect.h) of what it contributes. A law that
 * is off is so everywhere alike: noise does not hide it, however long it is averaged, and what
 * explains no more than that explains nothing. */
double diagnosis_law_error(const struct diagnosis *d);

/* White squares, held out, over what noise and laws, at four times their error, make of them beyond
 * doubt: above 1 something is left. INFINITY: the model cannot make this motion. */
double diagnosis_beyond_laws(const struct diagnosis *d);

/* The same of any rows: the mean square that noise has in each, 0 where nothing was evaluated, and
 * the square of its law error. The larger of two sums: each row in units of its variance, laws in
 * it; and weighed by the inverse of that once more, so that rows that they excuse lend nothing to
 * the others. */
double diagnosis_weigh(int rows, const double *white, const double *noise, const double *law);

/* Fits every variable of the model; column and squares are those of the result. */
bool diagnosis_refit(struct diagnosis *d, int iterations);

/* Tries hypotheses beside the model so far, `threads` at a time: every effect with all legs alike;
 * then those that came closest in their other shapes, for the legs with most to explain. The best
 * ones, and what the cycles held out contradict, are polished and come first, by their evidence.
 * Returns the number of trials (HYPOTHESES_MAX at most). */
int diagnosis_try(const struct diagnosis *d, struct trial *trial, int threads);

/* Sum of white squares, held out, that is noise alone, beyond doubt. */
double diagnosis_noise(const struct diagnosis *d);

/* The values to report. Names are found with the base free in its box; then what base and effects
 * could explain alike is the effects': the base gets a prior about what is stated, as wide as
 * values anywhere in the box scatter about it; the noise is what the residuals say, where that is
 * less than it was taken for. */
void diagnosis_estimate(struct diagnosis *d);

/* The hypothesis joins the model; false where that cannot be fitted: all is as before. */
bool diagnosis_add(struct diagnosis *d, const struct trial *t);

/* Takes an addition out again and fits the rest: true where that costs so little that it is not
 * needed; else all is as before. */
bool diagnosis_drop(struct diagnosis *d, int addition, double most);

#endif
