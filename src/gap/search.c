#include "search.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base.h"
#include "gap.h"
#include "goodness.h"
#include "inverse_dynamics.h"
#include "machine.h"
#include "memory.h"
#include "trials.h"

/* On a machine without hidden effects the best of some forty effects gains 5 to 10 on held-out
 * cycles by chance (make bench-gap). */
static const double GAIN_MIN = 28.0;       /* least evidence for an effect, in squared white
                                            * residuals on fitted and held-out cycles together,
                                            * after the parameters' penalty: odds of 5000 to one
                                            * after the choice among some 250 hypotheses; z = 6 for
                                            * one parameter */
static const double UNCLEAR_GAIN = 144.0;  /* least evidence for a further effect that has rivals,
                                            * because an error of the laws may imitate any of them;
                                            * z = 12 */
static const double REMAINDER_SHARE = 0.2; /* share of the held-out excess over noise that an effect
                                            * must explain */
static const double RIVAL_GAIN = 16.0;     /* a candidate whose evidence is further behind that of
                                            * the best one is no rival: odds of 3000 to one, z = 4;
                                            * the possible error of the best one's law takes its
                                            * place if larger */

static const double NEAR_GAIN = 60.0;      /* a candidate whose evidence is further behind that of
                                            * the best one is not compared with the verdict: odds of
                                            * 1e13 to one; four times the possible error of the best
                                            * one's law take its place if larger */
enum { NEAR = 4 };                         /* most candidates of a round that are compared */

/* Most rounds of the search. Half of them suffice for four effects, if each is added once and
 * judged again beside those added later, and none is replaced. */
enum { ROUNDS_MAX = GAP_EFFECTS * (GAP_EFFECTS + 1) };

static double excess(double square, int values) { return fmax(square - values, 0.0); }

/* z of a trial: square root of its gain in squared white residuals on all cycles, less the penalty
 * of its priors. */
static double likelihood(const struct diagnosis *d, const struct trial *t) { return sqrt(fmax(d->square - t->square + t->held_gain, 0.0)); }

/* Possible error of a trial's evidence, because its effect's law is not exact, in squared white
 * residuals over all cycles. */
static double law_error(const struct trial *t) { return pow(effect_table[t->hypothesis->effect]->law_error, 2.0) * trial_evidence(t); }

/* Mean squared white residual with a trial, at least 1; noise gives about 1. A remaining gap makes
 * all evidence less certain. */
static double dispersion(const struct diagnosis *d, const struct trial *t) {
    return fmax((t->square + t->held_square) / (d->fit.evaluated + d->held_out.evaluated), 1.0);
}

/* Possible error of the best candidate's evidence, by noise or because its effect's law is not
 * exact. */
static double margin(const struct diagnosis *d, const struct trial *best) {
    return fmax(RIVAL_GAIN * dispersion(d, best), law_error(best));
}

/* True if a trial's evidence is within the margin of the best one's. */
static bool is_rival(const struct diagnosis *d, const struct trial *best, const struct trial *t) {
    return t->ok && t->polished && trial_ahead(best, t) <= margin(d, best);
}

/* True if a trial with a value for each leg gains less on held-out cycles than a best trial with
 * fewer values. Such a trial is no rival, because more values always fit a little better. */
static bool overfits(const struct trial *t, const struct trial *best) {
    return t->hypothesis->pattern == PATTERN_EACH && best->hypothesis->pattern != PATTERN_EACH && t->held_gain < best->held_gain;
}

static double dry_friction(const struct params *model, double speed_mps) {
    struct cylinder_model m;
    struct cylinder_state s = {.p1_pa = 0.5 * model->hydraulics.supply_pa, .p2_pa = 0.5 * model->hydraulics.supply_pa};
    double sum = 0.0;
    cylinder_model_init(&m, model);
    for (int k = 0; k < params_legs(model); k++) sum += cylinder_friction(&m, k, &s, 1, speed_mps).dry;
    return sum;
}

