#include "effect.h"

enum { EXTEND, RETRACT };

static void leg_friction(const struct effect_values *v, int leg, const struct leg_motion *motion, struct friction *add) {
    add->dry += v->value[motion->direction > 0 ? EXTEND : RETRACT][leg];
}

const struct effect cylinder_coulomb_friction = {
    .name = "cylinder_coulomb_friction",
    .plain = "dry (Coulomb) friction in the cylinders",
    .law = "F = -F_extend for Ldot > 0, +F_retract for Ldot < 0; at rest holds up to that force",
    .signature = "leg force: odd harmonics in phase with velocity, jump at velocity reversal; with one direction stronger also the mean",
    .keys = {[EXTEND] = {.name = "force_extend_n", .unit = "N", .min = 0.0, .max = 2e4, .typical = 100.0, .per_leg = true},
             [RETRACT] = {.name = "force_retract_n", .unit = "N", .min = 0.0, .max = 2e4, .typical = 100.0, .per_leg = true}},
    .leg_friction = leg_friction,
};
