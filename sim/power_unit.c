#include "power_unit.h"

#include <math.h>

static const double FILL_S = 0.2, DUMP_S = 0.02, SWITCH_CLOSES = 0.8, SWITCH_OPENS = 0.6;

void power_unit_init(struct power_unit *u, double hold_s) { *u = (struct power_unit){.hold_s = hold_s, .still_s = (double)INFINITY}; }

void power_unit_step(struct power_unit *u, bool level, double dt_s) {
    u->still_s = level != u->level ? 0.0 : u->still_s + dt_s;
    u->level = level;
    if (u->still_s <= u->hold_s) u->share = fmin(u->share + dt_s / FILL_S, 1.0);
    else u->share *= exp(-dt_s / DUMP_S);
    u->pressure = u->share >= (u->pressure ? SWITCH_OPENS : SWITCH_CLOSES);
}
