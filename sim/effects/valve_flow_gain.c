#include "machine.h"

enum { SCALE };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->valve.flow_scale[leg] *= v->value[SCALE][leg];
}

const struct effect valve_flow_gain = {
    .name = "valve_flow_gain",
    .family = EFFECT_VALVE,
    .plain = "a different flow gain of the valves",
    .law = "flow of both ports times scale",
    .signature = "valve command: the fundamental in phase with velocity; the pressures hardly change",
    .law_error = 1e-3,
    .keys = {[SCALE] = {.name = "scale", .unit = "-", .min = 0.1, .max = 5.0, .neutral = 1.0, .typical = 0.9, .per_leg = true}},
    .parallel_to = {"hydraulics.valve_flow_m3_per_s"},
    .machine = machine,
};
