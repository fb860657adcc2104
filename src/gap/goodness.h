/* Goodness of fit: residuals of the held-out cycles compared with noise and the errors of the
 * effects' laws. Ordinary threads; heap. */
#ifndef HEXID_GOODNESS_H
#define HEXID_GOODNESS_H

#include "diagnose.h"

/* Possible error of the laws of all effects, given or found, in white squares over the held-out
 * cycles: the share law_error (effect.h) of each effect's contribution. An error of a law is the
 * same in all cycles, so averaging does not reduce it, and an effect that explains no more than
 * it explains nothing. */
double goodness_law_error(const struct diagnosis *d);

/* White squares on held-out cycles relative to the most that noise and laws (at four times their
 * error) explain: above 1 something is left. Here the same error of a leg's friction is also
 * allowed along its stroke. INFINITY: the model cannot make this motion. */
double goodness_beyond_laws(const struct diagnosis *d);

/* The same ratio for any rows: mean square of the noise of each (0 if not evaluated), and square
 * of its law error. Returns the larger of two ratios: with each row weighted by the inverse of
 * its variance, law error included; and by the square of that, so that rows with large law
 * errors do not excuse the others. */
double goodness_weigh(int rows, const double *white, const double *noise, const double *law);

/* Largest sum of white squares on held-out cycles that noise alone gives. */
double goodness_noise(const struct diagnosis *d);

#endif
