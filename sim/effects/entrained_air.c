#include "machine.h"

enum { BULK };

#define NONE_PA 3e9 /* neutral value, stiffer than any oil; the effect is then off */

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++)
        if (v->value[BULK][leg] < NONE_PA) m->oil.bulk_modulus_pa[leg] = v->value[BULK][leg];
}

extern const struct effect internal_leakage;

const struct effect entrained_air = {
    .name = "entrained_air",
    .family = EFFECT_OIL,
    .plain = "a different bulk modulus of the oil (air)",
    .law = "bulk modulus = bulk_modulus_pa (effective, with air) in place of hydraulics.bulk_modulus_pa",
    .signature = "valve command against pressures: a flow in phase with the pressures' rates; spool reversals are passed more slowly",
    .law_error = 1e-3,
    .keys = {[BULK] = {.name = "bulk_modulus_pa",
                       .unit = "Pa",
                       .min = 1e7,
                       .max = NONE_PA,
                       .neutral = NONE_PA,
                       .typical = 6e8,
                       .per_leg = true,
                       .reciprocal = true}},
    .parallel_to = {"hydraulics.bulk_modulus_pa"},
    .told_apart = {{.from = &internal_leakage,
                    .record = "`--set tests.frequency_hz=2`",
                    .record_axis = "a test at half the frequency",
                    .shows = "leakage shows in the mean pressures, air in the phase"}},
    .machine = machine,
};
