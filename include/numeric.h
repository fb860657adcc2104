/* Arithmetic helpers. Pure, RT. */
#ifndef HEXID_NUMERIC_H
#define HEXID_NUMERIC_H

/* Half a 95 % interval of a normal distribution, in standard deviations: "+-" and "±" mean this to
 * people; JSON has the standard deviations. */
#define NUMERIC_95 1.96

static inline double square(double x) { return x * x; }

#endif
