#include "machine.h"

enum { OFFSET };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->sensors.length[leg].offset += v->value[OFFSET][leg];
}

extern const struct effect position_sensor_scale;

const struct effect position_sensor_offset = {
    .name = "position_sensor_offset",
    .family = EFFECT_SENSORS,
    .plain = "an offset of the position sensors",
    .law = "reading = length + offset",
    .signature = "leg length: static; one leg's alone turns the platform, static forces change with it",
    .law_error = 1e-3,
    .keys = {[OFFSET] = {.name = "offset_m", .unit = "m", .min = -0.1, .max = 0.1, .typical = 5e-3, .per_leg = true}},
    .told_apart = {{.from = &position_sensor_scale,
                    .record = "`--set tests.amplitude_m=0.012 --set tests.amplitude_rad=0.018 --set tests.frequency_hz=2`",
                    .record_axis = "a test at three times the amplitude",
                    .shows = "a scale grows with the motion, an offset does not"}},
    .parallel_to = {"zero of the length"},
    .machine = machine,
};
