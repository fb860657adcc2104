/* Residuals in units of their noise. For each test, leg and coefficient the three residuals share
 * noise: an error of length shows in the force and both pressures, an error of pressure in itself
 * and the force. Their covariance is the sum of the measured spread, of quantisation in step with
 * the motion, and of a floor for the error of any model; once whitened, all values count alike.
 * Pure. */
#ifndef HEXID_WHITEN_H
#define HEXID_WHITEN_H

#include "residual.h"

/* Inverse of the covariance's Cholesky factor, lower triangle, for each leg and coefficient. */
struct whitener {
    double inverse[LEGS][RESIDUAL_SIZE][RESIDUALS][RESIDUALS]; /* zero if not evaluated */
    /* variance due to the sensors' noise, in the units of the readings */
    double noise[LEGS][RESIDUAL_SIZE][RESIDUALS];
    int values;                                                /* number of evaluated values */
};

#define NOISE_ALONE 1e-6 /* a negligible model error */

/* model_error: share of each channel's rms variation that no model is blamed for. */
void whitener_init(struct whitener *w, const struct residual_test *t, const struct params *model, double model_error);

/* Variance of a coefficient of a leg's length due to rounding in step with a sinusoid, m^2. It is 0
 * for any other motion, whose rounding is ordinary noise. */
double whiten_in_step(const struct residual_test *t, const struct params *model, int leg);

/* Standard deviation by noise of each leg's force residual at an instant, N: rms over the test. */
void whiten_force_std(const struct residual_test *t, const struct params *model, double std_n[LEGS]);

/* Mean squares that noise of pushes and lengths gives a rod's path in its backlash. */
void whiten_play_noise(const struct residual_test *t, const struct params *model, struct play_noise *noise);

/* Mass in the space of the legs at neutral, J'^-1 M J^-1, kg: forces for their accelerations. */
void whiten_leg_mass(const struct params *model, double lambda[LEGS][LEGS]);

/* Whitens a row in place. */
void whiten(const struct whitener *w, residual_row row);

#endif
