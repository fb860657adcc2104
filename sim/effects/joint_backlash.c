#include "machine.h"

enum { CLEARANCE };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->bodies.clearance_m[leg] += v->value[CLEARANCE][leg];
}

const struct effect joint_backlash = {
    .name = "joint_backlash",
    .family = EFFECT_JOINTS,
    .plain = "backlash in the legs' joints",
    .law = "free play between rod and platform, along the leg: the rod hangs on the piston and pushes the joint only where it is "
           "clearance/2 ahead of it, or behind",
    .signature = "leg force: no more than the rod itself needs while the joint is loose, where the leg's push changes its sign, and a "
                 "knock after it; nothing in a leg that only pushes",
    .law_error = 0.1,
    .keys = {[CLEARANCE] = {.name = "clearance_m", .unit = "m", .min = 0.0, .max = 5e-3, .typical = 5e-4, .per_leg = true}},
    .machine = machine,
};
