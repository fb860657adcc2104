/* The closed loop that a configuration describes, effects included, linearised about a pose in
 * which the platform is held: masses and weight, oil columns (whose length changes with the
 * stroke), valves, leakage and viscous friction, delays, and the controller. Dry friction, dead
 * band and hoses are left out. Poles as in loop_poles.h. Ordinary threads, no heap. */
#ifndef HEXID_LOOP_MODEL_H
#define HEXID_LOOP_MODEL_H

#include "loop_poles.h"
#include "status.h"

/* The machine in one pose, linearised, without its controller. */
struct loop_place {
    double pose[DOFS];
    struct loop_leg leg[LEGS];
    double inertia[LEGS][LEGS];               /* force of leg [i] for an acceleration of leg [j],
                                               * kg */
    double motion[DOFS][LEGS], mass_kg[DOFS]; /* six modes of the oil columns: motion of the legs in
                                               * each, and modal mass divided by the sum of the
                                               * legs' squared motions */
    /* Weights of modal.h in these modes: [i][j] is the factor of kp, ki and kd in the command of
     * mode i for an error of mode j; the identity if all modes have the same gains. */
    double mix[DOFS][DOFS];
    enum dof dof[DOFS];                       /* axis that moves most in each mode */
    /* Motion of the platform in one unit of each mode, m: norm of the origin's motion and of arm_m
     * times the rotation. */
    double reach[DOFS];
    double force_n[LEGS];                     /* forces of the legs that hold the platform up */
    /* Speeds of each leg at full opening under its force, extending and retracting; 0: the supply
     * cannot move it in this direction. */
    double out_mps[LEGS], in_mps[LEGS];
};

struct modal;

/* Linearises the machine in this pose. more_delay_s: delay of the commands beyond the configured
 * one (a field bus adds one cycle). Returns false if the supply cannot hold the platform there,
 * there is no such pose, or its modes cannot be computed. */
bool loop_place_find(struct loop_place *place, const struct params *params, const double pose[DOFS], double more_delay_s);

/* Linearises the machine for a platform that moves about this pose: the valves open by up to
 * `swing` of their full opening on either side of their opening at rest, so that both pairs of the
 * spool's control edges count. swing 0: as loop_place_find(). */
bool loop_place_find_moving(struct loop_place *place, const struct params *params, const double pose[DOFS], double more_delay_s,
                            double swing);

/* Returns a mode of this place; its `motion` points into the place. */
struct loop_mode_input loop_place_mode(const struct loop_place *place, int mode);

/* Finds the modes anew after the legs of a place were changed. Returns false if they cannot be
 * computed. */
bool loop_place_modes(struct loop_place *place, const struct params *params, const struct modal *modal);

/* Computes place->mix from the weights of `modal`. */
void loop_place_weigh(struct loop_place *place, const struct modal *modal);

/* The least damped pole of all modes; if some are unstable, the fastest growing one. */
struct loop_worst {
    struct loop_pole pole;
    enum dof dof;
    bool known;           /* false: the loop has values that are not finite */
};
struct loop_worst loop_place_worst(const struct loop_place *place, const struct params *params);

/* Acceleration of the platform that the sensors' errors cause in a stable loop, m/s^2 rms: norm of
 * the origin's acceleration and of kinematics.arm_m times the angular one. */
double loop_place_noise_mps2(const struct loop_place *place, const struct params *params);

#endif
