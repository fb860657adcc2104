#include "effect.h"

enum { MU };

/* If the mean of the chamber pressures is below atmospheric, no seal is pressed on, so no friction
 * is added. */
static void leg_friction(const struct effect_values *v, int leg, const struct leg_motion *motion, struct friction *add) {
    double pressure_pa = 0.5 * (motion->p1_pa + motion->p2_pa);
    if (pressure_pa > 0.0) add->dry += v->value[MU][leg] * (motion->a1_m2 - motion->a2_m2) * pressure_pa;
}

const struct effect load_dependent_friction = {
    .name = "load_dependent_friction",
    .family = EFFECT_FRICTION,
    .plain = "friction in the cylinders that grows with pressure",
    .law = "F = -mu (A1 - A2) (P1 + P2)/2 sign(Ldot); at rest holds up to that force",
    .signature = "leg force: as Coulomb friction, but it grows with the pressures: another static load tells the two apart",
    .law_error = 0.05,
    .keys = {[MU] = {.name = "mu", .unit = "-", .min = 0.0, .max = 0.5, .typical = 0.01, .per_leg = true}},
    .leg_friction = leg_friction,
};
