/* Leg forces that a measured motion of the legs needs, from sim's rigid bodies, weight, joint
 * friction and leg friction. The pose is found from the lengths with the model's own joint
 * positions. Pure. */
#ifndef HEXID_INVERSE_DYNAMICS_H
#define HEXID_INVERSE_DYNAMICS_H

#include "cylinder.h"
#include "rigid.h"
#include "types.h"

enum { PHASES = 128 }; /* instants per cycle at which forces are evaluated */

/* Speed, m/s, below which friction may hold a leg; above twice this speed the leg surely slides.
 * Even a held leg moves this slowly, because the oil in its chambers yields. The threshold that is
 * used is higher near a reversal and where speeds are noisy. */
#define INVERSE_DYNAMICS_SLOW_MPS 2e-3

struct inverse_dynamics {
    const struct params *params;
    struct rigid_model rigid;
    struct cylinder_model cylinder;
    struct rigid_state state;   /* last pose, from which the search for the next one starts */
    double window_s;            /* dry friction is averaged over this time about each instant,
                                 * because a reversal may fall between two instants */
    double speed_std_mps[LEGS]; /* standard deviations of the legs' measured speeds */
    double force_std_n[LEGS];   /* noise of each leg's friction, as a standard deviation, if the
                                 * friction is computed from the balance of forces; 0 after init */
    double resolution_s;        /* a quarter period of the motion's highest harmonic: the harmonics
                                 * do not resolve the motion within this time of a reversal, so a
                                 * leg may be held there. If it is 0, instants near a reversal are
                                 * treated like all others. */
    bool joints; /* the model has joint friction */
    bool slides; /* a leg that may be held has the friction of a sliding leg, whatever the balance
                  * of forces says */
};

/* Prepares d with standard deviations of 0; params must outlive it. */
void inverse_dynamics_init(struct inverse_dynamics *d, const struct params *params, double window_s, double resolution_s);

/* Mean sign, -1..1, of a value with this rate of change, over a window about an instant: the share
 * of the window in which the value is positive less the share in which it is negative. */
double inverse_dynamics_direction(double value, double rate, double window_s);

/* Finds pose, twist and acceleration of the platform, and leaves pose and twist in d->state. leg:
 * length, rate and acceleration of each leg. acceleration: acceleration of the origin of {M}, then
 * angular acceleration, both in {B}. Row k of j times a twist is leg k's rate. Returns false if no
 * pose has these lengths, or J is singular there. */
bool inverse_dynamics_move(struct inverse_dynamics *d, const double leg[LEGS][3], struct rigid_legs *legs, double j[LEGS][DOFS],
                           double acceleration[DOFS]);

/* Does what inverse_dynamics_move() does, and finds the wrench on the platform that all 13 bodies
 * need: inertia and weight, less the wrench of effects and springs, without joint friction. */
bool inverse_dynamics_bodies(struct inverse_dynamics *d, const double leg[LEGS][3], struct rigid_legs *legs, double j[LEGS][DOFS],
                             double acceleration[DOFS], double wrench[DOFS]);

/* Converts a wrench F on the platform to forces along the legs, in place: J'^-1 F. Returns false if
 * J is singular. */
bool inverse_dynamics_along_legs(double j[LEGS][DOFS], double wrench[DOFS]);

/* Finds the leg forces that make each unit wrench: force_n[i] makes the wrench whose component i is
 * 1. Returns false if J is singular. */
bool inverse_dynamics_unit_wrenches(double j[LEGS][DOFS], double force_n[DOFS][LEGS]);

/* Measured values at an instant. */
struct inverse_dynamics_input {
    double leg[LEGS][3];                   /* length, rate and acceleration of each leg, joint to
                                            * joint */
    double ahead[LEGS][3];                 /* distance, speed and acceleration of each rod's end
                                            * ahead of its joint, by backlash; 0 without backlash */
    double p1_pa[LEGS], p2_pa[LEGS];
    double deflection[LEGS];               /* deflection of each leg's seals, -1..1 */
    double push_n[LEGS];                   /* measured force of each leg, from which the friction of
                                            * a leg that sticks follows */
};

/* Computes the friction of a leg's rod in its cylinder, N, positive against extension. balance_n:
 * friction according to the balance of forces, which is used for a leg that is held. */
double inverse_dynamics_friction(const struct inverse_dynamics *d, int leg, const struct inverse_dynamics_input *in, double balance_n);

/* Variance, N^2, of a leg's friction about its sliding friction, because the leg may be held:
 * sliding and held are equally likely, and the friction of a held leg is anywhere between the
 * limits of its dry friction. The variance is 0 if the leg surely slides or has no dry friction. */
double inverse_dynamics_held_variance(const struct inverse_dynamics *d, int leg, const struct inverse_dynamics_input *in);

/* Finds the hydraulic force that bodies and friction need from each leg. Returns false if no pose
 * has these lengths. */
bool inverse_dynamics_step(struct inverse_dynamics *d, const struct inverse_dynamics_input *in, double force_n[LEGS]);

/* Finds the deflection that the motion gives each leg's seals (cylinder.h), and stores it in
 * in[].deflection. The instants, at most PHASES, are window_s apart; each gets the mean deflection
 * over window_s about it. cycle: the last instant is followed by the first, so the seals end a
 * cycle as they began it. Without a cycle, the deflection before the first instant is unknown, and
 * is fitted to the balance of forces; it matters until the leg has slid far enough. Returns false
 * if no pose has these lengths. */
bool inverse_dynamics_seals(struct inverse_dynamics *d, int instants, bool cycle, struct inverse_dynamics_input in[]);

/* Computes the inertia of all bodies along the legs in the platform's last pose. inertia[k][l]:
 * force of leg k, N, for an acceleration of leg l of 1 m/s^2 while the other legs keep their
 * lengths. */
void inverse_dynamics_inertia(const struct inverse_dynamics *d, double inertia[LEGS][LEGS]);

#endif
