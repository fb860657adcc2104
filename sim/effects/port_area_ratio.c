#include "machine.h"

enum { RATIO };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) m->port_ratio[leg] *= v->value[RATIO][leg];
}

const struct effect port_area_ratio = {
    .name = "port_area_ratio",
    .plain = "another ratio of the valves' two port areas",
    .law = "flow of port B (rod side) times ratio; 0.49 matches this cylinder, whose pressures then do not jump where the spool reverses",
    .signature = "pressures: another level, and another jump where the spool reverses; valve command: unlike for the two directions",
    .keys = {[RATIO] = {.name = "ratio", .unit = "-", .min = 0.1, .max = 5.0, .neutral = 1.0, .typical = 0.49, .per_leg = true}},
    .machine = machine,
};
