#include "machine.h"

enum { P1, P2 };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) {
        m->sensors.p1[leg].offset += v->value[P1][leg];
        m->sensors.p2[leg].offset += v->value[P2][leg];
    }
}

extern const struct effect pressure_sensor_scale;

const struct effect pressure_sensor_offset = {
    .name = "pressure_sensor_offset",
    .family = EFFECT_SENSORS,
    .plain = "an offset of the pressure sensors",
    .law = "readings = P1 + p1, P2 + p2",
    .signature = "force: static only",
    .law_error = 1e-3,
    .keys = {[P1] = {.name = "p1", .unit = "Pa", .min = -1e7, .max = 1e7, .typical = 1e5, .per_leg = true},
             [P2] = {.name = "p2", .unit = "Pa", .min = -1e7, .max = 1e7, .typical = 1e5, .per_leg = true}},
    .told_apart = {{.from = &pressure_sensor_scale,
                    .record = "repeat z with another payload",
                    .record_axis = "a test with another load",
                    .shows = "a scale grows with the pressure, an offset does not"}},
    .machine = machine,
};
