#include "statements.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment.h"
#include "goodness.h"
#include "memory.h"
#include "numeric.h"
#include "sets.h"

static const double NEGLIGIBLE = 0.01;  /* an effect that is less probable than this is not listed
                                         * beside sure ones */
static const double EMPIRICAL = 0.05;   /* least law_error of an empirical law. On six legs a law
                                         * with a smaller law_error is exact, and a large remainder
                                         * refutes it: a base on springs looks like springs on the
                                         * platform, but leaves a third of the gap */
static const double EXPLAINED = 0.5;    /* least share of the held-out gap that the effects of a
                                         * verdict explain together */
/* On six legs: largest share of the squared gap that an exact law may leave, and least share that
 * an effect beside others must explain. It is the square of the largest error of a law. */
static const double SLIGHT = SETS_LAW_MOST * SETS_LAW_MOST;
static const double FIRST_SPREAD = 0.1; /* size of the spread (covariance.h) before the model of a
                                         * set becomes the reference model */

static bool has_family(const struct set *s, int family) {
    for (int i = 0; i < s->effects; i++)
        if ((int)effect_table[s->hypothesis[i].effect]->family == family) return true;
    return false;
}

static const struct set *likeliest_with(const struct comparison *s, int effect) {
    for (int i = 0; i < s->sets; i++)
        if (sets_place(&s->set[i], effect) >= 0) return &s->set[i];
    return NULL;
}

/* Log evidence of the likeliest set that lacks an effect. The effect's z follows from it. */
static double without(const struct comparison *s, int effect) {
    for (int i = 0; i < s->sets; i++)
        if (sets_place(&s->set[i], effect) < 0) return s->set[i].evidence;
    return -HUGE_VAL;
}

/* Share of the held-out gap that a model explains, with whiteners that contain noise alone. */
static double share_of(const struct comparison *s, const struct params *base, const struct params *model) {
    struct diagnosis noise = {.held_out = s->held_out};
    double before = diagnosis_held_square(&noise, base), after = diagnosis_held_square(&noise, model);
    return fmin(fmax((before - after) / (before - s->held_out.evaluated), 0.0), 1.0);
}

/* One more than the number of the last key that a variable sets. */
static int end_of(const struct variable *v) { return v->key + (v->legs > LEGS ? 2 : 1); }

/* Fills in the values that an effect has in a set: means and standard deviations over the sizes of
 * the remainder. The standard deviations include the law error that these sizes allow. */
static void read_values(const struct comparison *s, const struct set *one, int place, struct gap_effect *e) {
    const struct hypothesis *h = &one->hypothesis[place];
    double change[FIT_VARIABLES] = {0}, std[FIT_VARIABLES] = {0}, mean[FIT_VARIABLES] = {0}, square_sum[FIT_VARIABLES] = {0}, law = 0.0,
           total = 0.0;
    int first = one->linear.variables;
    for (int i = one->effects - 1; i >= place; i--) first -= one->hypothesis[i].variables;
    for (int j = 0; j < s->sizes; j++) {
        double weight = exp(one->log_evidence[j] + one->log_prior + log(1.0 / s->sizes) - one->evidence);
        if (weight < 1e-4) continue;
        evidence_of(&one->linear, &s->covariance, &s->size[j], change, std);
        for (int i = 0; i < one->linear.variables; i++)
            mean[i] += weight * change[i], square_sum[i] += weight * (square(change[i]) + square(std[i]));
        law += weight * square(s->size[j].law), total += weight;
    }
    struct params moved = one->model;
    for (int i = 0; i < h->variables; i++) {
        const struct variable *v = &h->variable[i];
        double value = fmin(fmax(variable_get(v, &one->model) + mean[first + i] / total, v->min), v->max);
        double scatter = fmax(square_sum[first + i] / total - square(mean[first + i] / total), 0.0);
        double of_law = effect_table[h->effect]->keys[v->key].shapes_law ? 0.0 : law / total * square(value - v->neutral);
        variable_set(v, &moved, value);
        for (int key = v->key; key < end_of(v); key++)
            for (int leg = 0; leg < LEGS; leg++) {
                if (v->leg >= 0 && v->leg != leg) continue;
                e->bound[key][leg] = value <= v->min || value >= v->max;
                e->std[key][leg] = e->bound[key][leg] ? 0.0 : sqrt(scatter + of_law);
            }
    }
    e->values = moved.effects[h->effect];
}

