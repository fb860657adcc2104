/* The 13 rigid bodies of the machine in ODE: platform, six cylinders, six rods; per leg a universal
 * joint at each end and a piston joint that lets the rod turn in the cylinder: 72 constraint rows
 * leave 6 degrees of freedom. Frame of a leg's part: z along the leg away from the base, x the
 * second axis of its universal joint.
 *
 * A leg with play has a prismatic and universal joint at its rod's end instead: the rod slides
 * along the leg, and the platform feels machine_contact.
 *
 * Apparent axial inertia (machine.h), which no rigid body has, is a mass on the rod at the lower
 * joint of the neutral leg: there it takes no part in the leg's turning but by the square of the
 * stroke used. Such a leg's bodies do without ODE's gravity.
 *
 * Motors at rest velocity stand for dry friction, their greatest force for its limit. A motor
 * without force costs nothing; with it, it adds a row to the complementarity problem of ODE's step.
 *
 * Any thread may step it, one at a time: ODE keeps nothing of it with a thread. No heap after
 * ode_machine_init. */
#ifndef HEXID_ODE_MACHINE_H
#define HEXID_ODE_MACHINE_H

#include <ode/ode.h>

#include "engine.h"

enum { PLATFORM, CYLINDER, ROD = CYLINDER + LEGS, BODIES = ROD + LEGS };

struct velocity {
    dVector3 linear, angular; /* of the mass centre, in {B} */
};

struct ode_machine {
    const struct params *params;
    struct machine machine;
    struct sim_geometry geometry;              /* the joints' axes */
    dWorldID world;
    dBodyID body[BODIES];
    dJointID piston[LEGS];
    dJointFeedback feedback[LEGS];             /* of the pistons, from the last step */
    dJointID lower_rub[LEGS], upper_rub[LEGS]; /* angular motors about the universal joints' two
                                                * axes; only with joint friction */
    double neutral_moment_kg_m;                /* sum of mass times depth */
};

/* At neutral, at rest. params must outlive the machine. Returns 0, or -1 without memory or with
 * masses that no bodies can have. */
int ode_machine_init(struct ode_machine *m, const struct params *params);
void ode_machine_free(struct ode_machine *m);

/* Moves every body to where it is in this pose, rods so far ahead of their joints;
 * velocities stay. */
void ode_machine_place(struct ode_machine *m, const double pose[DOFS], const double ahead_m[LEGS]);

void ode_machine_pose(const struct ode_machine *m, double pose[DOFS]);

/* Unit vector along the leg away from the base, of the cylinder. */
void ode_machine_axis(const struct ode_machine *m, int leg, dVector3 axis);

/* Up to the rod's end, from cylinder and rod. */
double ode_machine_length(const struct ode_machine *m, int leg, const dVector3 axis);

/* The platform's joint of a leg, in {B}. */
void ode_machine_joint(const struct ode_machine *m, int leg, dVector3 point);

/* The platform's velocity at the origin of {M}. */
void ode_machine_twist(const struct velocity *platform, const struct ode_machine *m, double twist[DOFS]);

/* What pulls at all bodies instead of gravity, m/s^2 in {B}. */
void ode_machine_pull(struct ode_machine *m, const double pull[3]);

/* Puts on what ODE does not know: the effects' wrench. Before every step. */
void ode_machine_load(struct ode_machine *m);

/* Of all bodies, J; zero at neutral. */
double ode_machine_potential(const struct ode_machine *m);

struct velocity ode_machine_velocity(const struct ode_machine *m, int body);
void ode_machine_set_velocity(struct ode_machine *m, int body, const struct velocity *v, double scale);

#endif
