/* Goodness of fit: the residuals of the held-out cycles, compared with noise and with the errors of
 * the effects' laws. Ordinary threads; heap. */
#ifndef HEXID_GOODNESS_H
#define HEXID_GOODNESS_H

#include "diagnose.h"

/* Mean squared white residual on held-out cycles above which more than noise is left; noise gives
 * about 1. */
enum { LEFT_WHITE = 2 };

/* Possible error of the laws of all effects, given or found, in squared white residuals over the
 * held-out cycles: the share law_error (effect.h) of each effect's contribution. The error of a law
 * is the same in all cycles, so averaging does not reduce it. An effect that explains no more than
 * this error explains nothing. */
double goodness_law_error(const struct diagnosis *d);

/* Sum of squared white residuals on held-out cycles, divided by the most that noise and laws (at
 * four times their error) explain. Above 1, some of the residuals are explained by neither. The
 * error of a leg's friction law is allowed in every value of the leg, because a seal's friction
 * varies along the stroke. INFINITY: the model cannot make the measured motion. */
double goodness_beyond_laws(const struct diagnosis *d);

/* Does the computation of goodness_beyond_laws() for any `rows` white values: their squares,
 * divided by the most that noise and laws explain. noise: mean square of each value's noise; 0: the
 * value is not evaluated. law: square of the laws' error in each value. Returns the larger of two
 * ratios. In one of them each value is weighted by its inverse variance, error of the laws
 * included, in the other by the square of this weight. So values with a large error of the laws do
 * not excuse the others. */
double goodness_weigh(int rows, const double *white, const double *noise, const double *law);

/* Largest sum of squared white residuals on held-out cycles that noise alone gives. */
double goodness_noise(const struct diagnosis *d);

#endif
