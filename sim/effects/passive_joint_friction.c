#include "effect.h"

enum { COULOMB, VISCOUS };

static void joint_friction(const struct effect_values *v, int leg, double speed_radps, struct friction *add) {
    add->dry += v->value[COULOMB][leg];
    add->viscous += v->value[VISCOUS][leg] * speed_radps;
}

const struct effect passive_joint_friction = {
    .name = "passive_joint_friction",
    .family = EFFECT_JOINTS,
    .plain = "friction in the universal joints",
    .law = "M = -M_c sign(w) - b w about each axis of both universal joints of a leg (geometry.upper_joint_axes, lower_joint_axes), w the "
           "joint's rate; at rest holds up to M_c",
    .signature = "leg force: odd harmonics and jumps at the reversals of the joints, which on tilting tests differ from those of the leg",
    /* A joint whose axis of rotation is at an angle a to one of its two crossed axes has |sin a| +
     * |cos a| times the dry friction of one axis. If the directions of the axes are unknown, so is
     * a. The friction is then known only to +-17 % about the middle of its range, a standard
     * deviation of 10 %. This error is the same in all upper joints, and the same in all lower
     * joints. On another rig the law was off by 11 % in all legs; 0.15 leaves room for that. */
    .law_error = 0.15,
    .keys = {[COULOMB] = {.name = "coulomb_nm", .unit = "N m", .min = 0.0, .max = 1e3, .typical = 5.0, .per_leg = true},
             [VISCOUS] = {.name = "viscous_nm_s", .unit = "N m s", .min = 0.0, .max = 1e4, .typical = 20.0, .per_leg = true}},
    .joint_friction = joint_friction,
};
