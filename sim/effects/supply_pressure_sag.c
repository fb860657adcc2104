#include "machine.h"

enum { RESISTANCE };

static void machine(const struct effect_values *v, struct machine *m) { m->supply.resistance_pa_s_per_m3 += v->value[RESISTANCE][0]; }

const struct effect supply_pressure_sag = {
    .name = "supply_pressure_sag",
    .family = EFFECT_SUPPLY,
    .plain = "a supply pressure that sags under flow",
    .law = "supply = Ps - R Q, Q the flow of all six valves from the supply, lagged by 10 ms",
    .signature = "pressures and valve commands of all legs at once: twice the frequency where the legs go up and down together, "
                 "static where they do not",
    .law_error = 1e-3,
    .keys = {[RESISTANCE] = {.name = "resistance_pa_s_per_m3", .unit = "Pa s/m^3", .min = 0.0, .max = 1e11, .typical = 1e9}},
    .parallel_to = {"hydraulics.supply_pa"},
    .machine = machine,
};
