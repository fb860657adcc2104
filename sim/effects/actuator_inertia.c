#include "machine.h"

enum { AXIAL, TRANSVERSE };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) {
        m->axial_kg[leg] += v->value[AXIAL][leg];
        m->transverse_kg_m2[leg] += v->value[TRANSVERSE][leg];
    }
}

const struct effect actuator_inertia = {
    .name = "actuator_inertia",
    .plain = "another moving mass of the actuators",
    .law = "adds axial Ldot^2/2 + transverse Omega^2/2 to a leg's kinetic energy: ma + axial along it, g(L) + transverse across; no weight",
    .signature = "leg forces: in phase with the acceleration on all axes, nothing at rest",
    .keys = {[AXIAL] = {.name = "axial_kg", .unit = "kg", .min = -1e3, .max = 1e4, .typical = 5.0, .per_leg = true},
             [TRANSVERSE] = {.name = "transverse_kg_m2", .unit = "kg m^2", .min = -1e3, .max = 1e4, .typical = 5.0, .per_leg = true}},
    .machine = machine,
};
