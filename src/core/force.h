/* Leg forces from pressures: f = A1 P1 - A2 P2, positive if it pushes the platform away from the
 * base; and the cut of the force feedback where the oil is stiff. Pure, RT. */
#ifndef HEXID_FORCE_H
#define HEXID_FORCE_H

#include "kinematics.h"

struct cylinder_areas {
    double a1_m2[LEGS]; /* area on the rodless side: pi D^2 / 4 */
    double a2_m2[LEGS]; /* area on the rod side: pi (D^2 - d^2) / 4 */
};

struct cylinder_areas cylinder_areas(const struct actuator_params *actuator);

static inline double leg_force(const struct cylinder_areas *a, int leg, double p1_pa, double p2_pa) {
    return a->a1_m2[leg] * p1_pa - a->a2_m2[leg] * p2_pa;
}

/* SAFETY: the loop gain of the force feedback (control.kpf) is proportional to the stiffness of the
 * oil, which is its bulk modulus times A1^2/V1 + A2^2/V2. Near the ends of a long stroke the oil is
 * ten times as stiff as at neutral, and with a constant kpf the platform would oscillate there. So
 * kpf is reduced in proportion where the oil is stiffer than 1.5 times its stiffness at neutral. */
struct oil_column {
    double area_m2[2], dead_m3[2]; /* areas and dead volumes of the rodless and of the rod side */
    double least_m, most_m;        /* leg lengths at the two end stops */
    double most_stiff_per_m;       /* stiffness of the oil, divided by its bulk modulus, above which
                                    * kpf is reduced, m */
};
void oil_columns_init(struct oil_column column[LEGS], const struct params *params, const struct kinematics *k);

/* Returns the reduction of control.kpf at this length of the leg, 0 (none) to 1. */
double oil_feedback_cut(const struct oil_column *column, double length_m);

#endif
