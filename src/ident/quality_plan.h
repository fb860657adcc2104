/* The motion of `hexid run --qualify`: pieces one after another, each on one axis and each from
 * rest at neutral to rest at neutral. The plan is a pure function of the configuration, so that
 * `hexid qualify` finds the pieces in a log from the configuration that the log contains. Ordinary
 * threads; heap for the trajectory.
 *
 *   rest   8 s at neutral: noise
 *   tone   one sine, in whole periods: describing function. Its number of periods and of samples
 *          have no common divisor, so that no two samples see the same phase and the rounding of
 *          the lengths averages out
 *   slope  a slow triangle from rest: threshold and hysteresis
 *   step   four smooth steps of 0.1 s, to and fro: dead time
 *   long   one period as far and as fast as REACH_SHARE (quality_plan.c) allows: excursion and rate
 *          reached
 *   fast   2 Hz at the same rate, if the stroke and the monitor of oscillations allow it:
 *          acceleration reached */
#ifndef HEXID_QUALITY_PLAN_H
#define HEXID_QUALITY_PLAN_H

#include "status.h"
#include "trajectory.h"

struct params;

enum quality_kind { QUALITY_REST, QUALITY_TONE, QUALITY_SLOPE, QUALITY_STEP, QUALITY_LONG, QUALITY_FAST, QUALITY_KINDS };

enum {
    QUALITY_TONES = 11,      /* most tones of an axis, 0.1 to 20 Hz */
    QUALITY_STEPS = 4,       /* steps of a piece */
    QUALITY_QUARTERS = 6,    /* quarters of a slope: up, down twice, up twice, down */
    QUALITY_PIECES = 1 + DOFS * (QUALITY_TONES + 4),
};

/* Value of tests.trajectory for this motion, in place of the name of a file. */
#define QUALITY_MOTION "qualify"

struct quality_piece {
    enum quality_kind kind;
    enum dof dof;              /* axis that moves; DOF_NONE at rest */
    double hz;                 /* frequency of a sine; 0: none */
    double amplitude;          /* m or rad */
    int periods;               /* periods of a sine in its samples */
    int begin, samples;        /* evaluated cycles, counted from the motion's start */
    int ramp_in, lead;         /* cycles before the evaluated ones: ramp-in (rest before slope and
                                * steps), then sine at full amplitude */
    int ramp_out;              /* cycles after the evaluated ones */
};

struct quality_plan {
    double step_s;             /* period of the loop */
    double arm_m;              /* kinematics.arm_m: angles count as lengths at the upper joints */
    int tones;                 /* tones of each axis */
    double ramp_out_s;         /* least tests.ramp_out_s with which a stop at any time keeps the
                                * legs slow enough */
    int cycles;                /* duration of the motion in periods of the loop */
    int pieces;
    struct quality_piece piece[QUALITY_PIECES];
};

/* Makes the plan. bus: the machine is on a field bus, where the loop resonates more; it changes
 * amplitudes only. Returns -2 for a machine that cannot be driven, impossible geometry, a
 * loop.period_s out of range, or a linear loop for which no amplitude is known to be safe; -3
 * without memory. */
int quality_plan(struct quality_plan *plan, const struct params *params, bool bus, struct error *error);

/* Displacement on the piece's axis, m or rad; cycle 0 is the first evaluated one. */
double quality_piece_at(const struct quality_plan *plan, const struct quality_piece *piece, int cycle);

/* Makes the trajectory of the whole motion, a knot for each cycle, in one pass. Release it by
 * trajectory_free(). Returns -3 without memory. */
int quality_trajectory(const struct quality_plan *plan, struct trajectory *trajectory, struct error *error);

#endif
