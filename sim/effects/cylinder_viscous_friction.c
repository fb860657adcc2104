#include "effect.h"

enum { EXTEND, RETRACT };

static void leg_friction(const struct effect_values *v, int leg, const struct leg_motion *motion, struct friction *add) {
    add->viscous += v->value[motion->direction > 0 ? EXTEND : RETRACT][leg] * motion->speed_mps;
}

const struct effect cylinder_viscous_friction = {
    .name = "cylinder_viscous_friction",
    .family = EFFECT_FRICTION,
    .plain = "a different viscous friction of the cylinders",
    .law = "F = -b_extend Ldot for Ldot > 0, -b_retract Ldot for Ldot < 0; added to hydraulics.viscous_n_s_per_m, the sum is 0 or more",
    .signature = "leg force: fundamental in phase with velocity; with one direction stronger also the mean and the second harmonic",
    .law_error = 1e-3,
    .keys = {[EXTEND] = {.name = "extend_n_s_per_m", .unit = "N s/m", .min = -1e5, .max = 1e5, .typical = 1e3, .per_leg = true},
             [RETRACT] = {.name = "retract_n_s_per_m", .unit = "N s/m", .min = -1e5, .max = 1e5, .typical = 1e3, .per_leg = true}},
    .parallel_to = {"hydraulics.viscous_n_s_per_m"},
    .leg_friction = leg_friction,
};
