/* Residuals in units of their noise. For each test, leg and harmonic the three residuals share
 * noise: a wrong length shows in force and in both pressures, a wrong pressure in its own and in
 * the force. Their covariance is built from the measured spread, from quantisation in step with the
 * motion, and from a floor of what no model meets; whitened, all values count alike. Pure. */
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

/* model_error: share of each channel's variation that is not held against any model. */
void whitener_init(struct whitener *w, const struct residual_test *t, const struct params *model, double model_error);

/* Variance of a coefficient of a leg's length that rounding in step with a sinusoid makes, m^2; in
 * any other motion rounding is noise as any, and this is 0. */
double whiten_in_step(const struct residual_test *t, const struct params *model, int leg);

/* Leg-space mass at neutral, J'^-1 M J^-1: what force an acceleration of each leg needs, kg. */
void whiten_leg_mass(const struct params *model, double lambda[LEGS][LEGS]);

/* row to white values, in place. */
void whiten(const struct whitener *w, residual_row row);

#endif