/* True if an effect of this model is a friction that mostly disappears where a leg surely slides.
 * The data do not show such a friction: where a leg may stick, its friction takes up any error of
 * the force balance, such as a force sensor's. rest: the model without the effect. */
static bool held_only(int effect, const struct params *model, const struct params *rest) {
    double sliding_mps = 2.0 * INVERSE_DYNAMICS_SLOW_MPS;
    if (!effect_table[effect]->leg_friction) return false;
    double held = dry_friction(model, 0.0) - dry_friction(rest, 0.0);
    double slides = dry_friction(model, sliding_mps) - dry_friction(rest, sliding_mps);
    return fabs(slides) < 0.5 * fabs(held);
}

static bool trial_held_only(const struct diagnosis *d, const struct trial *t) {
    return held_only(t->hypothesis->effect, &t->model, &d->model);
}

static bool unseen(const struct diagnosis *d, const struct trial *t) { return t->bound || trial_held_only(d, t); }

/* Lists every effect once, with its best choice of legs. The trials are sorted. */
static void list_candidates(const struct diagnosis *d, const struct trial *trial, int trials, struct gap_result *r) {
    double least = d->held_out.evaluated; /* sum of squares that counts as a full explanation: that
                                           * of noise, or that of a trial if it is smaller */
    for (int i = 0; i < trials; i++)
        if (trial[i].ok && trial[i].polished) least = fmin(least, trial[i].held_square);
    double before = d->held_square - least;
    bool gap = before > TRIAL_LEAST;
    for (int i = 0; i < trials; i++) {
        bool seen = !trial[i].ok;
        for (int j = 0; j < r->candidates && !seen; j++) seen = r->candidate[j].effect == trial[i].hypothesis->effect;
        if (seen || r->candidates == EFFECTS_MAX) continue;
        double share = gap ? 1.0 - (trial[i].held_square - least) / before : 0.0;
        r->candidate[r->candidates++] = (struct gap_candidate){.effect = trial[i].hypothesis->effect,
                                                               .pattern = trial[i].hypothesis->pattern,
                                                               .gain = trial[i].gain,
                                                               .z = likelihood(d, &trial[i]),
                                                               .share_explained = share,
                                                               .unseen = unseen(d, &trial[i])};
    }
}

/* Removes rivals of which another rival is a limiting case. Returns the number left. */
static int drop_containing(int rivals, int rival[GAP_RIVALS]) {
    int left = 0;
    bool drop[GAP_RIVALS] = {false};
    for (int i = 0; i < rivals; i++)
        for (int j = 0; j < rivals; j++) drop[i] = drop[i] || hypothesis_contains(rival[i], rival[j]);
    for (int i = 0; i < rivals; i++)
        if (!drop[i]) rival[left++] = rival[i];
    return left;
}

static int list_rivals(const struct diagnosis *d, const struct trial *trial, int trials, int rival[GAP_RIVALS]) {
    int rivals = 0, best = trial[0].hypothesis->effect;
    for (int i = 1; i < trials; i++) {
        if (!is_rival(d, &trial[0], &trial[i]) || trial_held_only(d, &trial[i])) continue;
        int effect = trial[i].hypothesis->effect;
        bool seen = effect == best || hypothesis_contains(effect, best) || overfits(&trial[i], &trial[0]);
        for (int j = 0; j < rivals; j++) seen = seen || rival[j] == effect;
        if (!seen && rivals < GAP_RIVALS) rival[rivals++] = effect;
    }
    return drop_containing(rivals, rival);
}

/* Notes the added effects and the effect of a trial as one of the sets with which the verdict is
 * compared. */
static void note_tried(const struct diagnosis *d, const struct trial *t, struct tried *tried) {
    struct set *one = &tried->set[tried->sets];
    if (tried->sets == TRIED_MAX) return;
    *one = (struct set){.effects = d->added, .model = t->model};
    memcpy(one->hypothesis, d->addition, (size_t)d->added * sizeof *one->hypothesis);
    one->hypothesis[one->effects++] = *t->hypothesis;
    bool known = false;
    for (int i = 0; i < tried->sets; i++) known = known || sets_same(&tried->set[i], one);
    tried->sets += !known;
}

