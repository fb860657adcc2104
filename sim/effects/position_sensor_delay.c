#include "machine.h"

enum { DELAY };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->sensors.length[leg].delay_s += v->value[DELAY][leg];
}

const struct effect position_sensor_delay = {
    .name = "position_sensor_delay",
    .family = EFFECT_TIMING,
    .plain = "a delay of the position sensors",
    .law = "reading = length of delay ago",
    .signature = "leg length: phase that grows with frequency, against pressures and valve command alike",
    .law_error = 0.01,
    .keys = {[DELAY] = {.name = "delay_s", .unit = "s", .min = 0.0, .max = 0.1, .typical = 2e-3, .per_leg = true}},
    .parallel_to = {"skew of the lengths"},
    .machine = machine,
};
