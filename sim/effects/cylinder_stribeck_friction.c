#include <math.h>

#include "effect.h"

enum { EXCESS, VELOCITY };

static void leg_friction(const struct effect_values *v, int leg, const struct leg_motion *motion, struct friction *add) {
    double share = motion->speed_mps / v->value[VELOCITY][leg];
    add->dry += v->value[EXCESS][leg] * exp(-share * share);
}

extern const struct effect cylinder_coulomb_friction;

const struct effect cylinder_stribeck_friction = {
    .name = "cylinder_stribeck_friction",
    .family = EFFECT_FRICTION,
    .plain = "friction in the cylinders that is higher at low speed (Stribeck)",
    .law = "F = -excess exp(-(v/vs)^2) sign(v) on top of the Coulomb friction, v = Ldot; at rest holds up to the excess",
    .signature = "leg force: a peak at every velocity reversal, odd harmonics up to high order; small where the motion is fast, "
                 "slow motion shows it",
    .law_error = 0.05,
    .keys = {[EXCESS] = {.name = "excess_n", .unit = "N", .min = 0.0, .max = 2e4, .typical = 100.0, .per_leg = true},
             [VELOCITY] = {.name = "velocity_mps",
                           .unit = "m/s",
                           .min = 1e-4,
                           .max = 1.0,
                           .neutral = 0.02,
                           .typical = 0.02,
                           .per_leg = true,
                           .shapes_law = true}},
    .contains = {&cylinder_coulomb_friction}, /* limiting case for a high velocity_mps */
    .leg_friction = leg_friction,
};
