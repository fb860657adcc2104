/* What poses the legs can make within their strokes and limits, and how well they hold the platform
 * there. Pure; 0.2 s. */
#ifndef HEXID_WORKSPACE_H
#define HEXID_WORKSPACE_H

#include "kinematics.h"

struct workspace {
    int corners;                /* combinations of legs in, at neutral and out that were tried:
                                 * 3^6 */
    int reached;                /* of them: the way there from neutral, all legs in
                                 * proportion, met no singular pose */
    double neutral_condition;   /* of the Jacobian, largest over smallest singular value,
                                 * angles in units of 1/arm_m */
    double worst_condition;     /* on the ways that reached their corner */
    double worst_pose[DOFS];
    double nearest;             /* share of a way at which the nearest singular
                                 * pose ends it; 1: none does */
    double nearest_pose[DOFS];
};

/* Lengths between limits.length_min_m and length_max_m, the strokes' ends included. k: of
 * kinematics_init. */
struct workspace workspace_find(const struct kinematics *k, const struct params *params);

#endif
