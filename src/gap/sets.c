#include "sets.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "evidence.h"
#include "goodness.h"
#include "memory.h"
#include "numeric.h"
#include "trials.h"

enum { WIDTH = 3, BRANCHES = 5, SETS_MAX = 64, SIZES_MAX = 80 };

/* Effort of the search: how many sets of a size are extended, by how many effects each, and how
 * often the search is repeated with a better reference model (covariance.h). Six legs have so many
 * equations that one narrow search finds the effects; even so it takes a hundred times as long. */
struct effort {
    int width, branches, rounds;
};
static const struct effort one_leg = {WIDTH, BRANCHES, 2}, six_legs = {1, 3, 0};

static const double SURE = 0.95;        /* least probability of a statement that the verdict
                                         * makes */
static const double NEGLIGIBLE = 0.01;  /* an effect that is less probable than this is not listed
                                         * beside sure ones */
static const double WIDER = 10.0;       /* factor on the prior standard deviations of the search,
                                         * because machines of other people may be of any size */
static const double OWN_SIZE = 3.0;     /* prior standard deviation of an axis's value, as a
                                         * multiple of the value that would make the whole gap by
                                         * itself */
static const double FIRST_SPREAD = 0.1; /* size of the spread (covariance.h) before a set is the
                                         * reference model */
static const double UNLIKELY = 12.0;    /* a set of two or more effects is extended only if its log
                                         * evidence is behind the best one's by less than this */
static const double MORE = 3.0;         /* log of the odds, 20 to 1, by which a set must be ahead of
                                         * its limiting case to be preferred */
static const double EMPIRICAL = 0.05;   /* least law_error of an effect that may leave a remainder
                                         * on six legs. A smaller law_error means an exact law,
                                         * which a remainder refutes: a base on springs looks like
                                         * springs on the platform, but leaves a remainder */
static const double EXPLAINED = 0.5;    /* least share of the held-out gap that the effects of a
                                         * verdict explain together */

struct set {
    int effects;
    struct hypothesis hypothesis[GAP_EFFECTS];
    struct params model;
    struct linearised linear;
    /* evidence: log of the mean evidence over the sizes of the remainder, plus log_prior.
     * log_evidence: at each size, without log_prior. probability: among all sets that are kept */
    double log_prior, evidence, probability;
    double log_evidence[SIZES_MAX];
};

struct comparison {
    struct diagnosis *d;
    struct effort effort;
    struct fit_data fit, held_out;  /* data with the whiteners of noise alone */
    struct covariance covariance, held_covariance;
    double *variance;               /* [values]: variances of the whiteners in d, relative to those
                                     * of noise */
    double gap;                     /* rms of the residuals without any effect, in units of the
                                     * noise */
    int sizes;
    struct covariance_size size[SIZES_MAX];
    double weight[SIZES_MAX];       /* probability of each size */
    int sets;
    struct set *set;
};

/* --- covariance */

static void list_sizes(struct comparison *s) {
    /* law error in addition to the laws' own law_error: none, or 0.4 % to a fifth in nearly equal
     * ratios */
    static const double spread[] = {0.03, 0.1, 0.3, 1.0}, repeats[] = {0.0, 0.1, 0.3, 1.0}, law[] = {0.0, 4e-3, 0.015, 0.05, 0.2};
    s->sizes = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < (s->covariance.features ? 4 : 1); j++)
            for (int k = 0; k < 5; k++) s->size[s->sizes++] = (struct covariance_size){spread[i], repeats[j], law[k]};
}

