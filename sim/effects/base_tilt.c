#include <math.h>

#include "machine.h"

enum { PHI, THETA };

/* Ry(theta) Rx(phi) rotates from {B} to a level frame; its last row is `down`, the vertical in
 * {B}. */
static void machine(const struct effect_values *v, struct machine *m) {
    double phi = v->value[PHI][0], theta = v->value[THETA][0];
    m->bodies.down[0] = -sin(theta);
    m->bodies.down[1] = cos(theta) * sin(phi);
    m->bodies.down[2] = cos(theta) * cos(phi);
}

extern const struct effect payload_center_of_mass;

const struct effect base_tilt = {
    .name = "base_tilt",
    .family = EFFECT_GEOMETRY,
    .plain = "a tilt of the base",
    .law = "the base stands at Ry(theta) Rx(phi) to the vertical: gravity along (-sin theta, cos theta sin phi, cos theta cos phi) of {B}",
    .signature = "leg forces: static only, in the pattern of a horizontal force; the moving parts hardly change",
    .law_error = 1e-3,
    .keys = {[PHI] = {.name = "phi_rad", .unit = "rad", .min = -0.5, .max = 0.5, .typical = 0.01},
             [THETA] = {.name = "theta_rad", .unit = "rad", .min = -0.5, .max = 0.5, .typical = -0.01}},
    .told_apart = {{.from = &payload_center_of_mass,
                    .record = "turn the payload by half a turn",
                    .shows = "the tilt's static forces stay"}},
    .machine = machine,
};
