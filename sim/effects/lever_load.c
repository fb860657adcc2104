#include <math.h>

#include "effect.h"

enum { SLOPE, BEND, TURN };

/* Returns sin(a) / a for square = a^2 >= 0, and sinh(a) / a for square = -a^2; the function is
 * analytic in `square`. In sinh, a is at most 30, so that no result is infinite. */
static double sinc(double square) {
    double a = fmin(sqrt(fabs(square)), square > 0.0 ? HUGE_VAL : 30.0);
    if (a < 1e-3) return 1.0 - square / 6.0;
    return square > 0.0 ? sin(a) / a : sinh(a) / a;
}

static void wrench(const struct effect_values *v, const double pose[DOFS], double wrench[DOFS]) {
    double x = pose[DOF_X], square = v->value[TURN][0] * x * x, half = x * sinc(0.25 * square);
    wrench[DOF_X] -= v->value[SLOPE][0] * x * sinc(square) + 0.5 * v->value[BEND][0] * half * half;
}

extern const struct effect external_stiffness;

const struct effect lever_load = {
    .name = "lever_load",
    .family = EFFECT_LOAD,
    .plain = "a load that turns with a lever, such as the weight of a boom or an arm",
    .law = "F_x = -slope sin(w x) / w - bend (1 - cos(w x)) / w^2, w^2 = turn, sinh and cosh below 0; x: position of one axis from "
           "axis.middle_m",
    .signature = "force: in phase with the displacement, and bent over the position: with long strokes also the mean, the second and third "
                 "harmonic",
    .law_error = 0.02,
    .one_axis = true,
    .keys = {[SLOPE] = {.name = "slope_n_per_m", .unit = "N/m", .min = -1e7, .max = 1e7, .typical = 2e4},
             [BEND] = {.name = "bend_n_per_m2", .unit = "N/m^2", .min = -1e9, .max = 1e9, .typical = 1e5},
             [TURN] =
                 {.name = "turn_per_m2", .unit = "1/m^2", .min = -2.5e4, .max = 2.5e4, .neutral = 1.0, .typical = 1.0, .shapes_law = true}},
    .contains = {&external_stiffness}, /* limiting case for no bend and no turn */
    .told_apart = {{.from = &external_stiffness,
                    .record = "`--tests x --set tests.frequency_hz=0.5 --set tests.amplitude_m=0.05`",
                    .record_axis = "the longest stroke that the machine has",
                    .shows = "a spring's force is a straight line over the position, a lever's bends"}},
    .wrench = wrench,
};
