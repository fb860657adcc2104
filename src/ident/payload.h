/* The payload's ten parameters from an inertia matrix: what is left of Mt when the legs, as
 * configured, are subtracted, as one rigid body.
 *
 *   Mt - legs = [m 1, -[h]x; [h]x, Io],   h = m c,   Io = Ic + m (c'c 1 - c c')
 *
 * about the origin of {M}, the mass centre as configured; [h]x is the matrix of the cross product.
 * 21 entries, ten parameters: generalised least squares with the entries' covariance, to which the
 * legs' masses add what model.tolerance.mass leaves open. A body of positive density has a positive
 * definite pseudo-inertia [tr(Io)/2 1 - Io, h; h', m]; where the ten parameters have none,
 * the nearest that have one are given beside them (a search over its Cholesky factor).
 * Pure, no heap. */
#ifndef HEXID_PAYLOAD_H
#define HEXID_PAYLOAD_H

#include "kinematics.h"
#include "params.h"

enum { MATRIX_ENTRIES = DOFS * (DOFS + 1) / 2 }; /* (1,1) (1,2) .. (1,6) (2,2) .. (6,6) */
enum { PAYLOAD_MASS, PAYLOAD_CENTER, PAYLOAD_INERTIA = PAYLOAD_CENTER + 3, PAYLOAD_VALUES = PAYLOAD_INERTIA + 6 };
extern const char *const payload_names[PAYLOAD_VALUES]; /* "mass_kg", "center_x_m" ..,
                                                         * "inertia_xx_kg_m2" yy zz xy xz yz */

struct payload {
    bool evaluated;                     /* false: not even the mass is determined */
    bool whole;                         /* all ten are determined; else those that are not are NaN,
                                         * and `possible` and `nearest` say nothing */
    double value[PAYLOAD_VALUES];       /* the centre from the configured one, in {M}; inertias
                                         * about it, xy xz yz as entries of the tensor */
    double std[PAYLOAD_VALUES];
    bool possible;                      /* a body of positive density has these */
    double nearest[PAYLOAD_VALUES];     /* the nearest that such a body has; `value`, where
                                         * possible */
    double misfit;                      /* of the matrix from that of one body, rms in standard
                                         * deviations: about 1 */
};

/* entry: of Mt; covariance: of the entries. */
struct payload payload_find(const struct params *params, const struct kinematics *k, const double entry[MATRIX_ENTRIES],
                            double covariance[MATRIX_ENTRIES][MATRIX_ENTRIES]);

/* The inertia matrix of legs as configured and this payload (`value`) in any pose, about the
 * origin of {M}, in {B}. */
void payload_matrix(const struct payload *p, const struct params *params, const struct kinematics *k, const double pose[DOFS],
                    double mt[DOFS][DOFS]);

#endif
