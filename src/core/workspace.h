/* The poses that the legs can reach within their strokes and limits, and their distance from
 * singular poses. Pure; takes 0.05 s. */
#ifndef HEXID_WORKSPACE_H
#define HEXID_WORKSPACE_H

#include "kinematics.h"

struct workspace {
    int corners; /* number of combinations of leg lengths tried, 3^6: each leg is retracted, at
                  * neutral or extended */
    int reached;                /* number of combinations that a path from neutral, on which all
                                 * legs move in proportion, reaches without meeting a singular
                                 * pose */
    double neutral_condition;   /* condition number of the Jacobian at neutral (largest over
                                 * smallest singular value), angles in units of 1/arm_m */
    double worst_condition;  /* largest condition number of the Jacobian on the paths that reach
                              * their end */
    double worst_pose[DOFS];
    double nearest;   /* smallest share of a path from neutral after which the path meets a singular
                       * pose; 1: no path meets one */
    double nearest_pose[DOFS];
};

/* Follows a path from neutral to each combination of the legs' shortest, neutral and longest
 * lengths, within both stroke and limits. k must come from kinematics_init(). */
struct workspace workspace_find(const struct kinematics *k, const struct params *params);

#endif
