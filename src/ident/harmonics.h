/* Running least squares of several channels on [1, t, sin wt, cos wt, sin 2wt, cos 2wt, ...] (Tian
 * 2015 Eqs. 14-15). No heap, constant memory: only sums of products are kept, and the normal
 * equations are solved at the end.
 *
 * Normal equations are accurate enough here, because the regressors are nearly orthogonal over
 * whole periods. With each regressor scaled to unit length, their matrix has a condition number
 * below 4 ([1, t] alone has 3.7, for t from 0 to any T), so squaring the matrix costs one digit of
 * sixteen. In the tests the result differs by 3e-13 of the amplitude from that of an orthogonal
 * decomposition in extended precision, over 600 s. Squaring loses a residual that is small,
 * however: rms and std have a floor of about 1e-8 of the channel's rms. */
#ifndef HEXID_HARMONICS_H
#define HEXID_HARMONICS_H

#include "types.h"

enum { HARMONICS_MAX = 6, REGRESSORS_MAX = 2 + 2 * HARMONICS_MAX, CHANNELS_MAX = 12 };

struct harmonics {
    int harmonics, channels, regressors;
    double omega;                /* fundamental, rad/s */
    /* Time of the first sample: the drift counts from there, sines and cosines from t = 0. */
    double origin_s;
    int64_t samples;
    double offset[CHANNELS_MAX]; /* first sample of each channel, which is subtracted from all to
                                  * avoid cancellation */
    /* Row of a regressor: sums of its products with all regressors, then with all channels. */
    double product[REGRESSORS_MAX][REGRESSORS_MAX + CHANNELS_MAX];
    double square[CHANNELS_MAX]; /* sum over the samples of the square of each channel less its
                                  * offset */
};

struct harmonics_fit {
    /* constant: value at t = origin_s of the fitted line, whose slope is drift_per_s */
    double constant[CHANNELS_MAX], drift_per_s[CHANNELS_MAX];
    double sine[CHANNELS_MAX][HARMONICS_MAX], cosine[CHANNELS_MAX][HARMONICS_MAX];
    double rms[CHANNELS_MAX];    /* rms residual */
    /* Standard deviation of the fundamental's coefficients (rms of sine and cosine), if the
     * residual is white. */
    double std[CHANNELS_MAX];
    double condition;            /* condition number of the regressors' matrix, with scaled columns
                                  * (harmonics.c) */
};

/* Starts a fit of 1 .. HARMONICS_MAX harmonics to 1 .. CHANNELS_MAX channels. */
void harmonics_reset(struct harmonics *h, double omega, int harmonics, int channels);

/* Adds one sample; all values must be finite. */
void harmonics_add(struct harmonics *h, double t_s, const double *values);

/* Solves the fit. Returns false, and *fit all NaN, if there are not more samples than unknowns, or
 * if the data cannot distinguish the unknowns (condition number above 1e5: too short a time, a
 * harmonic at half the sampling rate). */
bool harmonics_solve(const struct harmonics *h, struct harmonics_fit *fit);

#endif
