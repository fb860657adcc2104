/* Friction of legs that may be held, as uncertainty of the residuals. A leg that sticks resists any
 * load up to the limit of its dry friction, so a model with dry friction says little about what a
 * leg does at rest. If the evidence took the friction there from the balance of forces, as the fit
 * does, dry friction would explain noise and errors of every kind, and a model with more of it
 * would be likelier. Ordinary threads; heap. */
#ifndef HEXID_HELD_H
#define HEXID_HELD_H

#include "covariance.h"

/* Rows of a leg that may be held, in one test: index of the first row, number of rows, and the
 * covariance that the leg's friction adds to the coefficients of its force, N^2. */
struct held_rows {
    int first, rows;
    double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE];
};

struct held {
    int places;
    struct held_rows *place;
    int *coefficient; /* [rows]: index of the coefficient that each evaluated row belongs to */
    double *per_n;    /* [rows]: derivative of the row, in units of the noise, with respect to the
                       * coefficient of the force, 1/N */
};

/* Finds the legs that friction may hold, according to the model of a diagnosis. rows: number of
 * evaluated values. variance: [values], the variances that its whiteners assume, relative to those
 * of the noise. */
void held_init(struct held *h, const struct diagnosis *d, const struct covariance *c, int rows, const double *variance);
void held_free(struct held *h);

/* Computes white residuals and columns of the diagnosis as if all legs slid. The friction of a leg
 * that may be held then does not follow the balance of forces; held_whiten() adds its
 * uncertainty. */
void held_residuals(const struct diagnosis *d, double *white, double *column);

/* Adds the uncertain friction to the covariance of white residuals and columns, [columns][rows],
 * and whitens them again. weight: [rows], factors by which the rows, in units of the noise, were
 * multiplied. Returns the log of the determinant by which the covariance of the rows grew. */
double held_whiten(const struct held *h, int rows, const double *weight, double *white, int columns, double *column);

#endif
