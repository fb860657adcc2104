/* The 13 rigid bodies of the machine in ODE: platform, six cylinders, six rods. Each leg has a
 * universal joint at each end and a piston joint in which the rod may rotate in the cylinder; their
 * 72 constraint rows leave 6 degrees of freedom. Frame of a leg's part: z along the leg away from
 * the base, x the second axis of its universal joint.
 *
 * A leg with backlash has a prismatic and universal joint at its rod's end instead: the rod slides
 * along the leg, and the platform feels machine_contact.
 *
 * Dry friction is a motor whose target velocity is zero and whose greatest force is the limit of
 * the friction. A motor without force costs nothing; one with force adds a row to the
 * complementarity problem of ODE's step.
 *
 * Any thread may step the machine, one at a time: ODE keeps no state per thread. No heap after
 * ode_machine_init. */
#ifndef HEXID_ODE_MACHINE_H
#define HEXID_ODE_MACHINE_H

#include <ode/ode.h>

#include "engine.h"

enum { PLATFORM, CYLINDER, ROD = CYLINDER + LEGS, BODIES = ROD + LEGS };

struct velocity {
    dVector3 linear, angular; /* velocities of the mass centre, in {B} */
};

struct ode_machine {
    const struct params *params;
    struct machine machine;
    struct sim_geometry geometry;         /* positions of the joints and directions of their axes */
    dWorldID world;
    dBodyID body[BODIES];
    dJointID piston[LEGS];
    dJointFeedback feedback[LEGS];             /* forces of the pistons in the last step */
    dJointID lower_rub[LEGS], upper_rub[LEGS]; /* angular motors about the two axes of the lower and
                                                * of the upper universal joint; only with joint
                                                * friction */
    double neutral_moment_kg_m;             /* sum of mass times depth over all bodies at neutral */
};

/* Makes the machine at rest at neutral. params must outlive it. Returns 0, or -1 if there is no
 * memory or no bodies can have these masses. */
int ode_machine_init(struct ode_machine *m, const struct params *params);
void ode_machine_free(struct ode_machine *m);

/* Moves every body to its place in this pose; velocities stay. ahead_m: distance of each rod ahead
 * of its joint. */
void ode_machine_place(struct ode_machine *m, const double pose[DOFS], const double ahead_m[LEGS]);

void ode_machine_pose(const struct ode_machine *m, double pose[DOFS]);

/* Computes the unit vector along a leg's cylinder, away from the base. */
void ode_machine_axis(const struct ode_machine *m, int leg, dVector3 axis);

/* Returns a leg's length up to the rod's end, from the bodies of cylinder and rod. */
double ode_machine_length(const struct ode_machine *m, int leg, const dVector3 axis);

/* Computes the position of a leg's joint on the platform, in {B}. */
void ode_machine_joint(const struct ode_machine *m, int leg, dVector3 point);

/* Computes the twist of the platform, whose velocity is given at its mass centre, at the origin of
 * {M}. */
void ode_machine_twist(const struct velocity *platform, const struct ode_machine *m, double twist[DOFS]);

/* Sets an acceleration of all bodies that replaces gravity, m/s^2 in {B}. */
void ode_machine_pull(struct ode_machine *m, const double pull[3]);

/* Adds the wrench of the effects, which ODE does not know. To be called before every step. */
void ode_machine_load(struct ode_machine *m);

/* Returns the potential energy of all bodies, J; zero at neutral. Meaningless while the base moves
 * (ode_machine_pull). */
double ode_machine_potential(const struct ode_machine *m);

struct velocity ode_machine_velocity(const struct ode_machine *m, int body);
void ode_machine_set_velocity(struct ode_machine *m, int body, const struct velocity *v, double scale);

#endif
