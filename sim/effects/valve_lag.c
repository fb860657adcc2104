#include "machine.h"

enum { FREQUENCY };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++)
        if (v->value[FREQUENCY][leg] < m->valve.frequency_hz[leg]) m->valve.frequency_hz[leg] = v->value[FREQUENCY][leg];
}

const struct effect valve_lag = {
    .name = "valve_lag",
    .family = EFFECT_VALVE,
    .plain = "slower spools of the valves",
    .law = "natural frequency of the spool = min(hydraulics.valve_frequency_hz, frequency)",
    .signature = "valve command against flow: phase that grows with frequency; near command_delay while small, a test above 12 "
                 "Hz or a step tells",
    .law_error = 0.02,
    .keys = {[FREQUENCY] = {.name = "frequency_hz",
                            .unit = "Hz",
                            .min = 1.0,
                            .max = 500.0,
                            .neutral = 500.0,
                            .typical = 50.0,
                            .per_leg = true,
                            .reciprocal = true}},
    .parallel_to = {"hydraulics.valve_damping"},
    .machine = machine,
};
