/* Arithmetic helpers. Pure, RT. */
#ifndef HEXID_NUMERIC_H
#define HEXID_NUMERIC_H

static inline double square(double x) { return x * x; }

#endif
