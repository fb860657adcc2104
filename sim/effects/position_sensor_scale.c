#include "machine.h"

enum { SCALE, ZERO };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) {
        double scale = v->value[SCALE][leg];
        m->sensors.length[leg].scale *= scale;
        m->sensors.length[leg].offset += (1.0 - scale) * (m->bodies.neutral_length_m[leg] + v->value[ZERO][leg]);
    }
}

extern const struct effect position_sensor_offset;

const struct effect position_sensor_scale = {
    .name = "position_sensor_scale",
    .family = EFFECT_SENSORS,
    .plain = "a scale error of the position sensors",
    .law = "reading = length + (scale - 1) (length - neutral length - zero): true where the leg is longer than at neutral by zero",
    .signature = "leg length: static and moving alike; forces as of another motion",
    .law_error = 1e-3,
    .keys = {[SCALE] = {.name = "scale", .unit = "-", .min = 0.8, .max = 1.2, .neutral = 1.0, .typical = 1.03, .per_leg = true},
             [ZERO] = {.name = "zero_m", .unit = "m", .min = -5.0, .max = 5.0, .typical = -0.2, .per_leg = true, .shapes_law = true}},
    .contains = {&position_sensor_offset}, /* limiting case for a distant zero_m */
    .parallel_to = {"gain of the length"},
    .machine = machine,
};