/* Describes one effect of a set of effects: values, z, and the share that it explains by itself. */
static void state_in(const struct comparison *s, const struct params *base, const struct set *one, int place, struct gap_effect *e) {
    int keys = 0, effect = one->hypothesis[place].effect;
    *e = (struct gap_effect){.effect = effect, .pattern = one->hypothesis[place].pattern, .given = s->d->given->effects[effect]};
    for (int i = 0; i < one->hypothesis[place].variables; i++) {
        const struct variable *v = &one->hypothesis[place].variable[i];
        keys = end_of(v) > keys ? end_of(v) : keys;
    }
    e->keys = keys;
    e->z = sqrt(2.0 * fmax(one->evidence - without(s, effect), 0.0));
    read_values(s, one, place, e);
    const struct set *single = NULL;
    for (int i = s->sets - 1; i >= 0; i--)
        if (s->set[i].effects == 1 && sets_place(&s->set[i], effect) == 0) single = &s->set[i];
    struct params alone = single ? single->model : *base;
    if (!single) alone.effects[effect] = one->model.effects[effect];
    e->share_explained = share_of(s, base, &alone);
}

static void state_effect(const struct comparison *s, const struct params *base, int effect, struct gap_effect *e) {
    const struct set *one = likeliest_with(s, effect);
    state_in(s, base, one, sets_place(one, effect), e);
}

/* Lists statements about all effects, or about all families, each with its probability; the
 * likeliest first. Returns their number. */
static int list_statements(const struct comparison *s, bool families, struct gap_statement *list) {
    int n = 0, end = families ? EFFECT_FAMILIES : EFFECTS_MAX;
    for (int which = 0; which < end && (families || effect_table[which]); which++) {
        struct gap_statement one = {.family = families, .which = which};
        for (int i = 0; i < s->sets; i++)
            if (families ? has_family(&s->set[i], which) : sets_place(&s->set[i], which) >= 0) one.probability += s->set[i].probability;
        int place = n;
        if (!(one.probability > 0.0)) continue;
        for (; place > 0 && one.probability > list[place - 1].probability; place--) list[place] = list[place - 1];
        list[place] = one, n++;
    }
    return n;
}

/* Returns the likeliest effect of a family. effects: sorted, the likeliest first. */
static int member(const struct gap_statement *effects, int n, int family) {
    for (int i = 0; i < n; i++)
        if ((int)effect_table[effects[i].which]->family == family) return effects[i].which;
    return -1;
}

static void add_statement(const struct comparison *s, struct gap_result *r, struct gap_statement one, int effect) {
    state_effect(s, &r->base_model, effect, &one.effect);
    one.share_explained = one.effect.share_explained;
    r->statement[r->statements++] = one;
}

/* Fills the statements. The sure ones come first: each effect that is sure, and each family that
 * is sure without a sure effect. The likeliest other effects follow. Returns the number of sure
 * ones. */
static int state_all(const struct comparison *s, struct gap_result *r) {
    enum { LIKELIEST = 3 };
    struct gap_statement effect[EFFECTS_MAX], family[EFFECT_FAMILIES];
    int effects = list_statements(s, false, effect), families = list_statements(s, true, family), sure = 0;
    bool covered[EFFECT_FAMILIES] = {false};
    r->statements = 0;
    for (int i = 0; i < effects && effect[i].probability >= GAP_SURE && sure < GAP_EFFECTS; i++) {
        covered[effect_table[effect[i].which]->family] = true;
        add_statement(s, r, effect[i], effect[i].which), sure++;
    }
    for (int i = 0; i < families && family[i].probability >= GAP_SURE && sure < GAP_EFFECTS; i++) {
        if (covered[family[i].which]) continue;
        add_statement(s, r, family[i], member(effect, effects, family[i].which)), sure++;
    }
    for (int i = 0; i < effects && i < LIKELIEST && r->statements < GAP_STATEMENTS; i++)
        if (effect[i].probability < GAP_SURE && (!sure || effect[i].probability > NEGLIGIBLE))
            add_statement(s, r, effect[i], effect[i].which);
    return sure;
}

/* True if the machine surely has exactly one of two effects. */
static bool either(const struct comparison *s, int one, int other) {
    double sum = 0.0;
    for (int i = 0; i < s->sets; i++) {
        bool has = sets_place(&s->set[i], one) >= 0, has_other = sets_place(&s->set[i], other) >= 0;
        if (has != has_other) sum += s->set[i].probability;
    }
    return sum >= GAP_SURE;
}