static bool effect_before(const struct trial *trial, int place) {
    bool before = false;
    for (int i = 0; i < place; i++) before = before || trial[i].hypothesis->effect == trial[place].hypothesis->effect;
    return before;
}

/* Notes the best trial of each effect whose evidence is near that of the best one. */
static void note_rivals(const struct diagnosis *d, const struct trial *trial, int trials, struct tried *tried) {
    double most = fmax(NEAR_GAIN * dispersion(d, &trial[0]), 4.0 * law_error(&trial[0]));
    for (int i = 0, noted = 0; i < trials && noted < NEAR; i++) {
        if (!trial[i].ok || !trial[i].polished || unseen(d, &trial[i]) || effect_before(trial, i)) continue;
        if (trial_evidence(&trial[0]) - trial_evidence(&trial[i]) > most) continue;
        note_tried(d, &trial[i], tried), noted++;
    }
}

static void put_first(struct trial *trial, int place) {
    struct trial first = trial[place];
    memmove(trial + 1, trial, (size_t)place * sizeof *trial);
    trial[0] = first;
}

/* True if a trial is a special case of the best one and explains about as much. A special case is a
 * limiting case of the best trial's effect, or the same effect with one value for all legs, or in
 * one leg, in place of a value for each leg. A value for each leg is preferred to that only if it
 * gains as much as an added effect must. */
static bool as_good(const struct diagnosis *d, const struct trial *best, const struct trial *t) {
    const struct hypothesis *h = t->hypothesis, *than = best->hypothesis;
    if (t->bound || !t->ok || !t->polished) return false;
    double behind = trial_evidence(best) - trial_evidence(t);
    if (h->effect != than->effect) return hypothesis_contains(than->effect, h->effect) && behind <= margin(d, best);
    double needed = fmax(GAIN_MIN * dispersion(d, best), law_error(best));
    return h->pattern != PATTERN_EACH && than->pattern == PATTERN_EACH && behind <= needed;
}

/* Moves a special case of the best candidate to the front if it explains as much. */
static void prefer_simple(const struct diagnosis *d, struct trial *trial, int trials) {
    for (int i = 1; i < trials; i++)
        if (as_good(d, &trial[0], &trial[i])) {
            put_first(trial, i);
            return;
        }
}

/* Moves the best polished candidate that the data show to the front; the others keep their
 * order. */
static void prefer_seen(const struct diagnosis *d, struct trial *trial, int trials) {
    for (int i = 0; i < trials && trial[i].ok && trial[i].polished; i++) {
        if (unseen(d, &trial[i])) continue;
        put_first(trial, i);
        return;
    }
}

static bool worth_adding(const struct diagnosis *d, const struct trial *t, double laws) {
    double left = excess(d->held_square, d->held_out.evaluated);
    double least = dispersion(d, t), fitted = trial_fitted_gain(t);
    bool pays = fitted > TRIAL_LEAST * least && t->held_gain > TRIAL_LEAST * least && trial_evidence(t) > GAIN_MIN * least;
    return t->ok && t->polished && !unseen(d, t) && pays && t->held_gain > laws && t->held_gain > REMAINDER_SHARE * left;
}

/* Index of the best trial that has the first trial's effect without a value for each leg; 0: there
 * is none. */
static int simple_pattern(const struct diagnosis *d, const struct trial *trial, int trials) {
    int best = 0;
    for (int i = 1; i < trials; i++) {
        const struct hypothesis *h = trial[i].hypothesis;
        if (!trial[i].ok || h->effect != trial[0].hypothesis->effect || h->pattern == PATTERN_EACH || unseen(d, &trial[i])) continue;
        if (!best || trial_evidence(&trial[i]) > trial_evidence(&trial[best])) best = i;
    }
    return best;
}

static double penalty(const struct trial *t) { return trial_rise(t) - t->gain; }

