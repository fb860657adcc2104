/* Rates of the universal joints' axes, for joint friction in the closed-form engine. Pure, RT.
 *
 * n and L are the leg's direction and length (rigid.h), v the velocity of its upper joint. The
 * first axis E is fixed in the base or the platform; the second one, E x n / s with s = |E x n|, in
 * the cylinder or rod. W = n x v / L is the leg's angular velocity across its axis, w the angular
 * velocity of the base (0) or of the platform. The two rates are (W - w) . d with d1 = (E - n
 * (n.E)) / s^2 and d2 = E x n / s. Spin about n, which the rod is free to take, drops out of
 * both. */
#ifndef HEXID_JOINT_AXES_H
#define HEXID_JOINT_AXES_H

#include "rigid.h"

/* Order of a leg's axes: first and second of the lower joint, first and second of the upper
 * joint. */
enum { JOINT_AXES_PER_LEG = 4, JOINT_AXES = JOINT_AXES_PER_LEG * LEGS };

struct joint_axes {
    double row[JOINT_AXES][DOFS]; /* rate about an axis = row . twist; a moment m about the axis
                                   * adds row' m to the load */
    double bias[JOINT_AXES];      /* acceleration about the axis while the twist is constant */
};

void joint_axes(const struct rigid_model *m, const struct rigid_state *s, const struct rigid_legs *legs, struct joint_axes *axes);

#endif
