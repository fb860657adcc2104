#include "hypothesis.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "machine.h"
#include "params.h"

static const double LEFT = 0.1; /* least share of a mass, an inertia or a friction that an effect
                                 * must leave */

#define DIFFER(member) (memcmp(&a->member, &b->member, sizeof a->member) != 0)

/* True if the effect changes the forces that a motion needs. A mechanism without a pose, a single
 * axis, has mass, weight and friction only. */
static bool moves_force(const struct params *model, const struct effect *e, const struct machine *a, const struct machine *b) {
    if (e->leg_friction || e->wrench) return true;
    return params_mechanism(model)->pose ? e->joint_friction || DIFFER(bodies) : DIFFER(bodies.payload_kg) || DIFFER(bodies.gravity_mps2);
}

static bool moves_pressure(const struct effect *e, const struct machine *a, const struct machine *b) {
    return e->opening || e->command || DIFFER(supply) || DIFFER(oil) || DIFFER(valve) || DIFFER(hose) || DIFFER(timing.command_delay_s);
}

/* Reach of an effect: the residuals that it changes, through the constants that it changes and
 * through its laws. */
struct reach {
    enum residual_equations equations;
    bool own; /* a leg's value affects only that leg's residuals, because neither bodies nor pose
               * depend on it */
};

static struct reach effect_reach(const struct params *model, int effect) {
    const struct effect *e = effect_table[effect];
    struct params with = *model, without = *model;
    struct machine base, machine;
    const struct machine *a = &base, *b = &machine;
    enum residual_equations equations = 0;
    without.effects[effect].on = false;
    effect_at(e, 1.0, &with.effects[effect]);
    machine_init(&base, &without);
    machine_init(&machine, &with);
    if (moves_force(model, e, a, b)) equations |= EQUATIONS_FORCE;
    if (moves_pressure(e, a, b)) equations |= EQUATIONS_PRESSURE;
    if (DIFFER(hose) || DIFFER(sensors.length) || DIFFER(sensors.p1) || DIFFER(sensors.p2)) equations |= EQUATIONS_ALL;
    if (DIFFER(sensors.force)) equations |= EQUATIONS_FORCE_SENSOR;
    return (struct reach){equations, !(e->joint_friction || e->wrench || DIFFER(bodies) || DIFFER(sensors.length))};
}

/* Step of a difference quotient: well above rounding, well below the curvature of any law. */
static double difference_step(const struct effect_key *k) {
    double typical = k->reciprocal ? 0.0 : fabs(k->typical - k->neutral);
    return 0.02 * (typical > 0.0 ? typical : fabs(k->typical));
}

/* Returns 1 / standard deviation of a value's prior; 0: no prior. The standard deviation is three
 * times the value's typical size, or the largest deviation in the configuration if that is larger.
 * For an effect of this size the prior decides nothing; it rejects absurd values, such as a joint
 * 80 mm from its place. A reciprocal key (effect.h) has no prior, because its neutral value stands
 * for infinity. */
static double prior_inverse_std(const struct effect_key *k, const struct effect_values *given, int key) {
    double deviation = 3.0 * fabs(k->typical - k->neutral);
    for (int leg = 0; leg < LEGS && given->on; leg++) deviation = fmax(deviation, fabs(given->value[key][leg] - k->neutral));
    return k->reciprocal || k->typical == k->neutral ? 0.0 : 1.0 / deviation;
}

bool hypothesis_possible(const struct params *model) {
    struct machine machine;
    struct error impossible;
    machine_init(&machine, model);
    return machine_check(&machine, &impossible) == 0;
}

static bool possible(const struct params *given, const struct variable *v, double value) {
    struct params with = *given;
    variable_set(v, &with, value);
    return hypothesis_possible(&with);
}

/* Returns the end of a variable's range. This is `end`, unless the given machine is impossible with
 * that value. In this case it is nine tenths of the way from the neutral value to the farthest
 * possible one. */
static double possible_end(const struct params *given, const struct variable *v, double end) {
    double most = 0.0, step = 0.5;
    if (possible(given, v, end)) return end;
    for (; step > 1e-6; step *= 0.5)
        if (possible(given, v, v->neutral + (most + step) * (end - v->neutral))) most += step;
    return v->neutral + (1.0 - LEFT) * most * (end - v->neutral);
}

static void add_variable(const struct params *given, struct hypothesis *h, int key, int leg, struct reach reach) {
    const struct effect *e = effect_table[h->effect];
    const struct effect_key *k = &e->keys[key];
    struct variable *v = &h->variable[h->variables++];
    *v = (struct variable){
        .name = k->name,
        .offset = offsetof(struct params, effects) + (size_t)h->effect * sizeof(struct effect_values) +
                  offsetof(struct effect_values, value) + (size_t)key * LEGS * sizeof(double),
        .leg = leg,
        .legs = LEGS,
        .own = leg >= 0 && reach.own,
        .effect = h->effect,
        .key = key,
        .neutral = k->neutral,
        .prior_inverse_std = prior_inverse_std(k, &given->effects[h->effect], key),
        .step = difference_step(k),
        .equations = reach.equations,
    };
    v->min = possible_end(given, v, k->min);
    v->max = possible_end(given, v, k->max);
}

/* Builds a hypothesis with all its variables. An effect that acts on the pose has a key for each
 * axis, unless it acts on machines of one axis only. */
