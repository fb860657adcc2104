/* The reference pose: hold, a move, or a test. Pure, RT.
 *
 * A move goes from any pose, rate and acceleration to rest at a target, continuous in acceleration
 * and within limits of rate and acceleration. It is two polynomials, one after the other:
 *
 *     brake   rate (v0 + a0 t) dies away in B seconds: with q = t / B its rate is
 *             v0 (1 - 3q^2 + 2q^3) + a0 B q (1 - q)^2, its acceleration
 *             (1 - q) (a0 (1 - 3q) - 6 (v0 / B) q), at most A where
 *             B >= 3 |v0| / (A - |a0| + sqrt(A^2 + A |a0|)). It goes on by
 *             B (v0 / 2 + a0 B / 12): that is how far it overshoots. B is 0.25 s at least, so that
 *             the acceleration fades, and nothing at rest.
 *     travel  10 q^3 - 15 q^4 + 6 q^5 of the distance D in T seconds: rate at most 15/8 D / T,
 *             acceleration at most 10/sqrt(3) D / T^2.
 *
 * Both last as long as the limits ask for, and together as long as is asked for. Norms: the
 * origin's m, and arm_m times the angles. What is faster or more accelerated at the start than its
 * limit comes down from there.
 *
 * A test's ramps are 3q^2 - 2q^3.
 *
 * Test time starts at the ramp-in:  [-settle, 0) hold neutral, [0, ramp) ramp-in, [ramp,
 * ramp+duration) evaluated, then ramp-out and one last cycle at neutral. All instants are whole
 * cycles. ref = envelope(t) motion(t), the motion being one of
 *
 *     an axis's sinusoid   amplitude sin(2 pi f t), amplitude and f its own
 *     a multisine          those of all axes of tests.order at once
 *     a trajectory         from the end of the ramp-in on, all its passes the evaluated part;
 *                          during the ramps straight on at the rate that it begins and ends with */
#ifndef HEXID_REFERENCE_H
#define HEXID_REFERENCE_H

#include "params.h"
#include "trajectory.h"

enum reference_mode { REFERENCE_HOLD, REFERENCE_MOVE, REFERENCE_TEST };

struct reference {
    enum reference_mode mode;
    int64_t ticks;               /* cycles since the move began; in a test since the ramp-in's
                                  * start: time is exact, no sum of roundings */
    double from[DOFS], to[DOFS]; /* of a move; a hold holds `to` */
    double rate_from[DOFS], accel_from[DOFS]; /* of a move at its start */
    double brake_s, travel_s;    /* of a move: its two parts */
    double turn[DOFS];           /* pose between them */
    enum dof dof;                /* tested axis, DOF_NONE: not one alone */
    const struct trajectory *trajectory; /* of a test, NULL: none */
    int64_t ramp_out_tick;       /* of a test */
};

struct reference_sample {
    double pose[DOFS];
    enum phase phase;            /* PHASE_NONE outside a test */
    double test_time_s;
    bool done;                   /* move or test has ended: from here it holds */
};

void reference_hold(struct reference *r, const double pose[DOFS]);

struct move_limits {
    double duration_s;           /* asked for; it takes longer where the others ask for it */
    double rate_mps, accel_mps2; /* above 0 */
    double arm_m;                /* what an angle moves: kinematics.arm_m */
};

/* Pose, rate and acceleration of the cycle before. */
struct move_start {
    const double *pose, *rate, *accel; /* of DOFS */
};

/* Begins a move from `from` to rest at `to`, which is reached exactly. */
void reference_move(struct reference *r, const struct move_start *from, const double to[DOFS], const struct move_limits *limits);

/* How long a move of this distance from rest to rest takes; between the parked pose and neutral,
 * where asked_s is asked for. */
double reference_travel_s(double distance_m, const struct move_limits *limits);
double reference_park_s(const struct motion_params *motion, double asked_s);

/* dof: the axis whose sinusoid it is; DOF_NONE: the trajectory, which must outlive the test, or if
 * t->multisine that; else neutral is held. */
void reference_test(struct reference *r, enum dof dof, const struct trajectory *trajectory, const struct test_params *t, double dt_s);

/* Ends a test early: its ramp-out begins now, while the motion under it goes on. Anything else
 * is left as it is. */
void reference_stop(struct reference *r);

struct reference_sample reference_step(struct reference *r, const struct test_params *t, double dt_s);

#endif
