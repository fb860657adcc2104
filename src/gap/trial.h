/* Trial of a hypothesis beside the model: the values of the hypothesis are fitted, and the base
 * moves with them. Ordinary threads; heap. */
#ifndef HEXID_TRIAL_H
#define HEXID_TRIAL_H

#include "diagnose.h"
#include "params.h"

#define TRIAL_LEAST 4.0 /* a gain up to this, in squared white residuals on fitted or held-out
                         * cycles, is noise */
#define TRIAL_KEPT 0.5  /* share of a gain that the held-out cycles must confirm; if they show less,
                         * they contradict the gain */

struct trial {
    const struct hypothesis *hypothesis;
    bool ok;
    struct params model;                 /* the current model plus the hypothesis, as fitted */
    double square, held_square;    /* sums of squared white residuals of this model, as in struct
                                    * diagnosis */
    double parameters;                   /* number of parameters that the data determine (effective
                                          * number of parameters, MacKay 1992); all others stay at
                                          * their priors and explain nothing */
    /* Gains in squared white residuals against the current model. gain: on the fitted cycles, less
     * a penalty for each parameter and for the choice of a single leg. held_gain: on the held-out
     * cycles, without a penalty. */
    double gain, held_gain;
    double std[HYPOTHESIS_VARIABLES];
    bool bound;          /* a value is at an end of its range, and this end is not its neutral
                          * value */
    bool as_found;       /* base variables parallel to the effect keep the values of the last fit;
                          * false: they return to the given ones */
    bool polished;     /* base and effect are fitted together; before that, the base is moved
                        * linearly */
};

/* Evidence for a trial, which decides between candidates: its gains over all cycles, in squared
 * white residuals. */
static inline double trial_evidence(const struct trial *t) { return t->gain + t->held_gain; }

/* Gain on the fitted cycles before the penalty for parameters, for comparisons in which the
 * held-out cycles already penalise parameters. */
double trial_rise(const struct trial *t);

/* Evidence by which the best trial is ahead of another one. The penalty for parameters counts only
 * if either has a value for each leg: an external stiffness with six parameters, of which one is
 * used, is no worse for the other five. */
double trial_ahead(const struct trial *best, const struct trial *t);

/* Gain on the fitted cycles, less the 1 that each parameter gains by chance. */
static inline double trial_fitted_gain(const struct trial *t) { return trial_rise(t) - t->parameters; }

/* Tries a hypothesis with the first steps of a fit. alike: trial of the same effect with all legs
 * alike, or NULL. */
void trial_screen(const struct diagnosis *d, const struct hypothesis *h, const struct trial *alike, struct trial *t);

/* Fits a trial to the end, with the base moved linearly. Its first steps must have succeeded. */
void trial_fit(const struct diagnosis *d, struct trial *t);

/* Fits base and effect together; a contradicted trial is also started from the current model. */
void trial_polish(const struct diagnosis *d, struct trial *t);

/* True if a trial that is not polished has a gain beyond doubt on the fitted cycles, but the
 * held-out cycles contradict it. This happens because the base was moved linearly, while its
 * Jacobian changes with the effect. For example, a spring's force at rest is its stiffness times
 * the shift that the joints' errors cause. */
bool trial_contradicted(const struct trial *t);

/* Gain of a trial; 0 if the held-out cycles contradict it, and -HUGE_VAL if the trial failed. */
double trial_sound_gain(const struct trial *t);

#endif
