/* The poses that the legs can reach within their strokes and limits, and their distance from
 * singular poses. Pure; takes 0.05 s. */
#ifndef HEXID_WORKSPACE_H
#define HEXID_WORKSPACE_H

#include "kinematics.h"

struct workspace {
    int corners; /* number of combinations of leg lengths tried: each leg retracted, at neutral or
                  * extended, 3^6 */
    int reached;                /* number of combinations that were reached from neutral without
                                 * meeting a singular pose, all legs moving in proportion */
    double neutral_condition;   /* condition number of the Jacobian at neutral (largest over
                                 * smallest singular value), angles in units of 1/arm_m */
    double worst_condition;  /* largest condition number of the Jacobian on the paths that reached
                              * their end */
    double worst_pose[DOFS];
    double nearest;   /* smallest share of a path from neutral at which the path meets a singular
                       * pose; 1: no path meets one */
    double nearest_pose[DOFS];
};

/* Follows paths to all combinations of each leg's shortest, neutral and longest length within both
 * stroke and limits. k must come from kinematics_init(). */
struct workspace workspace_find(const struct kinematics *k, const struct params *params);

#endif
