/* The catalogue of effects (gap.md's order). A new effect is one file, sim/effects/<name>.c, that defines `const struct effect <name>`,
 * and its line here. */
#ifndef HEXID_EFFECTS_H
#define HEXID_EFFECTS_H

#include "effect.h"

#define EFFECT_LIST(EFFECT)           \
    EFFECT(cylinder_coulomb_friction) \
    EFFECT(cylinder_viscous_friction) \
    EFFECT(passive_joint_friction)

#define EFFECT_DECLARE(name) extern const struct effect name;
EFFECT_LIST(EFFECT_DECLARE)
#undef EFFECT_DECLARE

#endif
