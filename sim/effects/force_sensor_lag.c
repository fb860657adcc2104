#include "machine.h"

enum { CUTOFF };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->sensors.force[leg].lag_s += sensor_lag_s(v->value[CUTOFF][leg]);
}

extern const struct effect cylinder_viscous_friction;

const struct effect force_sensor_lag = {
    .name = "force_sensor_lag",
    .family = EFFECT_SENSORS,
    .plain = "a lag of the force sensors",
    .law = "readings follow the force in first order with this cut-off frequency, as an amplifier's filter makes them; no lag from 100 kHz "
           "on; nothing where pressures are measured",
    .signature = "force: phase and amplitude that fall with frequency; of an inertia like viscous friction that grows with the square of "
                 "the frequency, of a spring like friction of the wrong sign",
    .law_error = 0.01,
    .keys = {[CUTOFF] = {.name = "cutoff_hz",
                         .unit = "Hz",
                         .min = 1.0,
                         .max = 1e5,
                         .neutral = 1e5,
                         .typical = 100.0,
                         .per_leg = true,
                         .reciprocal = true}},
    .parallel_to = {"axis.force_lag_s"},
    .told_apart = {{.from = &cylinder_viscous_friction,
                    .record = "a test at a quarter of the frequency",
                    .shows = "what a lag makes of an inertia falls with the cube of the frequency, viscous friction with the frequency"}},
    .machine = machine,
};
