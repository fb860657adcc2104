/* What a sensor adds to a signal that moves slowly against its sampling: white noise and steps.
 * Pure, no heap, any thread. */
#ifndef HEXID_NOISE_H
#define HEXID_NOISE_H

#include <stddef.h>

struct noise {
    double rms;  /* white part, by fourth differences, the median over time: motion below a tenth of
                  * the rate hardly counts. At least what the steps make, step / sqrt(12). NaN:
                  * fewer than five numbers in a row */
    double step; /* the sensor's: all differences are multiples of it; 0: none is seen */
};

/* Of count values, stride doubles apart; what is not finite is passed over. */
struct noise noise_measure(int count, const double *x, size_t stride);

#endif
