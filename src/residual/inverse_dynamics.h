/* Leg forces that a measured motion of the legs needs: sim's rigid bodies, weight, joint and leg
 * friction. The pose is found from the lengths with the model's own joint positions. Pure. */
#ifndef HEXID_INVERSE_DYNAMICS_H
#define HEXID_INVERSE_DYNAMICS_H

#include "cylinder.h"
#include "rigid.h"

enum { PHASES = 128 }; /* of a cycle */

/* m/s. A leg that sticks still yields at this speed, as its chambers do: below it the leg may be
 * held, and from twice it on it surely slides. */
#define INVERSE_DYNAMICS_SLOW_MPS 2e-3

struct inverse_dynamics {
    const struct params *params;
    struct rigid_model rigid;
    struct cylinder_model cylinder;
    struct rigid_state state;   /* the search for the next pose starts here */
    double window_s;            /* dry friction is averaged over this time about each instant: a
                                 * reversal falls between two instants */
    double speed_std_mps[LEGS]; /* standard deviations of the measured speed, */
    double force_std_n[LEGS];   /* and of the force left for friction; 0 after init */
    double resolution_s;        /* of the motion: half the time from a crest to a trough
                                 * of its highest harmonic */
    bool joints;
};

void inverse_dynamics_init(struct inverse_dynamics *d, const struct params *params, double window_s, double resolution_s);

/* The mean sign of a value, with its rate of change, over a window about an instant: share of the
 * window in which it is positive, minus the share where negative. */
double inverse_dynamics_direction(double value, double rate, double window_s);

/* The pose, twist and acceleration of the platform whose legs move like this: leg holds length,
 * rate and acceleration of each. Pose and twist are left in d->state; the acceleration is that of
 * the origin of {M} and the angular one, in {B}; row i of j gives leg i's rate for a twist. False:
 * no pose has these lengths. */
bool inverse_dynamics_move(struct inverse_dynamics *d, const double leg[LEGS][3], struct rigid_legs *legs, double j[LEGS][DOFS],
                           double acceleration[DOFS]);

/* Turns a wrench on the platform into forces along the legs, in place: J'^-1 F. False where J is
 * singular. */
bool inverse_dynamics_along_legs(double j[LEGS][DOFS], double wrench[DOFS]);

/* What is measured at an instant. */
struct inverse_dynamics_input {
    double leg[LEGS][3];                   /* length, rate, acceleration, joint to joint */
    double ahead[LEGS][3];                 /* of play: how far the rods are ahead of their joints */
    double p1_pa[LEGS], p2_pa[LEGS];
    double deflection[LEGS];               /* of the seals, -1..1 */
    double push_n[LEGS];                   /* measured force, for legs that stick */
};

/* What the bodies need of each leg; legs: where they are, not of a single axis. False: no pose has
 * these lengths. */
bool inverse_dynamics_bodies(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, struct rigid_legs *legs,
                             double force_n[LEGS]);

/* Friction of a leg, that of the rod in its cylinder. balance_n: what is left for it, should it
 * be held. */
double inverse_dynamics_friction(const struct inverse_dynamics *d, int leg, const struct inverse_dynamics_input *in, double balance_n);

/* force_n: the hydraulic force that each leg needs, for bodies and friction. False: no pose has
 * these lengths. */
bool inverse_dynamics_step(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, double force_n[LEGS]);

/* Finds the deflection of the seals that the motion makes (cylinder.h): its mean over window_s
 * about each instant, of at most PHASES, window_s apart. cycle: they follow each other round. Else
 * the first one, of a leg that rests or has just turned, is by the balance of forces. False: no
 * pose has these lengths. */
bool inverse_dynamics_seals(struct inverse_dynamics *d, int instants, bool cycle, struct inverse_dynamics_input in[]);

/* Inertia of all bodies along the legs in a platform's last pose, [k][l]: force of leg k for an
 * acceleration of leg l, the others' lengths kept. */
void inverse_dynamics_inertia(const struct inverse_dynamics *d, double inertia[LEGS][LEGS]);

#endif
