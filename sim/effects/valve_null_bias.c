#include "machine.h"

enum { OFFSET };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->valve.bias[leg] += v->value[OFFSET][leg];
}

const struct effect valve_null_bias = {
    .name = "valve_null_bias",
    .family = EFFECT_VALVE,
    .plain = "a null offset of the valves",
    .law = "the spool goes to u + offset",
    .signature = "valve command: static, nothing else",
    .law_error = 1e-3,
    .keys = {[OFFSET] = {.name = "offset", .unit = "-", .min = -0.5, .max = 0.5, .typical = 0.01, .per_leg = true}},
    .machine = machine,
};
