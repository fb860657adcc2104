#include "machine.h"

enum { MASS };

static void machine(const struct effect_values *v, struct machine *m) {
    m->payload_kg += v->value[MASS][0];
}

const struct effect payload_mass = {
    .name = "payload_mass",
    .plain = "another mass of the payload",
    .law = "m = payload.mass_kg + mass, at the payload's mass centre",
    .signature = "leg forces: static, and in phase with the acceleration of the translations",
    .keys = {[MASS] = {.name = "mass_kg", .unit = "kg", .min = -1e4, .max = 1e5, .typical = 15.0}},
    .machine = machine,
};
