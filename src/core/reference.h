/* The reference pose: hold, a smooth move, or a test. Ramps are 3q^2 - 2q^3. Pure, RT.
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
    double rate_from[DOFS];      /* of a move at its start: it begins without a step in rate, */
    double duration_s;           /* of a move */
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

/* Smooth, from the pose of the cycle before and its rate to rest at `to`. The initial rate dies
 * away by a cubic of its own within a second (or the move, if shorter): over a long move it would
 * carry the platform far beyond its stroke. It overshoots by 4/27 s of its rate. */
void reference_move(struct reference *r, const double from[DOFS], const double rate_from[DOFS], const double to[DOFS], double duration_s);

/* dof: the axis whose sinusoid it is; DOF_NONE: the trajectory, which must outlive the test, or if
 * t->multisine that; else neutral is held. */
void reference_test(struct reference *r, enum dof dof, const struct trajectory *trajectory, const struct test_params *t, double dt_s);

/* Ends a test early: its ramp-out begins now, while the motion under it goes on. Anything else
 * is left as it is. */
void reference_stop(struct reference *r);

struct reference_sample reference_step(struct reference *r, const struct test_params *t, double dt_s);

#endif
