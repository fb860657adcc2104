/* Arithmetic helpers. Pure, RT. */
#ifndef HEXID_NUMERIC_H
#define HEXID_NUMERIC_H

#include <math.h>
#include <stdbool.h>

/* Half the width of a normal distribution's 95 % interval, in standard deviations. "+-" and "±" in
 * texts for people are this half-width; JSON has standard deviations. */
#define NUMERIC_95 1.96

static inline double square(double x) { return x * x; }

static inline bool all_finite(int count, const double *x) {
    for (int i = 0; i < count; i++)
        if (!isfinite(x[i])) return false;
    return true;
}

#endif
