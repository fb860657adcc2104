#include "effect.h"

enum { OVERLAP };

static double opening(const struct effect_values *v, int leg, double spool) {
    double overlap = v->value[OVERLAP][leg];
    return spool > overlap ? spool - overlap : spool < -overlap ? spool + overlap : 0.0;
}

extern const struct effect valve_hysteresis;

const struct effect valve_dead_band = {
    .name = "valve_dead_band",
    .family = EFFECT_VALVE,
    .plain = "a dead band of the valves (overlap)",
    .law = "opening = x - overlap for x > overlap, x + overlap for x < -overlap, 0 between; x the spool",
    .signature = "valve command: a jump where the spool passes zero, odd harmonics; pressures: flat there; at rest the loop may hunt",
    .law_error = 1e-3,
    .keys = {[OVERLAP] = {.name = "overlap", .unit = "-", .min = 0.0, .max = 0.5, .typical = 0.01, .per_leg = true}},
    .told_apart = {{.from = &valve_hysteresis,
                    .record = "`--set tests.amplitude_m=0.002 --set tests.amplitude_rad=0.003`",
                    .record_axis = "a test at half the amplitude",
                    .shows = "a dead band is passed at spool zero, hysteresis at every turn of the command"}},
    .opening = opening,
};
