#include "machine.h"

enum { SCALE };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->sensors.force[leg].scale *= v->value[SCALE][leg];
}

extern const struct effect payload_mass, position_sensor_scale;

const struct effect force_sensor_scale = {
    .name = "force_sensor_scale",
    .family = EFFECT_SENSORS,
    .plain = "a scale error of the force sensors",
    .law = "reading = force times scale, where a force sensor or a drive says the force; nothing where pressures do",
    .signature = "a share of the whole force, of inertia, friction and springs alike; on a level axis the same as a scale of the position",
    .law_error = 1e-3,
    .keys = {[SCALE] = {.name = "scale", .unit = "-", .min = 0.2, .max = 5.0, .neutral = 1.0, .typical = 1.03, .per_leg = true}},
    .told_apart = {{.from = &payload_mass,
                    .record = "hang a known weight on the force sensor",
                    .shows = "its scale shows at rest; or a test with a known mass added: a scale multiplies it, a missing mass stays"},
                   {.from = &position_sensor_scale,
                    .record = "hang a known weight on the force sensor",
                    .shows = "its scale shows at rest; the position's beside a rule"}},
    .machine = machine,
};
