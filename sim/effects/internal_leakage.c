#include "machine.h"

enum { SCALE };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->oil.leakage_m3_per_s_pa[leg] *= v->value[SCALE][leg];
}

const struct effect internal_leakage = {
    .name = "internal_leakage",
    .family = EFFECT_OIL,
    .plain = "a different leakage across the pistons",
    .law = "leakage across the piston = scale hydraulics.leakage_m3_per_s_pa (P1 - P2)",
    .signature = "valve command: static, and in phase with the pressure difference",
    .law_error = 1e-3,
    .keys = {[SCALE] = {.name = "scale", .unit = "-", .min = 0.0, .max = 1e4, .neutral = 1.0, .typical = 3.0, .per_leg = true}},
    .parallel_to = {"hydraulics.leakage_m3_per_s_pa"},
    .machine = machine,
};
