/* Sensor noise of a signal that moves slowly against its sampling: white noise and quantization.
 * Pure, no heap, any thread. */
#ifndef HEXID_NOISE_H
#define HEXID_NOISE_H

#include <stddef.h>

struct noise {
    /* White part, from fourth differences, median over time: motion below a tenth of the sampling
     * rate hardly counts. At least the quantization noise, step / sqrt(12), which stands alone if
     * no five values in a row are finite; NaN if no step is seen either: nothing is known then. */
    double rms;
    /* Resolution of the sensor: all differences are multiples of it; 0 if none is seen. */
    double step;
};

/* Measures `count` values, `stride` doubles apart; values that are not finite are skipped. */
struct noise noise_measure(int count, const double *x, size_t stride);

#endif
