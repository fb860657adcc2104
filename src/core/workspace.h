/* The poses that the legs can reach within their strokes and limits, and how close they are to
 * singular ones. Pure; takes 0.05 s. */
#ifndef HEXID_WORKSPACE_H
#define HEXID_WORKSPACE_H

#include "kinematics.h"

struct workspace {
    int corners; /* number of combinations tried: each leg retracted, at neutral or extended, 3^6 */
    int reached;                /* number of combinations that were reached from neutral, all legs
                                 * moving in proportion, without meeting a singular pose */
    double neutral_condition;   /* condition of the Jacobian at neutral (largest over smallest
                                 * singular value), angles in units of 1/arm_m */
    double worst_condition;  /* largest condition of the Jacobian on paths that reached their end */
    double worst_pose[DOFS];
    double nearest;   /* share of a path from neutral after which it meets the nearest singular
                       * pose; 1: none does */
    double nearest_pose[DOFS];
};

/* Follows paths to all combinations of each leg's shortest, neutral and longest length within both
 * stroke and limits. k must come from kinematics_init(). */
struct workspace workspace_find(const struct kinematics *k, const struct params *params);

#endif