/* Divides the rows of the whiteners by the standard deviations that a covariance gives. */
static void whiten_more(const struct fit_data *noise, const struct covariance *c, double spread, double *variance, struct fit_data *d) {
    enum { ROW = sizeof(residual_row) / sizeof(double) };
    const struct covariance_size fitted = {spread, 0.0, 0.05};
    for (int i = 0; i < d->residual->tests; i++) d->whitener[i] = noise->whitener[i];
    for (int i = 0; i < c->values; i++) {
        double v = covariance_of(c, &fitted, i);
        if (variance) variance[i] = v;
        int row = i % ROW, leg = row / RESIDUAL_SIZE / RESIDUALS, kind = row / RESIDUAL_SIZE % RESIDUALS;
        for (int j = 0; j < RESIDUALS; j++) d->whitener[i / ROW].inverse[leg][row % RESIDUAL_SIZE][kind][j] /= sqrt(v);
    }
}

static void restore_noise(struct comparison *s) {
    memcpy(s->d->fit.whitener, s->fit.whitener, (size_t)s->fit.residual->tests * sizeof *s->fit.whitener);
    memcpy(s->d->held_out.whitener, s->held_out.whitener, (size_t)s->held_out.residual->tests * sizeof *s->held_out.whitener);
}

/* Makes the model of the diagnosis, whose whiteners contain noise alone, the reference model of the
 * covariance, and adds the remainder to these whiteners. */
static void take_reference(struct comparison *s, double spread) {
    struct diagnosis *d = s->d;
    covariance_free(&s->covariance);
    covariance_free(&s->held_covariance);
    covariance_init(&s->covariance, d, &d->fit);
    covariance_init(&s->held_covariance, d, &d->held_out);
    whiten_more(&s->fit, &s->covariance, spread, s->variance, &d->fit);
    whiten_more(&s->held_out, &s->held_covariance, spread, NULL, &d->held_out);
    list_sizes(s);
}

/* --- sets */

/* Returns false for the errors of sensors and clocks, which do not grow with the machine. */
static bool grows_with_machine(int effect) {
    enum effect_family family = effect_table[effect]->family;
    return family != EFFECT_SENSORS && family != EFFECT_TIMING;
}

/* On an axis with a constant force, gives each friction one value for both directions; a viscous
 * one may also have a value for each. */
static void list_symmetric(struct diagnosis *d) {
    int listed = d->hypotheses;
    for (int i = 0; i < listed; i++) {
        struct hypothesis *h = &d->hypothesis[i], each = *h;
        if (hypothesis_make_symmetric(h) && !hypothesis_is_dry(h)) d->hypothesis[d->hypotheses++] = each;
    }
}

/* Widens the priors, so that they suit machines of any size. */
static void widen(struct diagnosis *d) {
    bool constant = params_mechanism(d->given)->force_sensor;
    if (constant) list_symmetric(d);
    for (int i = 0; i < d->hypotheses; i++) {
        if (constant && !grows_with_machine(d->hypothesis[i].effect)) continue;
        for (int j = 0; j < d->hypothesis[i].variables; j++) d->hypothesis[i].variable[j].prior_inverse_std /= WIDER;
    }
}

/* Makes the priors of masses, frictions and springs of one axis OWN_SIZE times as wide as values
 * that would make the gap by themselves. The typical sizes are those of a platform. For a joint of
 * 0.1 N m a prior of a kilonewton would lower the evidence of each effect, and a sensor's scale,
 * whose prior is the same on all machines, would then win against the mass. */
static void scale_priors(const struct comparison *s, struct linearised *l) {
    if (!params_mechanism(s->d->given)->force_sensor) return;
    for (int i = 0; i < l->variables; i++) {
        const struct variable *v = &s->d->variable[i];
        if (v->base || l->uniform[i] || !grows_with_machine(v->effect) || effect_table[v->effect]->keys[v->key].shapes_law) continue;
        const double *column = l->column + (size_t)i * (size_t)l->rows;
        double size = sqrt(dense_dot(l->rows, column, column) / l->rows);
        if (size > 0.0) l->inverse_std[i] = size / (OWN_SIZE * s->gap);
    }
}

/* Linearises a set where it was fitted. */
static void linearise(struct comparison *s, struct set *one) {
    linearised_init(&one->linear, s->d, &s->covariance, s->variance);
    const struct linearised *l = &one->linear;
    if (!one->effects) s->gap = sqrt(dense_dot(l->rows, l->white, l->white) / l->rows);
    scale_priors(s, &one->linear);
}

