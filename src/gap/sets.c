#include "sets.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "memory.h"
#include "numeric.h"
#include "trials.h"

enum { WIDTH = 3, BRANCHES = 5 };

/* Effort of the search. width: number of sets of each size that are extended. branches: number of
 * effects by which each of them is extended. rounds: number of times that the search is repeated
 * with a better reference model (covariance.h). Six legs have so many equations that one narrow
 * search finds the effects; even this search takes a hundred times as long as that with one leg. */
struct effort {
    int width, branches, rounds;
};
static const struct effort one_leg = {WIDTH, BRANCHES, 2}, six_legs = {1, 3, 0};

static struct effort effort_of(const struct comparison *s) { return params_legs(s->d->given) == 1 ? one_leg : six_legs; }

static const double WIDER = 10.0;       /* factor on the prior standard deviations of the search,
                                         * because machines of other people may be of any size */
static const double OWN_SIZE = 3.0;     /* prior standard deviation of a value of a single axis, as
                                         * a multiple of the value that would make the whole gap by
                                         * itself */
static const double UNLIKELY = 12.0;    /* a set of two or more effects is extended only if its log
                                         * evidence is less than this behind that of the best set */
static const double MORE = 3.0;         /* log of the odds, 20 to 1, by which a set must be ahead of
                                         * its limiting case to be preferred */

/* --- covariance */

static bool any(int values, const double *x) {
    bool some = false;
    for (int i = 0; i < values; i++) some = some || x[i] > 0.0;
    return some;
}

/* Lists the sizes of the remainder under which sets are compared. A part that is absent from the
 * covariance, or from an exact comparison, has one size only. */
static void list_sizes(struct comparison *s) {
    /* law: law error in addition to the laws' own law_error: none, or 0.4 % to a fifth in nearly
     * equal ratios */
    static const double spread[] = {0.03, 0.1, 0.3, 1.0}, repeats[] = {0.0, 0.1, 0.3, 1.0}, law[] = {0.0, 4e-3, 0.015, 0.05, SETS_LAW_MOST};
    const struct covariance *c = &s->covariance;
    int spreads = any(c->values, c->spread) ? 4 : 1, laws = !s->exact && any(c->values, c->law) ? 5 : 1;
    s->sizes = 0;
    for (int i = 0; i < spreads; i++)
        for (int j = 0; j < (c->features ? 4 : 1); j++)
            for (int k = 0; k < laws; k++) s->size[s->sizes++] = (struct covariance_size){spread[i], repeats[j], law[k]};
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
    s->d->whitened_anew = true;
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
    d->whitened_anew = true;
    whiten_more(&s->fit, &s->covariance, spread, s->variance, &d->fit);
    whiten_more(&s->held_out, &s->held_covariance, spread, NULL, &d->held_out);
    list_sizes(s);
}

/* --- sets */

bool sets_grows_with_machine(int effect) {
    enum effect_family family = effect_table[effect]->family;
    return family != EFFECT_SENSORS && family != EFFECT_TIMING;
}

/* Gives each friction one value for both directions, for an axis with a constant force. A viscous
 * friction is listed a second time, with a value for each direction. */
static void list_symmetric(struct diagnosis *d) {
    int listed = d->hypotheses;
    for (int i = 0; i < listed; i++) {
        struct hypothesis *h = &d->hypothesis[i], each = *h;
        if (hypothesis_make_symmetric(h) && !hypothesis_is_dry(h)) d->hypothesis[d->hypotheses++] = each;
    }
}

/* Widens the priors, so that they suit machines of any size. With a constant force the priors of
 * sensors and clocks stay as they are, and frictions become symmetric. */
static void widen(struct diagnosis *d) {
    bool constant = params_mechanism(d->given)->force_sensor;
    if (constant) list_symmetric(d);
    for (int i = 0; i < d->hypotheses; i++) {
        if (constant && !sets_grows_with_machine(d->hypothesis[i].effect)) continue;
        for (int j = 0; j < d->hypothesis[i].variables; j++) d->hypothesis[i].variable[j].prior_inverse_std /= WIDER;
    }
}

/* True for values that grow with the machine, such as masses, frictions and springs, and for a
 * constant force, because a friction that differs between the directions may take its place. */
