/* The platform and its six legs in closed form: 6 degrees of freedom, 13 bodies. Pure, RT.
 *
 * From the Lagrangian of docs/method.md section 3, with all velocity terms:
 *
 *   T_leg = ma Ldot^2/2 + g(L) Omega^2/2,   Omega = |v_perp| / L
 *   g(L) = ma (L-ra)^2 + mb rb^2 + ia + ib
 *
 * where v is the velocity of the upper joint and v_perp its part across the leg; ma, ra, ia are the
 * rod's and mb, rb, ib the cylinder's mass, centre and inertia (params/actuator.h). With
 * f(L) = g/L^2 the force that moves the leg at its upper joint, whose acceleration is a, is
 *
 *   f a + (ma - f) n (n.a) + f' Ldot v_perp + ma ra |v_perp|^2/L^2 n
 *       - ma grav - (mb rb - ma ra)/L (grav - n (n.grav))
 *
 * A payload whose mass centre is off the origin adds the terms of a point mass. The part of grav
 * across z, in a machine that does not stand level, is added separately.
 *
 *  symbol   meaning                                                 frame
 *  n, L     unit vector from the lower to the upper joint, length   {B}
 *  T        rotation matrix from {M} to {B}
 *  rho      upper joint from the origin of {M}                      {B}
 *  twist    velocity of the origin of {M}, angular velocity         {B}
 *  J        leg rates = J twist, row [n, rho x n]
 *
 * This way mass and load need no 3x3 products:
 *
 *   M = blkdiag(m I, T Ic T') + sum (ma - f) J_i' J_i + sum f [I, -rho~; rho~, -rho~ rho~] */
#ifndef HEXID_RIGID_H
#define HEXID_RIGID_H

#include "engine.h"
#include "machine.h"
#include "types.h"

struct rigid_model {
    struct machine machine;
    struct sim_geometry geometry; /* positions of the joints and directions of their axes */
    double upper[3][LEGS], lower[3][LEGS]; /* positions of the joints, one array for each
                                            * coordinate */
    double mass, inertia[3][3], gravity;      /* mass of the payload; its inertia about its own mass
                                               * centre, in {M}; gravity along z, m/s^2 */
    bool offset;                                   /* the payload's mass centre is off the origin of
                                                    * {M} */
    double upper_center[LEGS];       /* distance ra of the rod's mass centre from the upper joint */
    double upper_mass[LEGS], upper_moment[LEGS], lower_moment[LEGS]; /* ma, ma ra and mb rb of each
                                                                      * leg */
    double fixed_inertia[LEGS];                    /* mb rb^2 + ia + ib of each leg, with effects */
    double neutral_potential;
};

struct rigid_state {
    double position[3];
    double attitude[4]; /* attitude as a unit quaternion w x y z, {M} to {B}; it needs no
                         * trigonometry and has no singular pose */
    double twist[6];
};

struct rigid_legs {
    double rotation[3][3];
    double rho[3][LEGS], n[3][LEGS], arm[3][LEGS]; /* `arm` is rho x n */
    double length[LEGS], rate[LEGS];
    double across[3][LEGS]; /* part v_perp of the upper joint's velocity across the leg */
    double centripetal[3][LEGS]; /* omega x (omega x rho): acceleration of the upper joint while the
                                  * platform has no acceleration */
};

void rigid_model_init(struct rigid_model *m, const struct params *params);

/* rigid_rest() sets a state at rest in a pose with Euler angles (types.h); rigid_pose() computes
 * the pose of a state. */
void rigid_rest(struct rigid_state *s, const double pose[DOFS]);
void rigid_pose(const struct rigid_state *s, double pose[DOFS]);

void rigid_legs(const struct rigid_model *m, const struct rigid_state *s, struct rigid_legs *legs);

/* Computes mass and load of the equation mass acceleration = load + J' f. Sets only the lower
 * triangle of mass. */
void rigid_dynamics(const struct rigid_model *m, const struct rigid_state *s, const struct rigid_legs *legs, double mass[DOFS][DOFS],
                    double load[DOFS]);

/* Adds J' f to load. */
void rigid_push(const struct rigid_legs *legs, const double force_n[LEGS], double load[DOFS]);

/* Computes the row of J for one leg. */
static inline void rigid_row(const struct rigid_legs *legs, int leg, double row[DOFS]) {
    for (int i = 0; i < 3; i++) row[i] = legs->n[i][leg], row[3 + i] = legs->arm[i][leg];
}

/* Returns the axial force that a leg's rod needs for its own motion when the rod's end is length_m
 * from the lower joint: mass times acceleration, less the parts due to the leg's rotation and to
 * the rod's weight. */
double rigid_rod_force(const struct rigid_model *m, const struct rigid_legs *legs, int leg, double length_m, double acceleration_mps2);

void rigid_energy(const struct rigid_model *m, const struct rigid_state *s, double *kinetic_j, double *potential_j);

/* Finds the forces along the legs that hold the platform at rest in a pose. Returns false if no
 * forces can hold it (J singular). */
bool rigid_holding_forces(const struct rigid_model *m, const double pose[DOFS], double force_n[LEGS]);

#endif
