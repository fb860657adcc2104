#include "hypothesis.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static enum residual_part effect_parts(const struct effect *e) { return e->leg_friction || e->joint_friction ? PART_FORCE : PART_ALL; }

static void add_variable(struct hypothesis *h, int key, int leg) {
    const struct effect *e = effect_table[h->effect];
    const struct effect_key *k = &e->keys[key];
    h->variable[h->variables++] = (struct variable){
        .name = k->name,
        .offset = offsetof(struct params, effects) + (size_t)h->effect * sizeof(struct effect_values) +
                  offsetof(struct effect_values, value) + (size_t)key * LEGS * sizeof(double),
        .leg = leg, .legs = LEGS, .effect = h->effect,
        .min = k->min, .max = k->max, .neutral = k->neutral, .step = 1e-4 * (k->max - k->min), .parts = effect_parts(e),
    };
}

static void build(struct hypothesis *h, int effect, int shape) {
    *h = (struct hypothesis){.effect = effect, .shape = shape};
    const struct effect_key *keys = effect_table[effect]->keys;
    for (int key = 0; key < EFFECT_KEYS && keys[key].name; key++)
        for (int leg = 0; leg < (shape == SHAPE_EACH ? LEGS : 1); leg++)
            add_variable(h, key, shape == SHAPE_EACH && keys[key].per_leg ? leg : shape == SHAPE_EACH ? -1 : shape);
}

int hypotheses_list(const struct params *model, struct hypothesis h[HYPOTHESES_MAX]) {
    int n = 0;
    for (int effect = 0; effect_table[effect]; effect++) {
        if (model->effects[effect].on) continue;
        build(&h[n++], effect, SHAPE_ALL);
        bool per_leg = false;
        for (int key = 0; key < EFFECT_KEYS && effect_table[effect]->keys[key].name; key++) per_leg = per_leg || effect_table[effect]->keys[key].per_leg;
        for (int leg = 0; leg < LEGS && per_leg; leg++) build(&h[n++], effect, leg);
        if (per_leg) build(&h[n++], effect, SHAPE_EACH);
    }
    return n;
}

/* Every key of the effect at the value that adds nothing. */
static void neutral_values(int effect, struct effect_values *values) {
    for (int key = 0; key < EFFECT_KEYS && effect_table[effect]->keys[key].name; key++)
        for (int leg = 0; leg < LEGS; leg++) values->value[key][leg] = effect_table[effect]->keys[key].neutral;
}

bool hypothesis_start(const struct hypothesis *h, int place, struct params *model) {
    double share = pow(10.0, -0.5 - place / 2 * 0.5);
    neutral_values(h->effect, &model->effects[h->effect]);
    for (int i = 0; i < h->variables; i++) {
        const struct variable *v = &h->variable[i];
        double neutral = variable_get(v, model), towards = place % 2 ? v->min : v->max;
        if (place % 2 && !(v->min < neutral)) return false;
        variable_set(v, model, neutral + share * (towards - neutral));
    }
    return true;
}

bool hypothesis_parallel(const struct hypothesis *h, const char *base_variable) {
    static const struct {
        const char *effect, *base;
    } pairs[] = {
        {"cylinder_viscous_friction", "hydraulics.viscous_n_s_per_m"},
        {"payload_mass", "payload.mass_kg"},
        {"payload_rotational_inertia", "payload.inertia_xx_kg_m2"},
        {"payload_rotational_inertia", "payload.inertia_yy_kg_m2"},
        {"payload_rotational_inertia", "payload.inertia_zz_kg_m2"},
        {"actuator_inertia", "actuator.upper_mass_kg"},
        {"actuator_inertia", "actuator.lower_mass_kg"},
        {"valve_lag", "hydraulics.valve_damping"},
        {"command_delay", "hydraulics.valve_damping"},
        {"valve_flow_gain", "hydraulics.valve_flow_m3_per_s"},
        {"internal_leakage", "hydraulics.leakage_m3_per_s_pa"},
        {"entrained_air", "hydraulics.bulk_modulus_pa"},
        {"supply_pressure_sag", "hydraulics.supply_pa"},
    };
    const char *name = effect_table[h->effect]->name;
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++)
        if (!strcmp(pairs[i].effect, name) && !strcmp(pairs[i].base, base_variable)) return true;
    return false;
}

bool hypothesis_contains(int effect, int other) {
    return !strcmp(effect_table[effect]->name, "cylinder_stribeck_friction") && !strcmp(effect_table[other]->name, "cylinder_coulomb_friction");
}
