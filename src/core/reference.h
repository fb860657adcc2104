/* The reference pose: hold, a smooth move, or a sinusoidal test. Ramps are 3q^2 - 2q^3. Pure, RT.
 *
 * Test time starts at the ramp-in:  [-settle, 0) hold neutral, [0, ramp) ramp-in, [ramp, ramp+duration) evaluated, then ramp-out and one
 * last cycle at neutral;
 * ref[dof] = amplitude envelope(t) sin(2 pi f t), amplitude and f the axis's own. All instants are whole cycles. */
#ifndef HEXID_REFERENCE_H
#define HEXID_REFERENCE_H

#include "params.h"

enum reference_mode { REFERENCE_HOLD, REFERENCE_MOVE, REFERENCE_TEST };

struct reference {
    enum reference_mode mode;
    int64_t ticks;               /* cycles since the move began; in a test since the ramp-in's start: time is exact, no sum of roundings */
    double from[DOFS], to[DOFS]; /* of a move; a hold holds `to` */
    double rate_from[DOFS];      /* of a move at its start: it begins without a step in rate, */
    double duration_s;           /* of a move */
    enum dof dof;                /* tested axis */
    int64_t ramp_out_tick;       /* of a test */
};

struct reference_sample {
    double pose[DOFS];
    enum phase phase;            /* PHASE_NONE outside a test */
    double test_time_s;
    bool done;                   /* move or test has ended: from here it holds */
};

void reference_hold(struct reference *r, const double pose[DOFS]);

/* Smooth, from the pose of the cycle before and its rate to rest at `to`. The initial rate dies away by a cubic of its own within a second
 * (or the move, if shorter): over a long move it would carry the platform far beyond its stroke. It overshoots by 4/27 s of its rate. */
void reference_move(struct reference *r, const double from[DOFS], const double rate_from[DOFS], const double to[DOFS], double duration_s);

void reference_test(struct reference *r, enum dof dof, const struct test_params *t, double dt_s);

/* Ends a test early: its ramp-out begins now. Anything else is left as it is. */
void reference_stop(struct reference *r);

struct reference_sample reference_step(struct reference *r, const struct test_params *t, double dt_s);

#endif
