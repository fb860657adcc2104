/* The reference pose: hold, a move, or a test. Pure, RT.
 *
 * A move goes from any pose, rate and acceleration to rest at a target, continuous in acceleration
 * and within limits of rate and acceleration. It consists of two polynomials in sequence:
 *
 *     brake   brings the rate v0 + a0 t to zero in B seconds: with q = t / B the rate is
 *             v0 (1 - 3q^2 + 2q^3) + a0 B q (1 - q)^2, the acceleration
 *             (1 - q) (a0 (1 - 3q) - 6 (v0 / B) q), at most A if
 *             B >= 3 |v0| / (A - |a0| + sqrt(A^2 + A |a0|)). The pose overshoots by
 *             B (v0 / 2 + a0 B / 12). B is at least 0.25 s, so that the acceleration fades, and 0
 *             at rest.
 *     travel  10 q^3 - 15 q^4 + 6 q^5 of the distance D in T seconds: rate at most 15/8 D / T,
 *             acceleration at most 10/sqrt(3) D / T^2.
 *
 * Each part is as long as the limits require, and both together last at least as long as requested.
 * Distance, rate and acceleration are norms over the origin's coordinates, m, and the angles times
 * arm_m. If rate or acceleration exceed their limits at the start, they decrease from there.
 *
 * A test's ramps are 3q^2 - 2q^3.
 *
 * Test time is 0 at the start of the ramp-in: [-settle, 0) is held at neutral, [0, ramp) is the
 * ramp-in, [ramp, ramp+duration) is evaluated, then follow the ramp-out and one last cycle at
 * neutral. All instants are whole cycles. ref = envelope(t) motion(t), where the motion is one of
 *
 *     a sinusoid           amplitude sin(2 pi f t), with the axis's amplitude and f
 *     a multisine          the sinusoids of all axes of tests.order at once
 *     a trajectory         all passes, in the evaluated part; during the ramps it is extended in
 *                          straight lines at its initial and final rate */
#ifndef HEXID_REFERENCE_H
#define HEXID_REFERENCE_H

#include "trajectory.h"

struct motion_params;
struct test_params;

enum reference_mode { REFERENCE_HOLD, REFERENCE_MOVE, REFERENCE_TEST };

struct reference {
    enum reference_mode mode;
    int64_t ticks;               /* number of cycles since the start of the move, or of the test's
                                  * ramp-in; counting avoids rounding errors of the time */
    double from[DOFS], to[DOFS]; /* start and end of a move; a hold stays at `to` */
    double rate_from[DOFS], accel_from[DOFS]; /* rate and acceleration at the start of a move */
    double brake_s, travel_s;    /* durations of the two parts of a move */
    double turn[DOFS];           /* pose at which the braking part ends and the travelling part
                                  * begins */
    enum dof dof;                /* axis of the test; DOF_NONE: a test of several axes, or no
                                  * test */
    const struct trajectory *trajectory; /* trajectory of the test; NULL: none */
    int64_t ramp_out_tick;       /* cycle at which a test's ramp-out begins */
};

struct reference_sample {
    double pose[DOFS];
    enum phase phase;            /* phase of the test; PHASE_NONE outside a test */
    double test_time_s;
    bool done;                   /* the move or test has ended, and the reference holds its pose
                                  * from here on; always true in a hold */
};

void reference_hold(struct reference *r, const double pose[DOFS]);

struct move_limits {
    double duration_s;      /* requested duration; the move takes longer if the limits require it */
    double rate_mps, accel_mps2; /* limits of speed and acceleration, above 0 */
    double arm_m;                /* kinematics.arm_m, which converts angles to lengths */
};

/* Reference pose, rate and acceleration of the previous cycle, from which a move starts. */
struct move_start {
    const double *pose, *rate, *accel; /* arrays of DOFS values */
};

/* Begins a move that comes to rest exactly at `to`. */
void reference_move(struct reference *r, const struct move_start *from, const double to[DOFS], const struct move_limits *limits);

/* Returns the duration of a move between the parked pose and neutral: asked_s, or longer if the
 * limits require it. */
double reference_park_s(const struct motion_params *motion, double asked_s);

/* Returns the duration of an automatic run that is not stopped early, from STATE_SETTLED to the
 * parked platform, without STATE_PRESSURISING. A trajectory counts with tests.duration_s. */
double reference_run_s(const struct motion_params *motion, const struct test_params *tests);

/* Begins a test. dof: axis of its sinusoid. With DOF_NONE the test follows the trajectory, which
 * must outlive the test. If trajectory is NULL, too, the test is a multisine if t->multisine is
 * set, else it stays at neutral. */
void reference_test(struct reference *r, enum dof dof, const struct trajectory *trajectory, const struct test_params *t, double dt_s);

/* Ends a test early: the ramp-out begins, during which the test's motion continues. Has no effect
 * on a hold or a move. */
void reference_stop(struct reference *r);

struct reference_sample reference_step(struct reference *r, const struct test_params *t, double dt_s);

/* Computes pose, rate, acceleration and jerk by their formulas for the instant that is ahead_s >= 0
 * after the last pose returned by reference_step(). Requests that may come before that instant are
 * ignored; after the end of a move or test the reference holds. With ahead_s = 0 the pose is that
 * last one to the last bit. The acceleration is continuous in a move; in a test it may jump at
 * either end of a ramp. The jerk jumps wherever two polynomials meet. */
void reference_motion(const struct reference *r, const struct test_params *t, double dt_s, double ahead_s,
                      double motion[MOTION_ORDERS][DOFS]);

#endif