/* True if the effect with this simpler choice of legs, together with the next effect, explains more
 * than the best trial, whose values for each leg may have absorbed another effect. Refits the
 * model, and leaves it with the effects that it had. */
static bool is_two(struct diagnosis *d, const struct trial *trial, int simple) {
    struct trial *next = memory_get(HYPOTHESES_MAX, sizeof *next);
    /* computed before the refit, which lists anew the hypotheses that the trials point to */
    double needed = trial_evidence(&trial[0]);
    double evidence = d->square + d->held_square - penalty(&trial[simple]);
    bool two = false;
    if (diagnosis_add(d, trial[simple].hypothesis, &trial[simple].model)) {
        int trials = trials_run(d, next);
        prefer_seen(d, next, trials);
        prefer_simple(d, next, trials);
        if (trials && worth_adding(d, &next[0], goodness_law_error(d))) {
            evidence -= penalty(&next[0]);
            if (diagnosis_add(d, next[0].hypothesis, &next[0].model)) {
                two = evidence - d->square - d->held_square > needed;
                diagnosis_drop(d, d->added - 1, HUGE_VAL);
            }
        }
        diagnosis_drop(d, d->added - 1, HUGE_VAL);
    }
    free(next);
    return two;
}

/* Checks whether the best effect, which has a value for each leg, explains less than the same
 * effect with one value, or in one leg, together with the next effect. If so, moves the trial with
 * the simpler choice of legs to the front and returns true. */
static bool prefer_two_effects(struct diagnosis *d, const struct gap_result *r, struct trial *trial, int trials) {
    bool room = trial[0].hypothesis->pattern == PATTERN_EACH && r->effects + 2 <= GAP_EFFECTS;
    int simple = room ? simple_pattern(d, trial, trials) : 0;
    if (!simple || !is_two(d, trial, simple)) return false;
    put_first(trial, simple);
    return true;
}

static bool drop(struct diagnosis *d, int addition, double most, struct gap_result *r) {
    int effect = d->addition[addition].effect, place = 0;
    if (!diagnosis_drop(d, addition, most)) return false;
    while (r->effect[place].effect != effect) place++;
    memmove(r->effect + place, r->effect + place + 1, (size_t)(--r->effects - place) * sizeof *r->effect);
    return true;
}

static void drop_superfluous(struct diagnosis *d, struct gap_result *r) {
    for (int i = 0; i < d->added - 1;)
        if (!drop(d, i, 0.5 * GAIN_MIN, r)) i++;
}

/* Removes the effect that was added last if, fitted beside the others, it is a friction that the
 * data do not show. */
static bool drop_unseen(struct diagnosis *d, struct gap_result *r) {
    int last = d->added - 1, effect = d->addition[last].effect;
    struct params rest = d->model;
    rest.effects[effect] = d->given->effects[effect];
    return held_only(effect, &d->model, &rest) && drop(d, last, HUGE_VAL, r);
}

/* Revision. Before the search goes on, an effect that was found earlier is removed and judged again
 * beside those found later. There are two reasons: two effects together can look like a third one,
 * and a wrong effect brings in others that imitate what it leaves unexplained. */
struct revision {
    bool known[EFFECTS_MAX];       /* the effect was found before */
    double penalty[EFFECTS_MAX];   /* penalty of the effect when it was found */
    bool beside[EFFECTS_MAX][EFFECTS_MAX]; /* [a][b]: a was judged while b was in the model */
    bool open;                     /* an effect, described below, is removed for revision */
    struct gap_effect effect;
    struct hypothesis hypothesis;
    struct params model;           /* model with the removed effect */
    double square;                 /* sum of squared white residuals, over all cycles, of the model
                                    * with the removed effect, plus the effect's penalty */
};

/* Records that an effect was judged, or is about to be, beside all added effects. */
static void judged(const struct diagnosis *d, struct revision *v, int effect) {
    for (int i = 0; i < d->added; i++) v->beside[effect][d->addition[i].effect] = true;
}

