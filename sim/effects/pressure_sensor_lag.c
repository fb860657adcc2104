#include "machine.h"

enum { CUTOFF };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) {
        double lag_s = sensor_lag_s(v->value[CUTOFF][leg]);
        m->sensors.p1[leg].lag_s += lag_s;
        m->sensors.p2[leg].lag_s += lag_s;
    }
}

const struct effect pressure_sensor_lag = {
    .name = "pressure_sensor_lag",
    .family = EFFECT_SENSORS,
    .plain = "a lag of the pressure sensors",
    .law = "readings follow both pressures in first order with this cut-off frequency; no lag from 100 kHz on",
    .signature = "pressures: phase and amplitude that fall with frequency, jumps rounded; force against motion, and valve "
                 "command against pressure",
    .law_error = 0.01,
    .keys = {[CUTOFF] = {.name = "cutoff_hz",
                         .unit = "Hz",
                         .min = 1.0,
                         .max = 1e5,
                         .neutral = 1e5,
                         .typical = 50.0,
                         .per_leg = true,
                         .reciprocal = true}},
    .parallel_to = {"lag of the pressures", "lag of the pressures beside the others'"},
    .machine = machine,
};
