/* A hypothesis tried beside the model so far: its values fitted, the base moved. Ordinary threads;
 * heap. */
#ifndef HEXID_TRIAL_H
#define HEXID_TRIAL_H

#include "diagnose.h"

#define TRIAL_LEAST 4.0 /* of white squares, gained on either half of the cycles: less is noise */
#define TRIAL_KEPT 0.5  /* of a gain, by the cycles held out: else it is contradicted */

struct trial {
    const struct hypothesis *hypothesis;
    bool ok;
    struct params model;                 /* fitted, base moved too */
    double square, held_square;          /* of this model, as in struct diagnosis */
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

/* That, beyond the 1 that each parameter gains by chance. */
static inline double trial_fitted_gain(const struct trial *t) { return trial_rise(t) - t->parameters; }

/* The first steps. alike: the same effect, all legs alike, or NULL. */
void trial_screen(const struct diagnosis *d, const struct hypothesis *h, const struct trial *alike, struct trial *t);

/* On from there to its end, the base moved linearly; the first steps succeeded. */
void trial_fit(const struct diagnosis *d, struct trial *t);

/* Base and effect fitted together; what is contradicted from the model so far, too. */
void trial_polish(const struct diagnosis *d, struct trial *t);

/* What the base's linear step gained on the fitted cycles is not there on the others: beside this
 * effect the base's columns are others. What a spring does at rest is its stiffness times the shift
 * that the joints cause. */
bool trial_contradicted(const struct trial *t);

/* What is contradicted has gained nothing yet. */
double trial_sound_gain(const struct trial *t);

#endif
