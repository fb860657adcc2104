/* A trajectory: poses over time, joined by cubic splines, so that pose, rate and acceleration are
 * continuous. It is made once, before anything moves, and only read by the loop.
 *
 * Ends: natural (no acceleration) for a single pass; with several passes closed, the last pose
 * being the first again, with rate and acceleration continuous there, too. */
#ifndef HEXID_TRAJECTORY_H
#define HEXID_TRAJECTORY_H

#include "types.h"

struct trajectory_knot {
    double time_s;          /* the first knot's is 0 */
    double pose[DOFS];      /* m, rad */
    double bend[DOFS];      /* second derivative */
};

struct trajectory {
    int knots;              /* at least 3 */
    int passes;             /* more than one: pose of the last knot = pose of the first */
    struct trajectory_knot *knot;
};

/* Fills in the knots' second derivatives. Ordinary threads; linear in the number of knots.
 * False: out of memory. */
bool trajectory_bend(struct trajectory *t);

/* All passes. */
double trajectory_s(const struct trajectory *t);

/* The pose at a time from the beginning of the first pass; before it and behind the last pass
 * straight on at the rate of the end. RT: a search of at most 32 steps, no heap. */
void trajectory_at(const struct trajectory *t, double time_s, double pose[DOFS]);

#endif
