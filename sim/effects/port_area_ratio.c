#include "machine.h"

enum { RATIO };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->valve.port_ratio[leg] *= v->value[RATIO][leg];
}

extern const struct effect supply_pressure_sag;

const struct effect port_area_ratio = {
    .name = "port_area_ratio",
    .family = EFFECT_VALVE,
    .plain = "a different ratio of the valves' two port areas",
    .law = "flow of port B (rod side) times ratio; 0.49 matches this cylinder, whose pressures then do not jump where the spool reverses",
    .signature = "pressures: another level, and another jump where the spool reverses; valve command: unlike for the two directions",
    .law_error = 1e-3,
    .keys = {[RATIO] = {.name = "ratio", .unit = "-", .min = 0.1, .max = 5.0, .neutral = 1.0, .typical = 0.49, .per_leg = true}},
    .told_apart = {{.from = &supply_pressure_sag,
                    .record = "`--set tests.amplitude_m=0.002 --set tests.amplitude_rad=0.003`",
                    .record_axis = "a test at half the amplitude",
                    .shows = "sag falls with the square of the flow"}},
    .machine = machine,
};