static bool assume(struct diagnosis *d, const struct set *s) {
    bool possible = diagnosis_assume(d, s->effects, s->hypothesis, &s->model);
    widen(d);
    return possible;
}

static bool same(const struct set *a, const struct set *b) {
    int common = 0;
    for (int i = 0; i < a->effects; i++)
        for (int j = 0; j < b->effects; j++)
            common += a->hypothesis[i].effect == b->hypothesis[j].effect && a->hypothesis[i].pattern == b->hypothesis[j].pattern &&
                      a->hypothesis[i].symmetric == b->hypothesis[j].symmetric;
    return a->effects == b->effects && common == a->effects;
}

static double log_choose(int n, int k) { return lgamma(n + 1.0) - lgamma(k + 1.0) - lgamma(n - k + 1.0); }

/* Log of the prior probability of a set: one half for no effect, a quarter for one effect, and so
 * on. All sets of a size are equally likely, and so are all choices of legs for an effect. */
static double log_prior(const struct diagnosis *d, const struct set *s) {
    int effects = 0;
    for (int i = 0; i < d->hypotheses; i++)
        effects += d->hypothesis[i].pattern == PATTERN_ALL && (i == 0 || d->hypothesis[i - 1].effect < d->hypothesis[i].effect);
    effects += d->added;
    double shapes = params_legs(d->given) > 1 ? 2.0 + LEGS : 1.0;
    double size = s->effects < GAP_EFFECTS ? s->effects + 1.0 : GAP_EFFECTS;
    return -size * log(2.0) - log_choose(effects, s->effects) - s->effects * log(shapes);
}

static double log_sum(double a, double b) {
    double most = fmax(a, b);
    return most == -HUGE_VAL ? most : most + log(exp(a - most) + exp(b - most));
}

/* Finds the evidence of a set under all sizes of the remainder, which are equally likely
 * beforehand. */
static void weigh(const struct comparison *s, struct set *one) {
    double sum = -HUGE_VAL;
    for (int i = 0; i < s->sizes; i++) {
        one->log_evidence[i] = evidence_of(&one->linear, &s->covariance, &s->size[i], NULL, NULL);
        sum = log_sum(sum, one->log_evidence[i]);
    }
    one->evidence = isnan(sum) ? -HUGE_VAL : sum - log(s->sizes) + one->log_prior;
}

static bool acts(const struct set *s) {
    bool all = true;
    for (int i = 0; i < s->effects; i++)
        all = all && effect_acts(effect_table[s->hypothesis[i].effect], &s->model.effects[s->hypothesis[i].effect]);
    return all;
}

/* True if a parameter of a law's form, or a sensor's error, is at the end of its range. Then the
 * law has become that of its limiting case, which is another effect, or the fit has gone astray, or
 * the sensor would be implausibly wrong. */
static bool at_end(const struct set *s) {
    bool end = false;
    for (int i = 0; i < s->effects; i++)
        for (int j = 0; j < s->hypothesis[i].variables; j++) {
            const struct variable *v = &s->hypothesis[i].variable[j];
            double value = variable_get(v, &s->model), margin = 1e-6 * (v->max - v->min);
            bool shapes = effect_table[v->effect]->keys[v->key].shapes_law || !grows_with_machine(v->effect);
            bool off = fabs(value - v->neutral) > margin; /* a delay of 0 begins its range */
            end = end || (shapes && off && (value <= v->min + margin || value >= v->max - margin));
        }
    return end;
}

/* Returns a place for one more set: a free one, or, if there is none, that of the worst set. NULL
 * if no set is worse. */
static struct set *place_for(struct comparison *s, double evidence) {
    if (s->sets < SETS_MAX) return &s->set[s->sets++];
    struct set *worst = &s->set[0];
    for (int i = 1; i < s->sets; i++)
        if (s->set[i].evidence < worst->evidence) worst = &s->set[i];
    if (!(evidence > worst->evidence)) return NULL;
    linearised_free(&worst->linear);
    return worst;
}