static bool judged_beside_all(const struct diagnosis *d, const struct revision *v, int effect) {
    bool all = true;
    for (int i = 0; i < d->added; i++) all = all && (d->addition[i].effect == effect || v->beside[effect][d->addition[i].effect]);
    return all;
}

/* Removes the first effect that was not yet judged beside all others. While the last effect has
 * rivals, nothing is judged beside it, and the rivals are left to the verdict. */
static void revise(struct diagnosis *d, struct revision *v, struct gap_result *r) {
    for (int i = 0; i < d->added - 1 && !r->ambiguous && !v->open; i++) {
        int effect = d->addition[i].effect, place = 0;
        if (judged_beside_all(d, v, effect)) continue;
        while (r->effect[place].effect != effect) place++;
        v->effect = r->effect[place];
        v->hypothesis = d->addition[i];
        v->model = d->model;
        v->square = d->square + d->held_square + v->penalty[effect];
        v->open = drop(d, i, HUGE_VAL, r);
        if (v->open) judged(d, v, effect);
    }
}

/* True if no effect is removed for revision, or if a trial explains more than the removed effect
 * did. If the trial is of the removed effect, it may still explain less, because a search from a
 * more distant start may end worse. */
static bool takes_place(const struct revision *v, const struct trial *t) {
    return !v->open || t->square + t->held_square + penalty(t) < v->square;
}

/* Restores the removed effect, because nothing else explains more in its place. */
static void take_back(struct diagnosis *d, struct revision *v, struct gap_result *r) {
    v->open = false;
    if (diagnosis_add(d, &v->hypothesis, &v->model)) r->effect[r->effects++] = v->effect;
}

/* Records an effect that was added: a new one, the removed one again, or one that replaces it. */
static void note(const struct diagnosis *d, struct revision *v, int effect, double penalty) {
    v->known[effect] = true;
    v->penalty[effect] = penalty;
    v->open = false;
    judged(d, v, effect);
}

/* Stores the rivals of the effect that was added last. */
static void tell_rivals(struct gap_result *r, int rivals, const int rival[GAP_RIVALS]) {
    r->ambiguous = rivals;
    memcpy(r->ambiguous_with, rival, sizeof r->ambiguous_with);
}

static int keys_of(const struct hypothesis *h) {
    int keys = 0;
    for (int i = 0; i < h->variables; i++) keys = h->variable[i].key < keys ? keys : h->variable[i].key + 1;
    return keys;
}

/* Factor by which the residuals exceed noise, at least 1. Standard deviations are multiplied by
 * it. */
static double left_over(const struct diagnosis *d) { return sqrt(fmax(d->held_square / d->held_out.evaluated, 1.0)); }

/* Reads values and standard deviations of the added effects from the model's variables. */
static void read_effects(const struct diagnosis *d, struct gap_result *r) {
    for (int i = 0; i < r->effects; i++) r->effect[i].values = d->model.effects[r->effect[i].effect];
    for (int j = 0; j < d->variables; j++)
        for (int i = 0; i < r->effects; i++) {
            const struct variable *v = &d->variable[j];
            if (v->effect != r->effect[i].effect) continue;
            double value = variable_get(v, &d->model);
            for (int leg = 0; leg < LEGS; leg++) {
                if (v->leg >= 0 && v->leg != leg) continue;
                /* a base variable cannot leave its tolerance, so it is no finding: the configured
                 * value is reported */
                if (v->base) {
                    r->effect[i].values.value[v->key][leg] = d->given->effects[v->effect].value[v->key][leg];
                    continue;
                }
                r->effect[i].bound[v->key][leg] = value == v->min || value == v->max;
                r->effect[i].std[v->key][leg] = r->effect[i].bound[v->key][leg] ? 0.0 : left_over(d) * d->std[j];
            }
        }
}

/* Writes an effect's evidence and stores its z. */
static void describe(struct gap_effect *e, const struct params *model, double z, double before, double after) {
    snprintf(e->evidence, sizeof e->evidence, "%s; squared residuals over their noise variance, held-out data: %.0f before, %.0f after",
             gap_signature(e->effect, params_legs(model)), before, after);
    e->z = z;
}