/* True if a sure statement is about the effect's family. */
static bool in_sure_family(const struct gap_result *r, int sure, int effect) {
    for (int i = 0; i < sure; i++)
        if (r->statement[i].family && r->statement[i].which == (int)effect_table[effect]->family) return true;
    return false;
}

/* Looks for two effects of which the machine surely has exactly one, but either may be that one
 * (either()). The likelier effect becomes a sure statement, the other its rival. Returns the number
 * of sure statements. */
static int find_rivals(const struct comparison *s, struct gap_result *r, int sure) {
    for (int i = sure; i < r->statements; i++)
        for (int j = i + 1; j < r->statements && sure < GAP_EFFECTS; j++) {
            struct gap_statement first = r->statement[i];
            int other = r->statement[j].which;
            bool known = in_sure_family(r, sure, first.which) || in_sure_family(r, sure, other);
            if (known || !either(s, first.which, other)) continue;
            r->ambiguous = 1, r->ambiguous_with[0] = other, r->in_doubt = sure;
            memmove(r->statement + sure + 1, r->statement + sure, (size_t)(i - sure) * sizeof first);
            r->statement[sure] = first;
            return sure + 1;
        }
    return sure;
}

/* Makes a set of the effects of the sure statements, and fits it. Returns false if the set cannot
 * be fitted, or if the fit leaves any of its effects without strength. */
static bool fit_sure(struct comparison *s, const struct gap_result *r, int sure, struct set *one) {
    const struct set *from = likeliest_with(s, r->statement[0].effect.effect);
    *one = (struct set){.model = from->model};
    for (int i = 0; i < sure; i++) {
        int effect = r->statement[i].effect.effect;
        const struct set *with = sets_place(from, effect) >= 0 ? from : likeliest_with(s, effect);
        one->hypothesis[one->effects++] = with->hypothesis[sets_place(with, effect)];
        one->model.effects[effect] = with->model.effects[effect];
    }
    for (int i = 0; i < from->effects; i++) {
        int effect = from->hypothesis[i].effect;
        if (sets_place(one, effect) < 0) one->model.effects[effect] = s->d->given->effects[effect];
    }
    return sets_fit(s, one);
}

/* True if a model leaves more on held-out data than noise. */
static bool leaves(const struct comparison *s, const struct params *model) {
    struct diagnosis noise = {.held_out = s->held_out};
    return diagnosis_held_square(&noise, model) > LEFT_WHITE * s->held_out.evaluated;
}

/* True if an effect has an exact law, which a large remainder refutes. */
static bool is_exact(const struct gap_result *r, int effect) {
    return effect_table[effect]->law_error < EMPIRICAL && params_legs(&r->model) > 1;
}

bool statements_empirical(const struct gap_result *r) {
    bool exact = false;
    for (int i = 0; i < r->effects; i++) exact = exact || is_exact(r, r->effect[i].effect);
    return !exact;
}

/* Moves the errors of sensors and clocks behind the other sure statements. Returns the number of
 * these others. */
static int sensors_last(struct gap_result *r, int sure) {
    int kept = 0;
    for (int i = 0; i < sure; i++) {
        struct gap_statement one = r->statement[i];
        if (!sets_grows_with_machine(one.effect.effect)) continue;
        memmove(r->statement + kept + 1, r->statement + kept, (size_t)(i - kept) * sizeof one);
        r->statement[kept++] = one;
    }
    return kept;
}

static void put_last(struct gap_result *r, int place, int sure) {
    struct gap_statement one = r->statement[place];
    memmove(r->statement + place, r->statement + place + 1, (size_t)(sure - 1 - place) * sizeof one);
    r->statement[sure - 1] = one;
}

/* Moves slight sure statements to the end. A statement is slight if the others without it explain
 * nearly as much: the loss is no larger than an error of a law. The evidence for such a statement
 * is too great beside a remainder that is not random. Returns the number of statements that are not
 * slight. one: on entry the fit of all sure statements; afterwards that of the statements that are
 * not slight. */
