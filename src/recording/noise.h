/* Sensor noise of a signal that moves slowly against its sampling: white noise and quantisation.
 * Pure, no heap, any thread. */
#ifndef HEXID_NOISE_H
#define HEXID_NOISE_H

#include <stddef.h>

struct noise {
    /* Rms of the white noise, as the median over time, from fourth differences, on which motion
     * slower than a tenth of the sampling rate has little effect. The result is at least the
     * quantisation noise, step / sqrt(12). Without five successive finite values it is the
     * quantisation noise, or NaN if no step is found. */
    double rms;
    /* Resolution of the sensor: at least 95 % of the differences between successive values are
     * multiples of this step; 0 if no step is found. */
    double step;
};

/* Measures `count` values, `stride` doubles apart. Values that are not finite are skipped. */
struct noise noise_measure(int count, const double *x, size_t stride);

#endif
