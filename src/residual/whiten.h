/* Residuals in units of their noise. For each test, leg and coefficient the three residuals share
 * noise: a wrong length shows in the force and both pressures, a wrong pressure in itself and the
 * force. Their covariance is built from the measured spread, from quantisation in step with the
 * motion, and from a floor that no model is expected to meet; once whitened, all values count
 * alike. Pure. */
#ifndef HEXID_WHITEN_H
#define HEXID_WHITEN_H

#include "residual.h"

/* Inverse of the covariance's Cholesky factor, lower triangle, for each leg and coefficient. */
struct whitener {
    double inverse[LEGS][RESIDUAL_SIZE][RESIDUALS][RESIDUALS]; /* zero for what is not evaluated */
    /* variance that the sensors' noise gives, in the units of the readings */
    double noise[LEGS][RESIDUAL_SIZE][RESIDUALS];
    int values;                                                /* evaluated */
};

#define NOISE_ALONE 1e-6 /* a model error that counts for nothing */

/* model_error: share of each channel's rms variation that is not held against any model. */
void whitener_init(struct whitener *w, const struct residual_test *t, const struct params *model, double model_error);

/* Variance of a coefficient of a leg's length due to rounding in step with a sinusoid, m^2; 0 for
 * any other motion, where rounding is noise like any other. */
double whiten_in_step(const struct residual_test *t, const struct params *model, int leg);

/* Standard deviations that noise gives the force residual of each leg at an instant, N: rms of its
 * row over the test. */
void whiten_force_std(const struct residual_test *t, const struct params *model, double std_n[LEGS]);

/* What noise of pushes and lengths makes of a rod's way in its play. */
void whiten_play_noise(const struct residual_test *t, const struct params *model, struct play_noise *noise);

/* Mass in the space of the legs at neutral, J'^-1 M J^-1, kg: the forces that an acceleration of
 * each leg needs. */
void whiten_leg_mass(const struct params *model, double lambda[LEGS][LEGS]);

/* Turns a row into white values, in place. */
void whiten(const struct whitener *w, residual_row row);

#endif
