#include "machine.h"

enum { DELAY };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->timing.command_delay_s[leg] += v->value[DELAY][leg];
}

extern const struct effect position_sensor_delay, valve_lag;

const struct effect command_delay = {
    .name = "command_delay",
    .family = EFFECT_TIMING,
    .plain = "a delay of the valve commands",
    .law = "the servo gets the valve command of delay ago",
    .signature = "valve command against flow: phase that grows with frequency; near valve_lag while small, a test above 12 Hz or "
                 "a step tells",
    .law_error = 0.02,
    .keys = {[DELAY] = {.name = "delay_s", .unit = "s", .min = 0.0, .max = 0.1, .typical = 2e-3, .per_leg = true}},
    .parallel_to = {"hydraulics.valve_damping"},
    .told_apart = {{.from = &position_sensor_delay,
                    .record = "`--tests z --set tests.frequency_hz=20 --set tests.amplitude_m=0.001`",
                    .record_axis = "a test at five times the frequency, of small amplitude",
                    .shows = "the sensor's delay shifts length against pressure, the command's does not"},
                   {.from = &valve_lag,
                    .record = "`--tests z --set tests.amplitude_m=0.0005 --set tests.frequency_hz=36`",
                    .record_axis = "a test at five times the frequency, of small amplitude",
                    .shows = "a delay's phase grows with frequency, a lag also loses amplitude"}},
    .machine = machine,
};
