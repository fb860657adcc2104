#include "machine.h"

enum { X, Y, Z };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int i = X; i <= Z; i++) m->bodies.payload_center_m[i] += v->value[i][0];
}

extern const struct effect payload_mass;

const struct effect payload_center_of_mass = {
    .name = "payload_center_of_mass",
    .family = EFFECT_BODIES,
    .plain = "a different mass centre of the payload",
    .law = "the payload's mass centre lies at (x, y, z) of {M} instead of at its origin",
    .signature = "leg forces: unlike static loads (x, y); translations and rotations coupled, in phase with the acceleration",
    .law_error = 1e-3,
    .keys = {[X] = {.name = "x_m", .unit = "m", .min = -1.0, .max = 1.0, .typical = 0.01},
             [Y] = {.name = "y_m", .unit = "m", .min = -1.0, .max = 1.0, .typical = -0.01},
             [Z] = {.name = "z_m", .unit = "m", .min = -1.0, .max = 1.0, .typical = 0.01}},
    .told_apart = {{.from = &payload_mass,
                    .record = "tilt the platform by 0.1 rad and hold",
                    .shows = "the static forces tell mass from its place"}},
    .machine = machine,
};
