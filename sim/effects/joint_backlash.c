#include "machine.h"

enum { CLEARANCE };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->bodies.clearance_m[leg] += v->value[CLEARANCE][leg];
}

const struct effect joint_backlash = {
    .name = "joint_backlash",
    .plain = "backlash in the legs' joints",
    .law = "free play along the leg at its end: the measured length is the joints' distance + clearance/2 sign(force on the joint)",
    .signature = "leg length and force: a step of the length and a pause of the force where the leg's force changes sign; "
                 "nothing in a leg that only pushes",
    .law_error = 0.05,
    .keys = {[CLEARANCE] = {.name = "clearance_m", .unit = "m", .min = 0.0, .max = 5e-3, .typical = 5e-4, .per_leg = true}},
    .machine = machine,
};
