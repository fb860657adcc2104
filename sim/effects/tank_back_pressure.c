#include "machine.h"

enum { RESISTANCE };

static void machine(const struct effect_values *v, struct machine *m) { m->supply.tank_resistance_pa_s_per_m3 += v->value[RESISTANCE][0]; }

const struct effect tank_back_pressure = {
    .name = "tank_back_pressure",
    .family = EFFECT_SUPPLY,
    .plain = "a back pressure of the tank line",
    .law = "tank = Pt + R Q, Q the flow of all six valves to the tank",
    .signature = "pressures of the draining chambers of all legs: up with the legs' speed, second harmonic",
    .law_error = 1e-3,
    .keys = {[RESISTANCE] = {.name = "resistance_pa_s_per_m3", .unit = "Pa s/m^3", .min = 0.0, .max = 1e11, .typical = 5e8}},
    .machine = machine,
};
