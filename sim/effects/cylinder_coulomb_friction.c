#include "effect.h"

enum { EXTEND, RETRACT };

static void leg_friction(const struct effect_values *v, int leg, const struct leg_motion *motion, struct friction *add) {
    add->dry += v->value[motion->direction > 0 ? EXTEND : RETRACT][leg];
}

extern const struct effect cylinder_stribeck_friction, load_dependent_friction, passive_joint_friction;

const struct effect cylinder_coulomb_friction = {
    .name = "cylinder_coulomb_friction",
    .family = EFFECT_FRICTION,
    .plain = "dry (Coulomb) friction in the cylinders",
    .law = "F = -F_extend for Ldot > 0, +F_retract for Ldot < 0; at rest holds up to that force",
    .signature = "leg force: odd harmonics in phase with velocity, jump at velocity reversal; with one direction stronger also the mean",
    .law_error = 0.05,
    .keys = {[EXTEND] = {.name = "force_extend_n", .unit = "N", .min = 0.0, .max = 2e4, .typical = 100.0, .per_leg = true},
             [RETRACT] = {.name = "force_retract_n", .unit = "N", .min = 0.0, .max = 2e4, .typical = 100.0, .per_leg = true}},
    .parallel_to = {"axis.force_offset_n"}, /* friction that is stronger in one direction looks like
                                             * a constant force */
    .told_apart = {{.from = &cylinder_stribeck_friction,
                    .record = "`--tests z --set tests.frequency_hz=0.5 --set tests.duration_s=20`",
                    .record_axis = "a test that stays below 10 mm/s",
                    .shows = "below 10 mm/s Stribeck friction rises, Coulomb friction stays"},
                   {.from = &load_dependent_friction,
                    .record = "repeat z with another payload",
                    .record_axis = "a test with another load",
                    .shows = "load-dependent friction changes with the pressures"},
                   {.from = &passive_joint_friction,
                    .record = "`--tests psi`",
                    .shows = "the joints turn there while the legs hardly move"},
                   {.from_parameter = "axis.force_offset_n",
                    .record = "let go of the load and read the force at rest, coming from both sides",
                    .shows = "an offset stays, friction changes its sign"}},
    .leg_friction = leg_friction,
};
