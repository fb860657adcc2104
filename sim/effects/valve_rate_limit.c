#include <math.h>

#include "machine.h"

enum { RATE };

static const double NONE_PER_S = 1e4; /* neutral value of the rate: the spool's speed is not
                                       * limited */

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++)
        if (v->value[RATE][leg] < fmin(NONE_PER_S, m->valve.rate_per_s[leg])) m->valve.rate_per_s[leg] = v->value[RATE][leg];
}

const struct effect valve_rate_limit = {
    .name = "valve_rate_limit",
    .family = EFFECT_VALVE,
    .plain = "a speed limit of the valves' spools",
    .law = "|xdot| <= rate, x the spool",
    .signature = "valve command against flow: triangles for sines when fast, third harmonic and phase that grow with amplitude "
                 "and frequency",
    .law_error = 0.02,
    .keys = {[RATE] = {.name = "per_s",
                       .unit = "1/s",
                       .min = 0.01,
                       .max = 1e4,
                       .neutral = 1e4,
                       .typical = 3.0,
                       .per_leg = true,
                       .reciprocal = true}},
    .machine = machine,
};
