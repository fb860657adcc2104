/* The inertia matrix that the configuration implies, in closed form (Tian 2015 Eqs. A1-A6; inertias
 * of the legs' parts about their own mass centres, docs/method.md, 3). The matrix multiplies xddot
 * = [acceleration of the origin of {M}; angular acceleration], both in {B}. Pure, no heap. */
#ifndef HEXID_NOMINAL_H
#define HEXID_NOMINAL_H

#include "kinematics.h"
#include "types.h"

void nominal_matrix(const struct params *params, const struct kinematics *k, const double pose[DOFS], double mt[DOFS][DOFS]);

#endif
