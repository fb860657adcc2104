#include "machine.h"

enum { RATIO };

static void machine(const struct effect_values *v, struct machine *m) { m->timing.clock_ratio *= v->value[RATIO][0]; }

const struct effect clock_skew = {
    .name = "clock_skew",
    .family = EFFECT_TIMING,
    .plain = "a recorder's clock that runs at a different speed",
    .law = "time stamps run at ratio times the controller's clock",
    .signature = "time: the reference's frequency by the time stamps is 1/ratio of what it should be; all else unchanged",
    .law_error = 1e-3,
    .keys = {[RATIO] = {.name = "ratio", .unit = "-", .min = 0.9, .max = 1.1, .neutral = 1.0, .typical = 1.001}},
    .machine = machine,
};
