/* Trial of a hypothesis beside the model: its values are fitted, the base is moved. Ordinary
 * threads; heap. */
#ifndef HEXID_TRIAL_H
#define HEXID_TRIAL_H

#include "diagnose.h"

#define TRIAL_LEAST 4.0 /* least gain in white squares on each half of the cycles; less is noise */
#define TRIAL_KEPT 0.5  /* least share of a gain that the held-out cycles must confirm; else it
                         * is contradicted */

struct trial {
    const struct hypothesis *hypothesis;
    bool ok;
    struct params model;                 /* fitted, with the base moved */
    double square, held_square;    /* sums of white squares of this model, as in struct diagnosis */
    double parameters;                   /* number of parameters that the data determine; the
                                          * others stay at their priors and explain nothing
                                          * (MacKay 1992, effective number of parameters) */
    double gain, held_gain;              /* gain: on the fitted cycles, less a penalty for each
                                          * parameter; held_gain: on the others */
    double std[HYPOTHESIS_VARIABLES];
    bool bound;
    bool as_found;       /* variables parallel to it keep their fitted values, not the given ones */
    bool polished;     /* base and effect are fitted together, instead of the base moved linearly */
};

/* Sum of white squares over all cycles; decides between candidates. */
static inline double trial_evidence(const struct trial *t) { return t->gain + t->held_gain; }

/* Gain on the fitted cycles without a penalty: the held-out cycles already count parameters. */
double trial_rise(const struct trial *t);

/* The same gain beyond the 1 that each parameter gains by chance. */
static inline double trial_fitted_gain(const struct trial *t) { return trial_rise(t) - t->parameters; }

/* Takes the first steps. alike: trial of the same effect with all legs alike, or NULL. */
void trial_screen(const struct diagnosis *d, const struct hypothesis *h, const struct trial *alike, struct trial *t);

/* Continues to the end with the base moved linearly; the first steps must have succeeded. */
void trial_fit(const struct diagnosis *d, struct trial *t);

/* Fits base and effect together; a contradicted trial also starts from the current model. */
void trial_polish(const struct diagnosis *d, struct trial *t);

/* True if the held-out cycles contradict the gain of the base's linear step: the base's columns
 * change with the effect (a spring's force at rest is its stiffness times the shift that the
 * joints cause). */
bool trial_contradicted(const struct trial *t);

/* A contradicted trial has gained nothing yet. */
double trial_sound_gain(const struct trial *t);

#endif
