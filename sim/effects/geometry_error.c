#include "machine.h"

enum { A_X, A_Y, A_Z, B_X, B_Y, B_Z };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++)
        for (int i = 0; i < 3; i++) {
            m->bodies.upper_joint_m[leg][i] += v->value[A_X + i][leg];
            m->bodies.lower_joint_m[leg][i] += v->value[B_X + i][leg];
        }
}

extern const struct effect base_tilt, payload_center_of_mass;

const struct effect geometry_error = {
    .name = "geometry_error",
    .family = EFFECT_GEOMETRY,
    .plain = "joints that are not where the configuration has them",
    .law = "joints lie at a_i + (a_x, a_y, a_z) on the platform and at b_i + (b_x, b_y, b_z) on the base",
    .signature = "leg forces: all axes coupled a little, static loads unlike; lengths and poses as measured stay consistent with "
                 "themselves",
    .law_error = 1e-3,
    .keys = {[A_X] = {.name = "a_x_m", .unit = "m", .min = -0.1, .max = 0.1, .typical = 4e-3, .per_leg = true},
             [A_Y] = {.name = "a_y_m", .unit = "m", .min = -0.1, .max = 0.1, .typical = -4e-3, .per_leg = true},
             [A_Z] = {.name = "a_z_m", .unit = "m", .min = -0.1, .max = 0.1, .typical = 4e-3, .per_leg = true},
             [B_X] = {.name = "b_x_m", .unit = "m", .min = -0.1, .max = 0.1, .typical = -4e-3, .per_leg = true},
             [B_Y] = {.name = "b_y_m", .unit = "m", .min = -0.1, .max = 0.1, .typical = 4e-3, .per_leg = true},
             [B_Z] = {.name = "b_z_m", .unit = "m", .min = -0.1, .max = 0.1, .typical = 4e-3, .per_leg = true}},
    .contains = {&base_tilt,               /* special case: all joints rotate by the same angle */
                 &payload_center_of_mass}, /* special case: all joints of the platform shift by the
                                            * same vector */
    .machine = machine,
};
