/* Arithmetic helpers. Pure, RT. */
#ifndef HEXID_NUMERIC_H
#define HEXID_NUMERIC_H

/* Half the width of a normal distribution's 95 % interval, in standard deviations. "+-" and "±" in
 * texts for people are this half-width; JSON has standard deviations. */
#define NUMERIC_95 1.96

static inline double square(double x) { return x * x; }

#endif