static int slight_last(struct comparison *s, const struct params *base, struct gap_result *r, int sure, struct set *one) {
    struct set *rest = memory_get(1, sizeof *rest);
    int kept = sure;
    for (int i = sure - 1; i >= 0 && kept > 1; i--) {
        double whole = share_of(s, base, &one->model);
        struct gap_statement moved = r->statement[i];
        put_last(r, i, kept);
        if (fit_sure(s, r, kept - 1, rest) && whole - share_of(s, base, &rest->model) < SLIGHT) {
            linearised_free(&one->linear);
            *one = *rest, kept--;
            continue;
        }
        linearised_free(&rest->linear);
        memmove(r->statement + i + 1, r->statement + i, (size_t)(kept - 1 - i) * sizeof moved);
        r->statement[i] = moved;
    }
    free(rest);
    return kept;
}

/* Fits the sure statements. If a remainder is left and no effect is in doubt, some statements are
 * left out, but never all: on six legs the slight ones, with one leg the errors of sensors and
 * clocks. The laws of these errors are exact, so beside a remainder the errors stand for something
 * else, such as a damper's elastic mount. Returns the number of statements that were fitted; 0 if
 * the fit failed. */
static int fit_all(struct comparison *s, struct gap_result *r, int sure, struct set *one) {
    if (!fit_sure(s, r, sure, one)) return 0;
    if (r->ambiguous || !leaves(s, &one->model)) return sure;
    if (params_legs(s->d->given) > 1) {
        int left = slight_last(s, &r->base_model, r, sure, one);
        linearised_free(&one->linear);
        return fit_sure(s, r, left, one) ? left : 0;
    }
    int others = sensors_last(r, sure);
    if (!others || others == sure) return sure;
    linearised_free(&one->linear);
    return fit_sure(s, r, others, one) ? others : 0;
}

/* True if a set has an effect, or another effect of which it is a limiting case. The search has
 * decided between the two: it prefers the limiting case if that explains about as much. */
static bool has_or_contains(const struct set *one, int effect) {
    bool has = false;
    for (int i = 0; i < one->effects; i++)
        has = has || one->hypothesis[i].effect == effect || hypothesis_contains(one->hypothesis[i].effect, effect);
    return has;
}

/* Number of doubtful effects in a set. Doubtful are the result's effect in doubt and those that the
 * data cannot tell from it. */
static int doubted_in(const struct set *one, const struct gap_result *r) {
    int count = has_or_contains(one, r->effect[r->in_doubt].effect);
    for (int i = 0; i < r->ambiguous; i++) count += has_or_contains(one, r->ambiguous_with[i]);
    return count;
}

/* True if a set confirms a result. It must have all effects of the result; for a statement about a
 * family, an effect of that family; and exactly one of the effects that the result cannot tell
 * apart. It may have further effects, unless the result has none. Clock skew is not looked for,
 * because it is measured and in no set. */
static bool confirms(const struct set *one, const struct gap_result *r) {
    bool all = r->effects || !one->effects;
    for (int i = 0; i < r->effects; i++) {
        int effect = r->effect[i].effect;
        bool family = i < r->statements && r->statement[i].family, doubted = r->ambiguous && i == r->in_doubt;
        bool has = family ? has_family(one, r->statement[i].which) : doubted ? doubted_in(one, r) == 1 : has_or_contains(one, effect);
        all = all && (has || effect == effect_find("clock_skew"));
    }
    return all;
}

/* Finds the probability of a result, and the likeliest set that contradicts it. The sets are
 * sorted. */
static struct gap_certainty certainty_of(const struct comparison *s, const struct gap_result *r) {
    struct gap_certainty c = {0};
    for (int i = s->sets - 1; i >= 0; i--) {
        const struct set *one = &s->set[i];
        if (confirms(one, r)) {
            c.probability += one->probability;
            continue;
        }
        c.other_probability = one->probability;
        c.others = one->effects;
        for (int j = 0; j < one->effects; j++) c.other[j] = one->hypothesis[j].effect;
    }
    if (c.probability > 1.0) c.probability = 1.0; /* rounding can raise the sum above 1 */
    return c;
}

/* Makes the sure statements the findings. Returns false if there are none, or if together they do
 * not explain enough of the gap. */