/* Finds clock skew, without a search, because the ratio of the clocks is measured. A deviation up
 * to RECORDING_CLOCK_TOLERANCE is usual for crystals. */
static void find_skew(struct diagnosis *d, const struct recording *recording, struct gap_result *r) {
    int effect = effect_find("clock_skew");
    struct machine given;
    machine_init(&given, d->given);
    double std, ratio = recording_clock(recording, &std), off = fabs(ratio - given.timing.clock_ratio);
    if (!(off > RECORDING_CLOCK_TOLERANCE + 6.0 * std)) return;
    struct gap_effect *e = &r->effect[r->effects++];
    *e = (struct gap_effect){.effect = effect,
                             .pattern = PATTERN_ALL,
                             .keys = 1,
                             .given = d->given->effects[effect],
                             .share_explained = 1.0,
                             .z = off / fmax(std, 1e-9)};
    effect_at(effect_table[effect], 0.0, &e->values);
    for (int leg = 0; leg < LEGS; leg++) e->values.value[0][leg] = ratio, e->std[0][leg] = std;
    d->model.effects[effect] = e->values;
    d->found[effect] = true;
    snprintf(e->evidence, sizeof e->evidence, "%s; stamps and test time drift apart by %.3g ms/s", effect_table[effect]->signature,
             1e3 * (ratio - 1.0));
}

/* Sorts the effects by z. Sets in_doubt to the effect that was added last. */
static void sort_effects(struct gap_result *r) {
    int doubted = r->effects ? r->effect[r->effects - 1].effect : 0;
    gap_sort_effects(r);
    for (int i = 0; i < r->effects; i++)
        if (r->effect[i].effect == doubted) r->in_doubt = i;
}

/* Returns the only effect that was found; NULL if there are none or several. Clock skew is left
 * out, because its share is known. */
static struct gap_effect *only_one(struct gap_result *r) {
    struct gap_effect *only = NULL;
    for (int i = 0; i < r->effects; i++) {
        if (r->effect[i].effect == effect_find("clock_skew")) continue;
        if (only) return NULL;
        only = &r->effect[i];
    }
    return only;
}

/* Finds the share that each effect explains. A single effect gets the whole explained gap. If there
 * are several, each gets the larger of two shares: the one that it explained alone in the first
 * round, and the one that disappeared when it was added. */
static void share_out(const struct diagnosis *d, double initial, double initial_held, struct gap_result *r) {
    double whole = initial_held - d->held_square;
    struct gap_effect *only = only_one(r);
    if (only && whole > 0.0) {
        only->share_explained = 1.0;
        describe(only, &d->model, sqrt(fmax(initial - d->square - d->held_square, 0.0)), initial_held, d->held_square);
        return;
    }
    for (int i = 0; i < r->effects; i++) {
        struct gap_effect *e = &r->effect[i];
        if (e->effect == effect_find("clock_skew")) continue;
        double share = whole > 0.0 ? fmax(e->share_explained / whole, 0.0) : 0.0;
        for (int j = 0; j < r->candidates; j++)
            if (r->candidate[j].effect == e->effect && r->candidate[j].gain > 0.0) share = fmax(share, r->candidate[j].share_explained);
        e->share_explained = fmin(share, 1.0);
    }
}

/* Index of a base variable in the last fit; -1: it was not fitted, because an effect is parallel to
 * it. */
static int place_of(const struct diagnosis *d, const struct variable *base) {
    for (int i = 0; i < d->variables; i++)
        if (d->variable[i].base && d->variable[i].offset == base->offset && d->variable[i].leg == base->leg) return i;
    return -1;
}

