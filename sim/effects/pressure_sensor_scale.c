#include "machine.h"

enum { P1, P2 };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) {
        m->sensors.p1[leg].scale *= v->value[P1][leg];
        m->sensors.p2[leg].scale *= v->value[P2][leg];
    }
}

const struct effect pressure_sensor_scale = {
    .name = "pressure_sensor_scale",
    .family = EFFECT_SENSORS,
    .plain = "a scale error of the pressure sensors",
    .law = "readings = P1 times p1, P2 times p2",
    .signature = "force in phase with itself, static and moving alike; near an offset, a second static load tells",
    .law_error = 1e-3,
    .keys = {[P1] = {.name = "p1", .unit = "-", .min = 0.5, .max = 2.0, .neutral = 1.0, .typical = 1.02, .per_leg = true},
             [P2] = {.name = "p2", .unit = "-", .min = 0.5, .max = 2.0, .neutral = 1.0, .typical = 0.99, .per_leg = true}},
    .parallel_to = {"gain of P1", "gain of P2"},
    .machine = machine,
};
