#include "machine.h"

enum { XX, YY, ZZ };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int i = XX; i <= ZZ; i++) m->bodies.payload_inertia_kg_m2[i] += v->value[i][0];
}

const struct effect payload_rotational_inertia = {
    .name = "payload_rotational_inertia",
    .family = EFFECT_BODIES,
    .plain = "a different rotational inertia of the payload",
    .law = "Ic = payload.inertia + diag(xx, yy, zz), about the payload's mass centre",
    .signature = "leg forces: in phase with the acceleration of the rotations, nothing at rest",
    .law_error = 1e-3,
    .keys = {[XX] = {.name = "xx", .unit = "kg m^2", .min = -1e4, .max = 1e5, .typical = 6.0},
             [YY] = {.name = "yy", .unit = "kg m^2", .min = -1e4, .max = 1e5, .typical = 6.0},
             [ZZ] = {.name = "zz", .unit = "kg m^2", .min = -1e4, .max = 1e5, .typical = 10.0}},
    .parallel_to = {"payload.inertia_xx_kg_m2", "payload.inertia_yy_kg_m2", "payload.inertia_zz_kg_m2"},
    .machine = machine,
};
