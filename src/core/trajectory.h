/* A trajectory: poses over time, joined by cubic splines, so that pose, rate and acceleration are
 * continuous. It is built before anything moves; the loop only reads it.
 *
 * A single pass has natural ends (zero acceleration). Several passes are periodic: the last pose
 * equals the first, and rate and acceleration are continuous from one pass to the next. */
#ifndef HEXID_TRAJECTORY_H
#define HEXID_TRAJECTORY_H

#include "types.h"

/* Order of a pose's time derivative; it is the first index of the arrays `motion`. Units: m and
 * rad, and these per s, s^2 and s^3. */
enum motion_order { MOTION_POSE, MOTION_RATE, MOTION_ACCEL, MOTION_JERK, MOTION_ORDERS };

struct trajectory_knot {
    double time_s;          /* time since the first knot */
    double pose[DOFS];      /* pose of the knot, m and rad */
    double bend[DOFS];      /* second time derivative of the pose */
};

struct trajectory {
    int knots;              /* number of knots, at least 3 */
    int passes;             /* number of passes; if it is above 1, the last knot has the pose of the
                             * first */
    struct trajectory_knot *knot;
};

/* Computes the knots' second derivatives. Ordinary threads; linear in the number of knots. Returns
 * false if there is no memory. */
bool trajectory_bend(struct trajectory *t);

/* Returns the duration of all passes. */
double trajectory_s(const struct trajectory *t);

/* Computes pose, rate, acceleration and jerk at a time since the start of the first pass. Before
 * the first and after the last pass, the pose is extrapolated in a straight line with the rate at
 * that end. The jerk is constant between knots. RT: a search of at most 32 steps, no heap. */
void trajectory_motion(const struct trajectory *t, double time_s, double motion[MOTION_ORDERS][DOFS]);

/* Computes the pose alone, as trajectory_motion() does. */
void trajectory_at(const struct trajectory *t, double time_s, double pose[DOFS]);

#endif
