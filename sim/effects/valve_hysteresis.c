#include "effect.h"

enum { WIDTH };

/* Returns the output of a valve with backlash, which follows the command at a distance of half the
 * width. */
static double command(const struct effect_values *v, int leg, double command, double *memory) {
    double half = 0.5 * v->value[WIDTH][leg], low = command - half, high = command + half;
    return *memory = *memory < low ? low : *memory > high ? high : *memory;
}

const struct effect valve_hysteresis = {
    .name = "valve_hysteresis",
    .family = EFFECT_VALVE,
    .plain = "hysteresis of the valves",
    .law = "the servo follows the command with a play of width: it stands until the command is width/2 away from it",
    .signature = "valve command against flow: a step at every reversal of the command, odd harmonics that lag behind it, "
                 "whatever the frequency",
    .law_error = 0.05,
    .keys = {[WIDTH] = {.name = "width", .unit = "-", .min = 0.0, .max = 0.5, .typical = 0.01, .per_leg = true}},
    .command = command,
};
