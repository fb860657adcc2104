/* Inverse dynamics of platform and legs over the whole workspace: leg forces that a motion needs,
 * without friction. The platform has the Newton-Euler equations; the legs' equations follow from
 * their kinetic energy. The constants include the configured effects (sim/machine.h), such as a
 * payload's mass and centre, a tilt, or springs on the platform; the joints are at their configured
 * positions. This module shares no equation of motion with sim/ and src/residual. Pure, RT, no
 * heap.
 *
 *  symbol    meaning                                                 unit    frame
 *  c, w      origin of {M}; angular rate                             m, 1/s  {B}
 *  s         payload's mass centre, from c                           m       {B}
 *  F, M      wrench of springs on the platform, about c              N, N m  {B}
 *  q = Ta    lever arm of an upper joint                             m       {B}
 *  l, L, n   leg vector, its length and direction                    m       {B}
 *  ma, mb    masses of rod and cylinder                              kg
 *  G         transverse inertia ma (L-ra)^2 + mb rb^2 + ia + ib      kg m^2
 *  S         first moment ma (L-ra) + mb rb                          kg m
 *  R         transverse force of the platform on the leg's end       N       {B}
 *
 *     L R = 2 ma (L-ra) L' n' + G P n'' - S g P z,                P = I - n n'
 *     p    = m (c'' + s'' - g z)
 *     J' h = [p - F + sum R;  I w' + w x I w + s x p - M + sum q x R]
 *     f    = h + ma (L'' - (L-ra) |n'|^2 - g n.z)
 *
 * h is the force on the platform along the leg, f the force of the oil less friction, z the unit
 * vector down. */
#ifndef HEXID_DYNAMICS_H
#define HEXID_DYNAMICS_H

#include "kinematics.h"
#include "machine.h"
#include "trajectory.h"

struct dynamics {
    const struct kinematics *kinematics;
    double mass_kg, gravity_mps2[3]; /* g z, in {B} */
    double inertia_kg_m2[3][3];      /* payload's, about its mass centre, axes of {M} */
    double center_m[3];              /* payload's mass centre in {M} */
    struct active wrench;            /* active effects that exert a wrench on the platform */
    struct {
        double rod_kg, rod_center_m;    /* ma, ra */
        double moment_kg_m;             /* mb rb */
        double inertia_kg_m2;           /* mb rb^2 + ia + ib, plus the effects' additions */
    } leg[LEGS];
};

/* Motion of the legs, and the force of the oil, less friction, that this motion needs. */
struct leg_course {
    double length_m[LEGS], rate_mps[LEGS], accel_mps2[LEGS], force_n[LEGS];
};

/* Prepares the constants; params and kinematics must outlive them. */
void dynamics_init(struct dynamics *d, const struct params *params, const struct kinematics *kinematics);

/* Computes the motion and force of the legs from pose, rates and accelerations. Returns false if
 * the legs do not determine the platform in this pose (singular), or if a number is not finite. */
bool dynamics_solve(const struct dynamics *d, double motion[MOTION_ORDERS][DOFS], struct leg_course *course);

/* Finds the inertia matrix of platform and legs at neutral in leg coordinates, kg: element [i][j]
 * is the force of leg i per acceleration of leg j. Returns false if the legs do not determine the
 * platform there, or a number is not finite. Not RT. */
bool dynamics_inertia(const struct params *params, const struct kinematics *kinematics, double inertia[LEGS][LEGS]);

#endif
