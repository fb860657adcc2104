#include "machine.h"

enum { LENGTH, DIAMETER };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) {
        m->hose.length_m[leg] += v->value[LENGTH][leg];
        m->hose.diameter_m[leg] = v->value[DIAMETER][leg];
    }
}

extern const struct effect entrained_air;

const struct effect pipeline_dynamics = {
    .name = "pipeline_dynamics",
    .family = EFFECT_OIL,
    .plain = "the oil in the lines between valves and cylinders",
    .law = "a line between each port and its chamber: capacitance, inertance and laminar resistance of 870 kg/m^3 and 4e-5 "
           "m^2/s, one cell; pressures are measured at the valve",
    .signature = "pressures: the lines' drop, ringing where the spool reverses; a long line can make the loop oscillate by itself",
    .law_error = 5e-3,
    .keys = {[LENGTH] = {.name = "length_m", .unit = "m", .min = 0.0, .max = 50.0, .typical = 3.0, .per_leg = true},
             [DIAMETER] = {.name = "diameter_m",
                           .unit = "m",
                           .min = 0.01,
                           .max = 0.1,
                           .neutral = 0.02,
                           .typical = 0.02,
                           .per_leg = true,
                           .shapes_law = true}},
    .contains = {&entrained_air}, /* limiting case for a short wide hose, which is a volume
                                   * of oil */
    .parallel_to = {"length of the pipes", "length of the pipes beside the others'"},
    .machine = machine,
};