/* Fits a set and keeps it with its evidence, unless it is known already, impossible or without
 * effect, or has a law at the end of its range. */
static void keep(struct comparison *s, struct set *one) {
    bool known = false;
    for (int i = 0; i < s->sets; i++) known = known || same(&s->set[i], one);
    if (known || !assume(s->d, one)) return;
    one->model = s->d->model;
    if (!acts(one) || at_end(one)) return;
    one->log_prior = log_prior(s->d, one);
    linearise(s, one);
    weigh(s, one);
    struct set *place = place_for(s, one->evidence);
    if (place) *place = *one;
    else linearised_free(&one->linear);
}

/* Extends a set by the effects that explain most beside it. */
static void extend(struct comparison *s, const struct set *from, struct trial *trial, struct set *branch) {
    struct diagnosis *d = s->d;
    int branches = 0;
    if (!assume(d, from)) return;
    int trials = trials_run(d, trial);
    for (int i = 0; i < trials && branches < s->effort.branches; i++) {
        if (!trial[i].ok || !trial[i].polished) continue;
        branch[branches] = (struct set){.effects = from->effects + 1, .model = trial[i].model};
        memcpy(branch[branches].hypothesis, from->hypothesis, sizeof from->hypothesis);
        branch[branches++].hypothesis[from->effects] = *trial[i].hypothesis; /* copied, because a
                                                                              * refit lists the
                                                                              * hypotheses anew */
    }
    for (int i = 0; i < branches; i++) keep(s, &branch[i]);
}

static int by_evidence(const void *a, const void *b) {
    const struct set *x = a, *y = b;
    return x->evidence < y->evidence ? 1 : x->evidence > y->evidence ? -1 : 0;
}

/* Extends the best sets of each size, as long as the larger ones are not much less likely. */
static void search(struct comparison *s, const struct params *base) {
    struct trial *trial = memory_get(HYPOTHESES_MAX, sizeof *trial);
    struct set *branch = memory_get(BRANCHES, sizeof *branch), *from = memory_get(WIDTH, sizeof *from);
    struct set nothing = {.model = *base};
    keep(s, &nothing);
    for (int size = 0; size < GAP_EFFECTS; size++) {
        int chosen = 0;
        qsort(s->set, (size_t)s->sets, sizeof *s->set, by_evidence);
        for (int i = 0; i < s->sets && chosen < s->effort.width; i++)
            if (s->set[i].effects == size && s->set[i].evidence > s->set[0].evidence - (size > 1 ? UNLIKELY : HUGE_VAL))
                from[chosen++] = s->set[i];
        for (int i = 0; i < chosen; i++) extend(s, &from[i], trial, branch);
    }
    qsort(s->set, (size_t)s->sets, sizeof *s->set, by_evidence);
    free(trial);
    free(branch);
    free(from);
}

/* True if the second set differs from the first in one effect only, which is a limiting case of the
 * effect that it replaces. */
static bool limit_of(const struct set *a, const struct set *b) {
    int common = 0, limits = 0;
    if (a->effects != b->effects) return false;
    for (int i = 0; i < a->effects; i++)
        for (int j = 0; j < b->effects; j++) {
            if (a->hypothesis[i].pattern != b->hypothesis[j].pattern) continue;
            common += a->hypothesis[i].effect == b->hypothesis[j].effect;
            limits += hypothesis_contains(a->hypothesis[i].effect, b->hypothesis[j].effect);
        }
    return common == a->effects - 1 && limits == 1;
}

/* Leaves out a set if one of its limiting cases explains about as much, because the simpler set is
 * then preferred. */
