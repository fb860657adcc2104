/* Goodness of fit: what is left on the cycles held out, beside what noise and the laws of the
 * effects make of them. Ordinary threads; heap. */
#ifndef HEXID_GOODNESS_H
#define HEXID_GOODNESS_H

#include "diagnose.h"

/* Sum of white squares, of the cycles held out, by which the laws of the effects there are, given
 * or found, may be off: of each its law_error's share (effect.h) of what it contributes. A law that
 * is off is so everywhere alike: noise does not hide it, however long it is averaged, and what
 * explains no more than that explains nothing. */
double goodness_law_error(const struct diagnosis *d);

/* White squares, held out, over what noise and laws, at four times their error, make of them beyond
 * doubt: above 1 something is left. Here a leg's friction may be off by as much along its stroke,
 * too. INFINITY: the model cannot make this motion. */
double goodness_beyond_laws(const struct diagnosis *d);

/* The same ratio of any rows: the mean square that noise has in each, 0 where nothing was
 * evaluated, and the square of its law error. The larger of two sums: each row in units of its
 * variance, laws in it; and weighed by the inverse of that once more, so that rows that they excuse
 * lend nothing to the others. */
double goodness_weigh(int rows, const double *white, const double *noise, const double *law);

/* Most white squares, held out, that noise alone makes. */
double goodness_noise(const struct diagnosis *d);

#endif