static void build(const struct params *given, struct hypothesis *h, int effect, int pattern, struct reach reach) {
    *h = (struct hypothesis){.effect = effect, .pattern = pattern};
    const struct effect_key *keys = effect_table[effect]->keys;
    bool by_axis = effect_table[effect]->wrench && !effect_table[effect]->one_axis;
    int most = by_axis ? params_mechanism(given)->axes : EFFECT_KEYS;
    for (int key = 0; key < most && keys[key].name; key++)
        for (int leg = 0; leg < (pattern == PATTERN_EACH ? LEGS : 1); leg++)
            add_variable(given, h, key, pattern == PATTERN_EACH && keys[key].per_leg ? leg : pattern == PATTERN_EACH ? -1 : pattern, reach);
}

enum residual_equations hypothesis_equations(const struct hypothesis *h) {
    enum residual_equations equations = 0;
    for (int i = 0; i < h->variables; i++) equations |= h->variable[i].equations;
    return equations;
}

int hypotheses_list(const struct params *given, const struct params *model, const bool found[EFFECTS_MAX],
                    enum residual_equations evaluated, struct hypothesis h[HYPOTHESES_MAX]) {
    int n = 0;
    for (int effect = 0; effect_table[effect]; effect++) {
        if (found[effect] || (effect_table[effect]->one_axis && params_mechanism(given)->axes > 1)) continue;
        struct reach reach = effect_reach(model, effect);
        reach.equations &= evaluated;
        if (reach.equations & EQUATIONS_FORCE_SENSOR) reach.equations = EQUATIONS_FORCE;
        if (!reach.equations)
            continue; /* the evaluated residuals do not show the effect; clock skew is found by
                       * recording_clock() */
        build(given, &h[n++], effect, PATTERN_ALL, reach);
        if (params_legs(model) == 1) continue;
        bool per_leg = false;
        const struct effect_key *keys = effect_table[effect]->keys;
        for (int key = 0; key < EFFECT_KEYS && keys[key].name; key++) per_leg = per_leg || keys[key].per_leg;
        for (int leg = 0; leg < LEGS && per_leg; leg++) build(given, &h[n++], effect, leg, reach);
        if (per_leg) build(given, &h[n++], effect, PATTERN_EACH, reach);
    }
    return n;
}

bool hypothesis_at(const struct hypothesis *h, double strength, struct params *model) {
    const struct effect_key *keys = effect_table[h->effect]->keys;
    struct effect_values values;
    bool base_has_some = model->effects[h->effect].on;
    if (!base_has_some) effect_at(effect_table[h->effect], 0.0, &model->effects[h->effect]);
    effect_at(effect_table[h->effect], strength, &values);
    bool moved = false;
    for (int i = 0; i < h->variables; i++) {
        const struct variable *v = &h->variable[i];
        double value = fmin(fmax(values.value[v->key][0], v->min), v->max);
        moved = moved || value != keys[v->key].neutral;
        variable_set(v, model, value);
    }
    return moved;
}

void variable_add_prior(struct variable *base) {
    if (base->penalised) return;
    base->neutral = 0.5 * (base->min + base->max);
    base->prior_inverse_std = sqrt(12.0) / (base->max - base->min);
}

static bool alike(const struct hypothesis *h, const struct variable *base) {
    const char *const *parallel = effect_table[h->effect]->parallel_to;
    for (int i = 0; i < EFFECT_TIES && parallel[i]; i++)
        if (!strcmp(parallel[i], base->name)) return true;
    return base->effect == h->effect;
}

bool hypothesis_make_symmetric(struct hypothesis *h) {
    const struct effect *e = effect_table[h->effect];
    const struct effect_key *first = &e->keys[0], *second = &e->keys[1];
    bool pair = e->leg_friction && second->name && !strcmp(first->unit, second->unit) && first->typical == second->typical;
    if (!pair || h->pattern != PATTERN_ALL || h->variables < 2) return false;
    /* in struct effect_values the values of key 1 follow those of key 0, so one list can contain
     * both */
    h->variable[0].legs = 2 * LEGS;
    memmove(h->variable + 1, h->variable + 2, (size_t)(--h->variables - 1) * sizeof *h->variable);
    h->symmetric = true;
    return true;
}

bool hypothesis_is_dry(const struct hypothesis *h) { return !strcmp(effect_table[h->effect]->keys[0].unit, "N"); }

enum parallel hypothesis_parallel(const struct hypothesis *h, const struct variable *base) {
    if (!alike(h, base) || (h->symmetric && !strcmp(base->name, "axis.force_offset_n"))) return PARALLEL_NOT;
    /* the data can tell a base variable that is common to all legs from an effect in one leg */
    if (base->leg < 0) return h->pattern < 0 ? PARALLEL_SAME : PARALLEL_NOT;
    if (h->pattern >= 0 && h->pattern != base->leg) return PARALLEL_NOT;
    /* the base has a variable for each leg, but the effect has one value for all legs */
    bool beside = h->pattern == PATTERN_ALL && base->legs > 1 && base->effect != h->effect;
    return beside ? PARALLEL_DRAWN : PARALLEL_SAME;
}

bool hypothesis_contains(int effect, int other) {
    const struct effect *const *contains = effect_table[effect]->contains;
    for (int i = 0; i < EFFECT_TIES && contains[i]; i++)
        if (contains[i] == effect_table[other]) return true;
    return false;
}
