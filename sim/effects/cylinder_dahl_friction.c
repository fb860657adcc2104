#include <math.h>

#include "machine.h"

enum { EXTEND, RETRACT, DISTANCE };

static void machine(const struct effect_values *v, struct machine *m) {
    for (int leg = 0; leg < LEGS; leg++) {
        double force_n = fmax(v->value[EXTEND][leg], v->value[RETRACT][leg]);
        if (!(force_n > 0.0)) continue;
        m->seals.distance_m[leg] = v->value[DISTANCE][leg];
        m->seals.stiffness_n_per_m[leg] = force_n / v->value[DISTANCE][leg];
    }
}

static void leg_friction(const struct effect_values *v, int leg, const struct leg_motion *motion, struct friction *add) {
    add->elastic += v->value[motion->deflection > 0.0 ? EXTEND : RETRACT][leg] * motion->deflection;
}

extern const struct effect cylinder_coulomb_friction, external_stiffness;

const struct effect cylinder_dahl_friction = {
    .name = "cylinder_dahl_friction",
    .family = EFFECT_FRICTION,
    .plain = "dry friction of seals that are deflected like springs before they slide (presliding, Dahl)",
    .law = "F = -F_extend z for z > 0, -F_retract z for z < 0; deflection z: zdot = (Ldot - |Ldot| z) / distance",
    .signature = "leg force: as Coulomb friction, but after a velocity reversal it comes back over a distance, not at once: odd harmonics "
                 "that lag the velocity; at small strokes a spring",
    .law_error = 0.05,
    .keys = {[EXTEND] = {.name = "force_extend_n", .unit = "N", .min = 0.0, .max = 2e4, .typical = 100.0, .per_leg = true},
             [RETRACT] = {.name = "force_retract_n", .unit = "N", .min = 0.0, .max = 2e4, .typical = 100.0, .per_leg = true},
             [DISTANCE] = {.name = "distance_m",
                           .unit = "m",
                           .min = 1e-5,
                           .max = 5e-3,
                           .neutral = 2e-4,
                           .typical = 2e-4,
                           .per_leg = true,
                           .shapes_law = true}},
    .parallel_to = {"axis.force_offset_n"}, /* friction that is stronger in one direction looks like
                                             * a constant force */
    .contains = {&cylinder_coulomb_friction},      /* limiting case for a short distance_m */
    .told_apart = {{.from = &cylinder_coulomb_friction,
                    .record = "`--tests z --set tests.amplitude_m=0.001`",
                    .record_axis = "a stroke of a millimetre",
                    .shows = "within its seals' deflection a cylinder is a spring; under Coulomb friction it is held, or slides"},
                   {.from = &external_stiffness,
                    .record = "`--tests z --set tests.amplitude_m=0.01`",
                    .record_axis = "a test of a longer stroke",
                    .shows = "seals slide, and their force stays; that of a spring grows"},
                   {.from_parameter = "axis.force_offset_n",
                    .record = "let go of the load and read the force at rest, coming from both sides",
                    .shows = "an offset stays, friction changes its sign"}},
    .machine = machine,
    .leg_friction = leg_friction,
};