static bool settle(struct comparison *s, struct gap_result *r, int sure) {
    struct set *one = memory_get(1, sizeof *one);
    r->ambiguous = 0, r->in_doubt = 0, r->ambiguous_together = false;
    sure = find_rivals(s, r, sure);
    sure = sure ? fit_all(s, r, sure, one) : 0;
    bool exact = false;
    for (int i = 0; i < sure; i++) exact = exact || is_exact(r, r->statement[i].effect.effect);
    bool settled = sure && share_of(s, &r->base_model, &s->d->model) > (exact ? 1.0 - SLIGHT : EXPLAINED);
    r->effects = 0;
    for (int i = 0; i < sure && settled; i++) {
        struct gap_effect *e = &r->effect[r->effects++];
        read_values(s, one, i, &r->statement[i].effect);
        *e = r->statement[i].effect;
        snprintf(e->evidence, sizeof e->evidence, "%s; probability %.2f", gap_signature(e->effect, params_legs(s->d->given)),
                 r->statement[i].probability);
    }
    r->certainty = certainty_of(s, r);
    linearised_free(&one->linear);
    free(one);
    return settled;
}

bool statements_find(struct diagnosis *d, struct gap_result *r) {
    struct comparison *s = memory_get(1, sizeof *s);
    sets_begin(s, d, FIRST_SPREAD, false);
    sets_search(s, &r->base_model);
    bool settled = sets_rank(s) && settle(s, r, state_all(s, r));
    sets_end(s);
    free(s);
    return settled && diagnosis_assume(d, d->added, d->addition, &d->model);
}

/* Copies a set without one of its effects. */
static struct set without_one(const struct diagnosis *d, const struct set *whole, int place) {
    struct set one = {.model = whole->model};
    for (int i = 0; i < whole->effects; i++)
        if (i != place) one.hypothesis[one.effects++] = whole->hypothesis[i];
    one.model.effects[whole->hypothesis[place].effect] = d->given->effects[whole->hypothesis[place].effect];
    return one;
}

/* Keeps the sets in which limiting cases replace one or more effects of `one`, from the effect at
 * `place` on. list: all hypotheses. */
static void keep_limits(struct comparison *s, const struct set *one, int place, int hypotheses, const struct hypothesis *list) {
    for (int i = place; i < one->effects; i++)
        for (int j = 0; j < hypotheses; j++) {
            const struct hypothesis *h = &one->hypothesis[i], *limit = &list[j];
            if (!hypothesis_contains(h->effect, limit->effect) || limit->pattern != h->pattern || sets_place(one, limit->effect) >= 0)
                continue;
            struct set *simpler = memory_get(1, sizeof *simpler);
            *simpler = *one;
            simpler->model.effects[h->effect] = s->d->given->effects[h->effect];
            simpler->hypothesis[i] = *limit;
            hypothesis_at(limit, 1.0, &simpler->model);
            keep_limits(s, simpler, i + 1, hypotheses, list);
            sets_keep(s, simpler);
            free(simpler);
        }
}

/* True if a hypothesis is an effect of the bodies (EFFECT_BODIES) that looks like the given effect,
 * which is of another family. */
static bool body_like(const struct hypothesis *h, int effect) {
    bool body = h->pattern == PATTERN_ALL && effect_table[h->effect]->family == EFFECT_BODIES;
    return body && effect_table[effect]->family != EFFECT_BODIES && experiment_is_known(effect_table[h->effect], effect_table[effect]);
}

/* Keeps the sets in which two effects of the bodies (EFFECT_BODIES) replace the effect at `place`
 * of a found set. Each of the two looks like this effect, but not like the other one of the two.
 * For example, a payload of another mass also has other inertias, and together they look like
 * springs. The prior counts the two as one effect. */
static void keep_bodies(struct comparison *s, const struct set *found, int place, int hypotheses, const struct hypothesis *list) {
    int effect = found->hypothesis[place].effect;
    struct set *one = memory_get(1, sizeof *one);
    for (int i = 0; i < hypotheses && found->effects < GAP_EFFECTS; i++)
        for (int j = i + 1; j < hypotheses; j++) {
            const struct effect *a = effect_table[list[i].effect], *b = effect_table[list[j].effect];
            bool two = body_like(&list[i], effect) && body_like(&list[j], effect) && a != b && !experiment_is_known(a, b);
            if (!two || sets_place(found, list[i].effect) >= 0 || sets_place(found, list[j].effect) >= 0) continue;
            *one = without_one(s->d, found, place);
            one->causes = found->effects;
            one->hypothesis[one->effects++] = list[i], one->hypothesis[one->effects++] = list[j];
            hypothesis_at(&list[i], 1.0, &one->model), hypothesis_at(&list[j], 1.0, &one->model);
            sets_keep(s, one);
        }
    free(one);
}