static bool scales(const struct variable *v) {
    if (v->base) return v->offset == offsetof(struct params, axis.force_offset_n);
    return sets_grows_with_machine(v->effect) && !effect_table[v->effect]->keys[v->key].shapes_law;
}

/* Scales the priors of a single axis to its gap: a value for which scales() is true gets a prior
 * OWN_SIZE times as wide as the value that would make the gap by itself. The typical sizes, from
 * which the priors follow otherwise, are those of a platform. For a joint of 0.1 N m a prior of a
 * kilonewton would lower the evidence of each effect, and a sensor's scale, whose prior is the same
 * on all machines, would then win against the mass. */
static void scale_priors(const struct comparison *s, struct linearised *l) {
    if (!params_mechanism(s->d->given)->force_sensor) return;
    for (int i = 0; i < l->variables; i++) {
        const struct variable *v = &s->d->variable[i];
        if (!scales(v) || (l->uniform[i] && !v->base)) continue;
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

bool sets_same(const struct set *a, const struct set *b) {
    int common = 0;
    for (int i = 0; i < a->effects; i++)
        for (int j = 0; j < b->effects; j++)
            common += a->hypothesis[i].effect == b->hypothesis[j].effect && a->hypothesis[i].pattern == b->hypothesis[j].pattern &&
                      a->hypothesis[i].symmetric == b->hypothesis[j].symmetric;
    return a->effects == b->effects && common == a->effects;
}

static double log_choose(int n, int k) { return lgamma(n + 1.0) - lgamma(k + 1.0) - lgamma(n - k + 1.0); }

/* Log of the prior probability of a set: one half for no effect, a quarter for one, an eighth for
 * two, a sixteenth each for three and four. All sets of a size are equally likely, and so are all
 * choices of legs for an effect. A set may count as one of fewer effects (struct set). */
static double log_prior(const struct diagnosis *d, const struct set *s) {
    int effects = 0;
    for (int i = 0; i < d->hypotheses; i++)
        effects += d->hypothesis[i].pattern == PATTERN_ALL && (i == 0 || d->hypothesis[i - 1].effect < d->hypothesis[i].effect);
    effects += d->added;
    int causes = s->causes ? s->causes : s->effects;
    double shapes = params_legs(d->given) > 1 ? 2.0 + LEGS : 1.0;
    double size = causes < GAP_EFFECTS ? causes + 1.0 : GAP_EFFECTS;
    return -size * log(2.0) - log_choose(effects, causes) - causes * log(shapes);
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

/* True if a parameter of a law's form, or a sensor's error, is at the end of its range. This has
 * three possible reasons: the law has become its limiting case, which is another effect; the fit
 * has gone astray; or the sensor would be implausibly wrong. */
static bool at_end(const struct set *s) {
    bool end = false;
    for (int i = 0; i < s->effects; i++)
        for (int j = 0; j < s->hypothesis[i].variables; j++) {
            const struct variable *v = &s->hypothesis[i].variable[j];
            double value = variable_get(v, &s->model), margin = 1e-6 * (v->max - v->min);
            bool shapes = effect_table[v->effect]->keys[v->key].shapes_law || !sets_grows_with_machine(v->effect);
            bool off = fabs(value - v->neutral) > margin; /* a neutral value may be the end of a
                                                           * range, such as a delay of 0 */
            end = end || (shapes && off && (value <= v->min + margin || value >= v->max - margin));
        }
    return end;
}

/* Returns a place for one more set: a free one, or, if there is none, that of the set with the
 * least evidence. Returns NULL if no set has less evidence than the new one. */
static struct set *place_for(struct comparison *s, double evidence) {
    if (s->sets < SETS_MAX) return &s->set[s->sets++];
    struct set *worst = &s->set[0];
    for (int i = 1; i < s->sets; i++)
        if (s->set[i].evidence < worst->evidence) worst = &s->set[i];
    if (!(evidence > worst->evidence)) return NULL;
    linearised_free(&worst->linear);
    return worst;
}

void sets_keep(struct comparison *s, struct set *one) {
    bool known = false;
    for (int i = 0; i < s->sets; i++) known = known || sets_same(&s->set[i], one);
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
    for (int i = 0; i < trials && branches < effort_of(s).branches; i++) {
        if (!trial[i].ok || !trial[i].polished) continue;
        branch[branches] = (struct set){.effects = from->effects + 1, .model = trial[i].model};
        memcpy(branch[branches].hypothesis, from->hypothesis, sizeof from->hypothesis);
        branch[branches++].hypothesis[from->effects] = *trial[i].hypothesis; /* copied, because a
                                                                              * refit lists the
                                                                              * hypotheses anew */
    }
    for (int i = 0; i < branches; i++) sets_keep(s, &branch[i]);
}

static int by_evidence(const void *a, const void *b) {
    const struct set *x = a, *y = b;
    return x->evidence < y->evidence ? 1 : x->evidence > y->evidence ? -1 : 0;
}

/* Extends the best sets of each size by one effect, except sets that are much less likely than the
 * best of all (UNLIKELY). */
static void search_once(struct comparison *s, const struct params *base) {
    struct trial *trial = memory_get(HYPOTHESES_MAX, sizeof *trial);
    struct set *branch = memory_get(BRANCHES, sizeof *branch), *from = memory_get(WIDTH, sizeof *from);
    struct set nothing = {.model = *base};
    sets_keep(s, &nothing);
    for (int size = 0; size < GAP_EFFECTS; size++) {
        int chosen = 0;
        qsort(s->set, (size_t)s->sets, sizeof *s->set, by_evidence);
        for (int i = 0; i < s->sets && chosen < effort_of(s).width; i++)
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

static void find_probabilities(struct comparison *s) {
    double sum = -HUGE_VAL;
    for (int i = 0; i < s->sets; i++) sum = log_sum(sum, s->set[i].evidence);
    for (int i = 0; i < s->sets; i++) s->set[i].probability = exp(s->set[i].evidence - sum);
}

/* Makes the model of the best set the reference model, and weighs all sets anew. Returns false if
 * there is no set, or if the best one cannot be fitted. */
static bool better_reference(struct comparison *s) {
    restore_noise(s);
    qsort(s->set, (size_t)s->sets, sizeof *s->set, by_evidence);
    if (!s->sets || !assume(s->d, &s->set[0])) return false;
    take_reference(s, 1.0);
    for (int i = 0; i < s->sets; i++) weigh(s, &s->set[i]);
    qsort(s->set, (size_t)s->sets, sizeof *s->set, by_evidence);
    return true;
}

int sets_place(const struct set *s, int effect) {
    for (int i = 0; i < s->effects; i++)
        if (s->hypothesis[i].effect == effect) return i;
    return -1;
}

bool sets_fit(struct comparison *s, struct set *one) {
    if (!assume(s->d, one)) return false;
    one->model = s->d->model;
    one->log_prior = log_prior(s->d, one);
    linearise(s, one);
    weigh(s, one);
    return acts(one);
}

void sets_search(struct comparison *s, const struct params *base) {
    search_once(s, base);
    for (int round = 0; round < effort_of(s).rounds && better_reference(s); round++) search_once(s, base);
}

bool sets_rank(struct comparison *s) {
    if (!better_reference(s)) return false;
    prefer_limits(s);
    find_probabilities(s);
    return true;
}

static void keep_noise(const struct fit_data *d, struct fit_data *noise) {
    *noise = *d;
    noise->whitener = memory_get((size_t)d->residual->tests, sizeof *noise->whitener);
    memcpy(noise->whitener, d->whitener, (size_t)d->residual->tests * sizeof *noise->whitener);
}

void sets_begin(struct comparison *s, struct diagnosis *d, double spread, bool exact) {
    *s = (struct comparison){.d = d, .exact = exact};
    s->set = memory_get(SETS_MAX, sizeof *s->set);
    s->variance = memory_get((size_t)d->fit.values, sizeof *s->variance);
    keep_noise(&d->fit, &s->fit), keep_noise(&d->held_out, &s->held_out);
    take_reference(s, spread);
}

void sets_end(struct comparison *s) {
    restore_noise(s);
    covariance_free(&s->covariance);
    covariance_free(&s->held_covariance);
    for (int i = 0; i < s->sets; i++) linearised_free(&s->set[i].linear);
    free(s->set);
    free(s->variance);
    free(s->fit.whitener);
    free(s->held_out.whitener);
}
