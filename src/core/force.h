/* Pressures to leg forces: f = A1 P1 - A2 P2, positive pushing the platform away from
 * the base. Pure, RT. */
#ifndef HEXID_FORCE_H
#define HEXID_FORCE_H

#include "params.h"

struct cylinder_areas {
    double a1_m2[LEGS]; /* rodless side: pi D^2 / 4 */
    double a2_m2[LEGS]; /* rod side: pi (D^2 - d^2) / 4 */
};

struct cylinder_areas cylinder_areas(const struct actuator_params *actuator);

static inline double leg_force(const struct cylinder_areas *a, int leg, double p1_pa, double p2_pa) {
    return a->a1_m2[leg] * p1_pa - a->a2_m2[leg] * p2_pa;
}

#endif