/* Finds the counterpart in `other` of the effect at `place` of `one`. It is the same effect, or
 * else an effect that contains this one as a limiting case, is not in `one` and is not taken yet.
 * Returns its place in `other`; -1 if there is none with the same legs. */
static int counterpart(const struct set *one, int place, const struct set *other, const bool taken[GAP_EFFECTS]) {
    const struct hypothesis *h = &one->hypothesis[place];
    int found = sets_place(other, h->effect);
    for (int j = 0; j < other->effects && found < 0; j++) {
        const struct hypothesis *of = &other->hypothesis[j];
        bool free = !taken[j] && of->pattern == h->pattern && sets_place(one, of->effect) < 0;
        if (free && hypothesis_contains(of->effect, h->effect)) found = j;
    }
    return found >= 0 && other->hypothesis[found].pattern == h->pattern ? found : -1;
}

/* True if a set has effects, and each of them is an effect of the other set, or a limiting case in
 * the place of one. */
static bool simplifies(const struct set *one, const struct set *other) {
    bool taken[GAP_EFFECTS] = {false};
    for (int i = 0; i < one->effects; i++) {
        int place = counterpart(one, i, other, taken);
        if (place < 0) return false;
        taken[place] = true;
    }
    return one->effects > 0;
}

/* Finds the likeliest set that simplifies() accepts: it has the effects of `found`, limiting cases
 * in place of some, or fewer of them. Returns NULL if there is none. The sets are sorted. */
static const struct set *likeliest_of(const struct comparison *s, const struct set *found) {
    for (int i = 0; i < s->sets; i++)
        if (simplifies(&s->set[i], found)) return &s->set[i];
    return NULL;
}

/* Makes the effects of a set the findings. Clock skew, which is in no set, stays among them. */
static void take(const struct comparison *s, const struct set *one, struct gap_result *r) {
    int effects = 0;
    for (int i = 0; i < r->effects; i++)
        if (r->effect[i].effect == effect_find("clock_skew")) r->effect[effects++] = r->effect[i];
    for (int i = 0; i < one->effects; i++) {
        struct gap_effect *e = &r->effect[effects++];
        state_in(s, &r->base_model, one, i, e);
        snprintf(e->evidence, sizeof e->evidence, "%s", gap_signature(e->effect, params_legs(s->d->given)));
    }
    r->effects = effects;
    r->ambiguous = r->in_doubt = 0, r->ambiguous_together = false;
    gap_sort_effects(r);
}

/* Keeps the sets that statements_weigh() compares. */
static void keep_all(struct comparison *s, const struct params *base, const struct set *found, int sets, const struct set *tried) {
    struct set *one = memory_get(1, sizeof *one);
    struct hypothesis *list = memory_get(HYPOTHESES_MAX, sizeof *list);
    int hypotheses = hypotheses_list(s->d->given, base, (const bool[EFFECTS_MAX]){0}, s->d->even.equations, list);
    *one = (struct set){.model = *base}, sets_keep(s, one);
    for (int without = -1; without < found->effects; without++) {
        *one = without < 0 ? *found : without_one(s->d, found, without);
        sets_keep(s, one);
        keep_limits(s, one, 0, hypotheses, list);
    }
    for (int i = 0; i < found->effects; i++) keep_bodies(s, found, i, hypotheses, list);
    for (int i = 0; i < sets; i++) *one = tried[i], sets_keep(s, one);
    free(list);
    free(one);
}

bool statements_weigh(struct diagnosis *d, struct gap_result *r, struct set *found, int sets, const struct set *tried,
                      struct gap_certainty *certainty) {
    *certainty = (struct gap_certainty){.probability = (double)NAN};
    if (!diagnosis_assume(d, found->effects, found->hypothesis, &found->model)) return false;
    struct comparison *s = memory_get(1, sizeof *s);
    sets_begin(s, d, 0.0, d->held_square < LEFT_WHITE * d->held_out.evaluated);
    keep_all(s, &r->base_model, found, sets, tried);
    bool ranked = sets_rank(s);
    const struct set *one = ranked ? likeliest_of(s, found) : NULL;
    bool simpler = one && !sets_same(one, found);
    if (simpler) take(s, one, r);
    if (one || (ranked && !found->effects)) *certainty = certainty_of(s, r);
    if (one) *found = *one;
    sets_end(s);
    free(s);
    return simpler && diagnosis_assume(d, found->effects, found->hypothesis, &found->model);
}