static void prefer_limits(struct comparison *s) {
    for (int i = s->sets - 1; i >= 0; i--) {
        bool limit = false;
        for (int j = 0; j < s->sets; j++)
            limit = limit || (limit_of(&s->set[i], &s->set[j]) && s->set[i].evidence < s->set[j].evidence + MORE);
        if (!limit) continue;
        linearised_free(&s->set[i].linear);
        memmove(s->set + i, s->set + i + 1, (size_t)(--s->sets - i) * sizeof *s->set);
    }
}

/* Finds the probabilities of sets and sizes. */
static void find_probabilities(struct comparison *s) {
    double sum = -HUGE_VAL, size[SIZES_MAX];
    for (int j = 0; j < s->sizes; j++) size[j] = -HUGE_VAL;
    for (int i = 0; i < s->sets; i++) {
        sum = log_sum(sum, s->set[i].evidence);
        for (int j = 0; j < s->sizes; j++) size[j] = log_sum(size[j], s->set[i].log_evidence[j] + s->set[i].log_prior);
    }
    for (int i = 0; i < s->sets; i++) s->set[i].probability = exp(s->set[i].evidence - sum);
    for (int j = 0; j < s->sizes; j++) s->weight[j] = exp(size[j] - log(s->sizes) - sum);
}

/* --- statements */

static int place_in(const struct set *s, int effect) {
    for (int i = 0; i < s->effects; i++)
        if (s->hypothesis[i].effect == effect) return i;
    return -1;
}

static bool has_family(const struct set *s, int family) {
    for (int i = 0; i < s->effects; i++)
        if ((int)effect_table[s->hypothesis[i].effect]->family == family) return true;
    return false;
}

static const struct set *likeliest_with(const struct comparison *s, int effect) {
    for (int i = 0; i < s->sets; i++)
        if (place_in(&s->set[i], effect) >= 0) return &s->set[i];
    return NULL;
}

/* Log evidence of the best set without an effect, from which the effect's z follows. */
static double without(const struct comparison *s, int effect) {
    for (int i = 0; i < s->sets; i++)
        if (place_in(&s->set[i], effect) < 0) return s->set[i].evidence;
    return -HUGE_VAL;
}

/* Share of the held-out gap that the model of a set explains, with the whiteners of noise alone. */
static double share_of(const struct comparison *s, const struct params *base, const struct params *model) {
    struct diagnosis noise = {.held_out = s->held_out};
    double before = diagnosis_held_square(&noise, base), after = diagnosis_held_square(&noise, model);
    return fmin(fmax((before - after) / (before - s->held_out.evaluated), 0.0), 1.0);
}

/* Number of the key after the last one that a variable sets. */
static int end_of(const struct variable *v) { return v->key + (v->legs > LEGS ? 2 : 1); }

/* Fills an effect's values in a set: means and standard deviations over the sizes of the remainder.
 * The deviations include the law error that these sizes allow. */
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

static void state_effect(const struct comparison *s, const struct params *base, int effect, struct gap_effect *e) {
    const struct set *one = likeliest_with(s, effect);
    int place = place_in(one, effect), keys = 0;
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
        if (s->set[i].effects == 1 && place_in(&s->set[i], effect) == 0) single = &s->set[i];
    struct params alone = single ? single->model : *base;
    if (!single) alone.effects[effect] = one->model.effects[effect];
    e->share_explained = share_of(s, base, &alone);
}

/* Lists statements about all effects, or about all families, each with its probability; the
 * likeliest first. Returns their number. */
