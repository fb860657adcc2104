#include "effect.h"

#include <math.h>
#include <string.h>

const struct effect_family_words effect_families[EFFECT_FAMILIES] = {
    [EFFECT_FRICTION] = {"cylinder_friction", "friction in the cylinders"},
    [EFFECT_JOINTS] = {"joints", "friction or play of the joints"},
    [EFFECT_BODIES] = {"bodies", "masses, mass centres or inertias"},
    [EFFECT_LOAD] = {"position_load", "a load that depends on position"},
    [EFFECT_VALVE] = {"valve", "the valves"},
    [EFFECT_OIL] = {"oil", "oil, leakage or lines"},
    [EFFECT_SUPPLY] = {"supply", "supply or tank"},
    [EFFECT_SENSORS] = {"sensors", "the sensors"},
    [EFFECT_TIMING] = {"timing", "delays or clocks"},
    [EFFECT_GEOMETRY] = {"geometry", "geometry"},
};

int effect_find(const char *name) {
    for (int i = 0; effect_table[i]; i++)
        if (strcmp(effect_table[i]->name, name) == 0) return i;
    return -1;
}

static double key_at(const struct effect_key *k, double strength) {
    if (strength == 0.0) return k->neutral;
    double value = k->reciprocal ? 1.0 / (1.0 / k->neutral + strength * (1.0 / k->typical - 1.0 / k->neutral))
                                 : k->neutral + strength * (k->typical - k->neutral);
    return fmin(fmax(value, k->min), k->max);
}

bool effect_neutral(const struct effect_key *key, const double value[LEGS]) {
    bool neutral = true;
    for (int leg = 0; leg < LEGS; leg++) neutral = neutral && value[leg] == key->neutral;
    return neutral;
}

bool effect_acts(const struct effect *effect, const struct effect_values *values) {
    bool acts = false;
    for (int k = 0; k < EFFECT_KEYS && effect->keys[k].name; k++)
        acts = acts || (!effect->keys[k].shapes_law && !effect_neutral(&effect->keys[k], values->value[k]));
    return acts;
}

void effect_at(const struct effect *effect, double strength, struct effect_values *values) {
    *values = (struct effect_values){.on = true};
    for (int k = 0; k < EFFECT_KEYS && effect->keys[k].name; k++)
        for (int leg = 0; leg < LEGS; leg++) values->value[k][leg] = key_at(&effect->keys[k], strength);
}
