/* The payload's ten parameters from an inertia matrix: the configured legs are subtracted from Mt,
 * and the remainder is one rigid body.
 *
 *   Mt - legs = [m 1, -[h]x; [h]x, Io],   h = m c,   Io = Ic + m (c'c 1 - c c')
 *
 * about the origin of {M}, the configured mass centre; [h]x is the matrix of the cross product. 21
 * entries yield ten parameters by generalised least squares with the entries' covariance, to which
 * the tolerance of the legs' masses (model.tolerance.mass) is added. A body of positive density has
 * a positive definite pseudo-inertia [tr(Io)/2 1 - Io, h; h', m]. If the ten parameters belong to
 * no such body, the nearest ones that do are found as well (a search over the Cholesky factor of
 * the pseudo-inertia). Pure, no heap. */
#ifndef HEXID_PAYLOAD_H
#define HEXID_PAYLOAD_H

#include "kinematics.h"
#include "types.h"

/* Number of entries of a symmetric matrix, in the order (1,1) (1,2) .. (1,6) (2,2) .. (6,6). */
enum { MATRIX_ENTRIES = DOFS * (DOFS + 1) / 2 };
enum { PAYLOAD_MASS, PAYLOAD_CENTER, PAYLOAD_INERTIA = PAYLOAD_CENTER + 3, PAYLOAD_VALUES = PAYLOAD_INERTIA + 6 };
/* "mass_kg", "center_x_m" .., "inertia_xx_kg_m2", then yy zz xy xz yz */
extern const char *const payload_names[PAYLOAD_VALUES];

struct payload {
    bool evaluated;                     /* false: even the mass is not determined */
    /* All ten values are determined. Otherwise the undetermined ones are NaN, and `possible` and
     * `nearest` mean nothing. */
    bool whole;
    /* Mass; centre, relative to the configured one, in {M}; inertias about the centre, with xy xz
     * yz signed as in the tensor. */
    double value[PAYLOAD_VALUES];
    double std[PAYLOAD_VALUES];
    bool possible;                      /* a body of positive density can have these values */
    /* Values of the nearest body of positive density; equal to `value` if `possible`. */
    double nearest[PAYLOAD_VALUES];
    /* Squared distance of the ten numbers from that body, weighted by their covariance; 0 if
     * `possible`. For a true body it is at most chi-square distributed with ten degrees of
     * freedom. */
    double impossible;
    /* Rms difference between the payload's part of the matrix and the nearest matrix of one rigid
     * body, in standard deviations; about 1 if the payload is one body. */
    double misfit;
};

/* Finds the inverse covariance of the prior for corrections of the matrix entries. In the prior
 * three things vary: the payload, which may be any one rigid body; the legs' masses, within
 * model.tolerance.mass; and each entry by itself, with a standard deviation of `rigidity` times
 * sqrt(M_ii M_jj), so that with a rigidity of 1 the entries are free. Returns false if the
 * configured machine has no inertia. */
bool payload_prior(const struct params *params, const struct kinematics *k, double rigidity,
                   double inverse[MATRIX_ENTRIES][MATRIX_ENTRIES]);

/* Finds the payload. entry: entries of Mt. covariance: covariance of the entries. */
struct payload payload_find(const struct params *params, const struct kinematics *k, const double entry[MATRIX_ENTRIES],
                            double covariance[MATRIX_ENTRIES][MATRIX_ENTRIES]);

/* True if a body of positive density can have these values (as in struct payload). */
bool payload_possible(const double value[PAYLOAD_VALUES]);

/* Writes these values into a configuration. Their centre is relative to the configured centre, and
 * is added to it. */
struct payload_params;
void payload_configure(const double value[PAYLOAD_VALUES], struct payload_params *configured);

/* Inertia matrix of the configured legs with this payload in any pose, about the origin of {M}, in
 * {B}. */
void payload_matrix(const struct payload *p, const struct params *params, const struct kinematics *k, const double pose[DOFS],
                    double mt[DOFS][DOFS]);

#endif
