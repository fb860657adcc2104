#include "machine.h"

enum { MASS };

static void machine(const struct effect_values *v, struct machine *m) { m->bodies.payload_kg += v->value[MASS][0]; }

extern const struct effect position_sensor_scale, pressure_sensor_scale;

const struct effect payload_mass = {
    .name = "payload_mass",
    .family = EFFECT_BODIES,
    .plain = "a different mass of the payload",
    .law = "m = payload.mass_kg + mass, at the payload's mass centre",
    .signature = "leg forces: static, and in phase with the acceleration of the translations",
    .law_error = 1e-3,
    .keys = {[MASS] = {.name = "mass_kg", .unit = "kg", .min = -1e4, .max = 1e5, .typical = 15.0}},
    .parallel_to = {"payload.mass_kg", "axis.mass_kg"},
    .told_apart = {{.from = &position_sensor_scale,
                    .record = "hold a rule against the stroke",
                    .shows = "the position sensor's scale shows at rest"},
                   {.from = &pressure_sensor_scale,
                    .record = "repeat z with the payload taken off",
                    .record_axis = "a test with the load taken off",
                    .shows = "a scale's force shrinks with the load, a missing mass is gone"}},
    .machine = machine,
};
