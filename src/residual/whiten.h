/* Converts residuals to units of their noise. In each test, leg and coefficient the three residuals
 * share noise: an error of length changes the force and both pressures, an error of a pressure
 * changes this pressure and the force. The covariance of the three is the sum of the measured
 * spread, of rounding in step with the motion, and of a least error that any model has. Once
 * whitened, all values count alike. Pure. */
#ifndef HEXID_WHITEN_H
#define HEXID_WHITEN_H

#include "residual.h"

/* Whitener of a test: inverse of the Cholesky factor of the residuals' covariance, lower triangle,
 * for each leg and coefficient. */
struct whitener {
    double inverse[LEGS][RESIDUAL_SIZE][RESIDUALS][RESIDUALS]; /* zero for residuals that are not
                                                                * evaluated */
    /* variance of each residual by the sensors' noise, in the units of the readings */
    double noise[LEGS][RESIDUAL_SIZE][RESIDUALS];
    int values;                                                /* number of evaluated values: legs
                                                                * times residuals times
                                                                * coefficients */
};

#define NOISE_ALONE 1e-6 /* model_error so small that only the sensors' noise counts */

/* Makes the whitener of a test. model_error: share of each channel's rms variation that counts as
 * noise, because every model has an error of this size. A force that a sensor or drive measures has
 * the sensor's error instead. */
void whitener_init(struct whitener *w, const struct residual_test *t, const struct params *model, double model_error);

/* Standard deviation of each leg's force residual by noise, N: rms over the instants of the
 * test. */
void whiten_force_std(const struct residual_test *t, const struct params *model, double std_n[LEGS]);

/* Mean squares that the noise of forces and lengths gives a rod's path in its backlash. */
void whiten_play_noise(const struct residual_test *t, const struct params *model, struct play_noise *noise);

/* Whitens the residuals of a test in place. */
void whiten(const struct whitener *w, residual_row row);

#endif
