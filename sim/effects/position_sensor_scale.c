#include "machine.h"

enum { SCALE };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->length[leg].scale *= v->value[SCALE][leg];
}

const struct effect position_sensor_scale = {
    .name = "position_sensor_scale",
    .plain = "a scale error of the length sensors",
    .law = "reading = scale times the joint-to-joint length",
    .signature = "leg length: static and moving alike; forces as of another motion",
    .keys = {[SCALE] = {.name = "scale", .unit = "-", .min = 0.9, .max = 1.1, .neutral = 1.0, .typical = 1.005, .per_leg = true}},
    .machine = machine,
};