void search_read_base(const struct diagnosis *d, struct gap_result *r) {
    r->base_values = 0;
    struct variable base[FIT_VARIABLES];
    int count = base_variables(d->given, d->even.equations, base);
    for (int i = 0; i < count && r->base_values < GAP_BASE; i++) {
        const struct variable *v = &base[i];
        double given = variable_get(v, d->given), value = variable_get(v, &d->model);
        int place = place_of(d, v);
        /* keys of effects (joint positions, valve nulls, springs) are not listed, because they are
         * many and none is a finding; a sensor's error is listed if it exceeds one standard
         * deviation of its prior, unless an effect replaces it */
        bool taken = place < 0 && v->effect >= 0, error = v->penalised && !taken;
        bool usual = error ? fabs(value - v->neutral) * v->prior_inverse_std < 1.0 : v->effect >= 0;
        if (usual || (place < 0 && value == given)) continue;
        r->base[r->base_values++] = (struct gap_base_value){.name = v->name,
                                                            .leg = v->leg,
                                                            .given = given,
                                                            .value = value,
                                                            .std = place < 0 ? (double)NAN : left_over(d) * d->std[place],
                                                            .bound = value <= v->min || value >= v->max};
    }
}

void search_effects(struct diagnosis *d, const struct recording *measured, const struct gap_options *o, struct gap_result *r,
                    struct tried *tried) {
    find_skew(d, measured, r);
    struct trial *trial = memory_get(HYPOTHESES_MAX, sizeof *trial);
    struct revision *revision = memory_get(1, sizeof *revision);
    double initial = d->square + d->held_square, initial_held = d->held_square;

    for (int round = 0; round < ROUNDS_MAX; round++) {
        if (!revision->open) revise(d, revision, r);
        if (r->effects == GAP_EFFECTS) break;
        gap_progress(o, round ? "another effect" : "screening", 0.7 * round / ROUNDS_MAX);
        int trials = trials_run(d, trial);
        if (!trials) break;
        if (round == 0) list_candidates(d, trial, trials, r);
        prefer_seen(d, trial, trials);
        prefer_simple(d, trial, trials);
        note_rivals(d, trial, trials, tried);

        int rival[GAP_RIVALS] = {0}, rivals = list_rivals(d, trial, trials, rival);
        int effect = trial[0].hypothesis->effect;
        /* rivals do not keep out the first effect, or one that was found before; the verdict
         * mentions them */
        bool found = !r->effects || revision->open || revision->known[effect];
        bool unclear = !found && rivals && trial_evidence(&trial[0]) < UNCLEAR_GAIN * dispersion(d, &trial[0]);
        bool worth = !unclear && worth_adding(d, &trial[0], goodness_law_error(d));
        if (!worth && !revision->open) break;
        if (!worth || !takes_place(revision, &trial[0])) {
            take_back(d, revision, r);
            if (worth && effect == revision->effect.effect) tell_rivals(r, rivals, rival);
            continue;
        }

        if (prefer_two_effects(d, r, trial, trials)) rivals = list_rivals(d, trial, trials, rival);
        double before = d->held_square, z = likelihood(d, &trial[0]), paid = penalty(&trial[0]);
        struct gap_effect *e = &r->effect[r->effects];
        *e = (struct gap_effect){.effect = effect,
                                 .pattern = trial[0].hypothesis->pattern,
                                 .given = d->given->effects[effect],
                                 .keys = keys_of(trial[0].hypothesis)};
        if (!diagnosis_add(d, trial[0].hypothesis, &trial[0].model)) break;
        r->effects++;
        tell_rivals(r, rivals, rival);
        note(d, revision, effect, paid);
        e->share_explained = before - d->held_square;
        describe(e, &d->model, z, before, d->held_square);
        if (drop_unseen(d, r)) {
            tell_rivals(r, 0, rival);
            break;
        }
        drop_superfluous(d, r);
    }

    if (revision->open) take_back(d, revision, r);
    free(trial);
    free(revision);
    share_out(d, initial, initial_held, r);
    if (r->effects) diagnosis_estimate(d);
    search_read_base(d, r);
    read_effects(d, r);
    sort_effects(r);
    tried->found = (struct set){.effects = d->added, .model = d->model};
    memcpy(tried->found.hypothesis, d->addition, sizeof tried->found.hypothesis);
}
