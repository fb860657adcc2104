#include <math.h>

#include "effect.h"

enum { X, Y, Z, PHI, THETA, PSI };

/* The springs act on the three angles, but a moment does work on the angular velocity. With omega =
 * E(angles) rates, moment = E^-T force. */
static void wrench(const struct effect_values *v, const double pose[DOFS], double wrench[DOFS]) {
    double force[DOFS], cp = cos(pose[PSI]), sp = sin(pose[PSI]), ct = cos(pose[THETA]), tt = tan(pose[THETA]);
    for (int i = X; i <= PSI; i++) force[i] = -v->value[i][0] * pose[i];
    double across = force[PHI] / ct + force[PSI] * tt;
    for (int i = X; i <= Z; i++) wrench[i] += force[i];
    wrench[PHI] += cp * across - sp * force[THETA];
    wrench[THETA] += sp * across + cp * force[THETA];
    wrench[PSI] += force[PSI];
}

extern const struct effect payload_mass, payload_rotational_inertia;

const struct effect external_stiffness = {
    .name = "external_stiffness",
    .family = EFFECT_LOAD,
    .plain = "stiffness of hoses and cables",
    .law = "hoses and cables: springs -k_i pose_i on the six coordinates of the pose, zero at neutral",
    .signature = "leg forces: in phase with the displacement; at one frequency as an inertia of -k/w^2, a second frequency tells",
    .law_error = 1e-3,
    .keys = {[X] = {.name = "x", .unit = "N/m", .min = -1e7, .max = 1e7, .typical = 2e4},
             [Y] = {.name = "y", .unit = "N/m", .min = -1e7, .max = 1e7, .typical = 2e4},
             [Z] = {.name = "z", .unit = "N/m", .min = -1e7, .max = 1e7, .typical = 4e3},
             [PHI] = {.name = "phi", .unit = "N m/rad", .min = -1e6, .max = 1e6, .typical = 4e3},
             [THETA] = {.name = "theta", .unit = "N m/rad", .min = -1e6, .max = 1e6, .typical = 4e3},
             [PSI] = {.name = "psi", .unit = "N m/rad", .min = -1e6, .max = 1e6, .typical = 4e3}},
    .told_apart = {{.from = &payload_mass,
                    .record = "`--tests x,y,z --set tests.frequency_hz=2 --set tests.amplitude_m=0.016`",
                    .record_axis = "a test at half the frequency",
                    .shows = "the force of a mass falls with the square of the frequency, a spring's stays"},
                   {.from = &payload_rotational_inertia,
                    .record = "`--tests phi,theta,psi --set tests.frequency_hz=2 --set tests.amplitude_rad=0.024`",
                    .shows = "the force of an inertia falls with the square of the frequency, a spring's stays"}},
    .wrench = wrench,
};
