/* Sensor noise of a signal that moves slowly against its sampling: white noise and quantisation.
 * Pure, no heap, any thread. */
#ifndef HEXID_NOISE_H
#define HEXID_NOISE_H

#include <stddef.h>

struct noise {
    /* White noise, from fourth differences, as the median over time: motion slower than a tenth of
     * the sampling rate hardly counts. It is at least the quantisation noise, step / sqrt(12).
     * Without five successive finite values it is the quantisation noise, or NaN if no step is
     * found. */
    double rms;
    /* Resolution of the sensor: at least 95 % of the differences are multiples of it; 0 if none is
     * found. */
    double step;
};

/* Measures `count` values, `stride` doubles apart. Values that are not finite are skipped. */
struct noise noise_measure(int count, const double *x, size_t stride);

#endif