static int list_statements(const struct comparison *s, bool families, struct gap_statement *list) {
    int n = 0, end = families ? EFFECT_FAMILIES : EFFECTS_MAX;
    for (int which = 0; which < end && (families || effect_table[which]); which++) {
        struct gap_statement one = {.family = families, .which = which};
        for (int i = 0; i < s->sets; i++)
            if (families ? has_family(&s->set[i], which) : place_in(&s->set[i], which) >= 0) one.probability += s->set[i].probability;
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

/* Fills the statements: first the sure ones, which are an effect if it is sure, otherwise its
 * family if the family is sure; then the likeliest others. Returns the number of sure ones. */
static int state_all(const struct comparison *s, struct gap_result *r) {
    enum { LIKELIEST = 3 };
    struct gap_statement effect[EFFECTS_MAX], family[EFFECT_FAMILIES];
    int effects = list_statements(s, false, effect), families = list_statements(s, true, family), sure = 0;
    bool covered[EFFECT_FAMILIES] = {false};
    r->statements = 0;
    r->certainty = 1.0;
    for (int i = 0; i < effects && effect[i].probability >= SURE && sure < GAP_EFFECTS; i++) {
        covered[effect_table[effect[i].which]->family] = true;
        r->certainty = fmin(r->certainty, effect[i].probability);
        add_statement(s, r, effect[i], effect[i].which), sure++;
    }
    for (int i = 0; i < families && family[i].probability >= SURE && sure < GAP_EFFECTS; i++) {
        if (covered[family[i].which]) continue;
        r->certainty = fmin(r->certainty, family[i].probability);
        add_statement(s, r, family[i], member(effect, effects, family[i].which)), sure++;
    }
    for (int i = 0; i < effects && i < LIKELIEST && r->statements < GAP_STATEMENTS; i++)
        if (effect[i].probability < SURE && (!sure || effect[i].probability > NEGLIGIBLE)) add_statement(s, r, effect[i], effect[i].which);
    return sure;
}

/* True if the machine surely has exactly one of two effects. */
static bool either(const struct comparison *s, int one, int other) {
    double sum = 0.0;
    for (int i = 0; i < s->sets; i++) {
        bool has = place_in(&s->set[i], one) >= 0, has_other = place_in(&s->set[i], other) >= 0;
        if (has != has_other) sum += s->set[i].probability;
    }
    return sum >= SURE;
}

/* True if a sure statement is about the effect's family. */
static bool in_sure_family(const struct gap_result *r, int sure, int effect) {
    for (int i = 0; i < sure; i++)
        if (r->statement[i].family && r->statement[i].which == (int)effect_table[effect]->family) return true;
    return false;
}

/* Looks for two effects of which one is surely there, though not which of them (either()). The
 * likelier one becomes a sure statement, the other its rival. Returns the number of sure
 * statements. */
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
            r->certainty = fmin(r->certainty, first.probability);
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
        const struct set *with = place_in(from, effect) >= 0 ? from : likeliest_with(s, effect);
        one->hypothesis[one->effects++] = with->hypothesis[place_in(with, effect)];
        one->model.effects[effect] = with->model.effects[effect];
    }
    for (int i = 0; i < from->effects; i++) {
        int effect = from->hypothesis[i].effect;
        if (place_in(one, effect) < 0) one->model.effects[effect] = s->d->given->effects[effect];
    }
    if (!assume(s->d, one)) return false;
    one->model = s->d->model;
    one->log_prior = log_prior(s->d, one);
    linearise(s, one);
    weigh(s, one);
    return acts(one);
}

/* True if the laws of the set's effects are inexact enough to leave a remainder; always true for a
 * machine of one leg. */
static bool may_leave(const struct comparison *s, const struct set *one) {
    bool all = true;
    for (int i = 0; i < one->effects; i++) all = all && effect_table[one->hypothesis[i].effect]->law_error >= EMPIRICAL;
    return all || params_legs(s->d->given) == 1;
}

/* True if a model leaves more on held-out data than noise. */
static bool leaves(const struct comparison *s, const struct params *model) {
    struct diagnosis noise = {.held_out = s->held_out};
    return diagnosis_held_square(&noise, model) > LEFT_WHITE * s->held_out.evaluated;
}

/* Moves the errors of sensors and clocks behind the other sure statements. Returns the number of
 * the others. */
static int sensors_last(struct gap_result *r, int sure) {
    int kept = 0;
    for (int i = 0; i < sure; i++) {
        struct gap_statement one = r->statement[i];
        if (!grows_with_machine(one.effect.effect)) continue;
        memmove(r->statement + kept + 1, r->statement + kept, (size_t)(i - kept) * sizeof one);
        r->statement[kept++] = one;
    }
    return kept;
}

