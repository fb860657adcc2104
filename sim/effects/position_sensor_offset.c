#include "machine.h"

enum { OFFSET };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->length[leg].offset += v->value[OFFSET][leg];
}

const struct effect position_sensor_offset = {
    .name = "position_sensor_offset",
    .plain = "an offset of the length sensors",
    .law = "reading = length + offset",
    .signature = "leg length: static; one leg's alone turns the platform, static forces change with it",
    .keys = {[OFFSET] = {.name = "offset_m", .unit = "m", .min = -0.1, .max = 0.1, .typical = 5e-3, .per_leg = true}},
    .machine = machine,
};
