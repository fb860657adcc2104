/* The closed loop that a configuration describes, effects included, linearised about a pose in
 * which the platform is held: masses and weight, oil columns (their length changes with the
 * stroke), valves, leakage and viscous friction, delays, and the controller. Dry friction, dead
 * band and lines between valve and cylinder are left out. Poles as in loop_poles.h. Ordinary
 * threads, no heap. */
#ifndef HEXID_LOOP_MODEL_H
#define HEXID_LOOP_MODEL_H

#include "loop_poles.h"
#include "status.h"

/* The machine in one pose; the controller is not in it. */
struct loop_place {
    double pose[DOFS];
    struct loop_leg leg[LEGS];
    double motion[DOFS][LEGS], mass_kg[DOFS]; /* of the six modes of the oil columns, */
    enum dof dof[DOFS];                       /* the axis that moves most in each, */
    double reach[DOFS];                       /* and the platform's motion for one of the mode's, m:
                                               * norm of the origin's and arm_m times the angles */
    double force_n[LEGS];                     /* that holds the platform up */
    double out_mps[LEGS], in_mps[LEGS];       /* speed of a leg at full opening under that force,
                                               * extending and retracting; 0: the supply cannot hold
                                               * it up */
};

/* more_delay_s: of the commands beside what is configured (a field bus: one cycle). False: the
 * supply does not hold the platform there, or there is no such pose. */
bool loop_place_find(struct loop_place *place, const struct params *params, const double pose[DOFS], double more_delay_s);

/* The pole with the least damping of all modes; where some grow, that which grows fastest. */
struct loop_worst {
    struct loop_pole pole;
    enum dof dof;
    bool known;           /* false: the loop is not finite */
};
struct loop_worst loop_place_worst(const struct loop_place *place, const struct params *params);

/* Acceleration of the platform that the readings' own errors make, m/s^2 rms, in a loop that is
 * stable: the norm of the origin's and kinematics.arm_m times the angular one. */
double loop_place_noise_mps2(const struct loop_place *place, const struct params *params);

#endif
