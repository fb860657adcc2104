/* The reference pose: hold, a smooth move, or a sinusoidal test. Ramps are 3q^2 - 2q^3. Pure, RT.
 *
 * A test counts its time from the start of the ramp-in:  [-settle, 0) hold, [0, ramp) ramp-in, [ramp, ramp+duration) evaluated,
 * then ramp-out; ref[dof] = amplitude envelope(t) sin(2 pi f t). */
#ifndef HEXID_REFERENCE_H
#define HEXID_REFERENCE_H

#include "params.h"

enum reference_mode { REFERENCE_HOLD, REFERENCE_MOVE, REFERENCE_TEST };

struct reference {
    enum reference_mode mode;
    double from[DOFS], to[DOFS]; /* hold: to */
    double duration_s;           /* of the move */
    uint64_t ticks;              /* cycles since move or test began: time is exact, no sum of roundings */
    enum dof dof;
    bool stopping;               /* the ramp-out was asked for early */
    double stop_time_s;          /* when, on the test's time */
};

struct reference_sample {
    double pose[DOFS];
    enum phase phase;
    double test_time_s;
    bool done;                   /* move or test has ended; holds `to` from here */
};

void reference_hold(struct reference *r, const double pose[DOFS]);
void reference_move(struct reference *r, const double from[DOFS], const double to[DOFS], double duration_s);
void reference_test(struct reference *r, enum dof dof);

/* Ends a test early by its ramp-out; a move is left to end; a hold stays. */
void reference_stop(struct reference *r, const struct test_params *t, double dt_s);

struct reference_sample reference_step(struct reference *r, const struct test_params *t, double dt_s);

#endif