/* Fits the sure statements. With one leg, errors of sensors and clocks are left out if a remainder
 * is left, unless there is no other statement, or an effect is in doubt. Their laws are exact, so
 * beside a remainder they stand for something else, such as a damper's elastic mount. Returns the
 * number of statements that were fitted; 0 if the fit failed. */
static int fit_all(struct comparison *s, struct gap_result *r, int sure, struct set *one) {
    if (!fit_sure(s, r, sure, one)) return 0;
    bool remainder = params_legs(s->d->given) == 1 && leaves(s, &s->d->model);
    int others = remainder && !r->ambiguous ? sensors_last(r, sure) : sure;
    if (!others || others == sure) return sure;
    linearised_free(&one->linear);
    return fit_sure(s, r, others, one) ? others : 0;
}

/* Makes the sure statements the findings. Returns false if there are none, or if they do not
 * explain the gap together. */
static bool settle(struct comparison *s, struct gap_result *r, int sure) {
    struct set *one = memory_get(1, sizeof *one);
    r->ambiguous = 0, r->in_doubt = 0;
    sure = find_rivals(s, r, sure);
    sure = sure ? fit_all(s, r, sure, one) : 0;
    bool settled = sure && may_leave(s, one) && share_of(s, &r->base_model, &s->d->model) > EXPLAINED;
    r->effects = 0;
    for (int i = 0; i < sure && settled; i++) {
        struct gap_effect *e = &r->effect[r->effects++];
        read_values(s, one, i, &r->statement[i].effect);
        *e = r->statement[i].effect;
        snprintf(e->evidence, sizeof e->evidence, "%s; probability %.2f", effect_table[e->effect]->signature, r->statement[i].probability);
    }
    linearised_free(&one->linear);
    free(one);
    return settled;
}

/* Makes the model of the best set the reference model, and weighs all sets anew. Returns false
 * without a set, or if the model with the best one cannot be fitted. */
static bool better_reference(struct comparison *s) {
    restore_noise(s);
    if (!s->sets || !assume(s->d, &s->set[0])) return false;
    take_reference(s, 1.0);
    for (int i = 0; i < s->sets; i++) weigh(s, &s->set[i]);
    qsort(s->set, (size_t)s->sets, sizeof *s->set, by_evidence);
    return true;
}

static void keep_noise(const struct fit_data *d, struct fit_data *noise) {
    *noise = *d;
    noise->whitener = memory_get((size_t)d->residual->tests, sizeof *noise->whitener);
    memcpy(noise->whitener, d->whitener, (size_t)d->residual->tests * sizeof *noise->whitener);
}

bool sets_compare(struct diagnosis *d, struct gap_result *r) {
    struct comparison *s = memory_get(1, sizeof *s);
    s->d = d;
    s->effort = params_legs(d->given) == 1 ? one_leg : six_legs;
    s->set = memory_get(SETS_MAX, sizeof *s->set);
    s->variance = memory_get((size_t)d->fit.values, sizeof *s->variance);
    keep_noise(&d->fit, &s->fit), keep_noise(&d->held_out, &s->held_out);
    take_reference(s, FIRST_SPREAD);
    search(s, &r->base_model);
    for (int round = 0; round < s->effort.rounds && better_reference(s); round++) search(s, &r->base_model);
    bool settled = false;
    if (better_reference(s)) {
        prefer_limits(s);
        find_probabilities(s);
        settled = settle(s, r, state_all(s, r));
    }

    restore_noise(s);
    if (settled) settled = diagnosis_assume(d, d->added, d->addition, &d->model);
    covariance_free(&s->covariance);
    covariance_free(&s->held_covariance);
    for (int i = 0; i < s->sets; i++) linearised_free(&s->set[i].linear);
    free(s->set);
    free(s->variance);
    free(s->fit.whitener);
    free(s->held_out.whitener);
    free(s);
    return settled;
}
