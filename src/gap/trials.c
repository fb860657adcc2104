#include "trials.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "memory.h"
#include "parallel.h"
#include "sort.h"

static const double WORTH = 0.1; /* a trial is fitted further if its gain after the first steps
                                  * exceeds this share of the best trial's */
static const double NEAR_SHARE = 0.9; /* a trial is polished, too, if its gain before polishing
                                       * exceeds this share of the best one's, because polishing may
                                       * change their order */
static const double FAR_SHARE = 0.4; /* on a platform, a trial with less evidence than this share of
                                      * the best one's is not polished. An effect that is just named
                                      * has an evidence of GAIN_MIN, and its rivals have at least
                                      * 0.43 of that (GAIN_MIN and RIVAL_GAIN of search.c) */
static const double LEAST_EVIDENCE = 12.0; /* on a platform, a trial with less evidence than this is
                                            * not polished, either: GAIN_MIN less RIVAL_GAIN of
                                            * search.c, the least evidence of a rival */
static const double HOPELESS = 100.0; /* a trial is not polished if its sum of squares exceeds this
                                       * multiple of the least sum among the polished trials that
                                       * have no value at a bound, unless the held-out cycles
                                       * contradict the trial. The largest factor by which polishing
                                       * has lowered a sum of squares is 30 */
enum { FINALISTS = 5, TRIED_ONE_LEG = 8, TRIED_EACH = 3 };

struct batch {
    const struct diagnosis *d;
    const struct hypothesis *hypothesis[HYPOTHESES_MAX];
    const struct batch *before;     /* batch whose trials with all legs alike serve as starts, or
                                     * NULL */
    struct trial *trial;
    int count;
    double worth;             /* a trial is fitted further if its gain after the first steps exceeds
                               * this */
};

static const struct trial *alike(const struct batch *before, const struct hypothesis *h) {
    for (const struct batch *b = before; b; b = b->before)
        for (int i = 0; i < b->count; i++)
            if (b->hypothesis[i]->effect == h->effect && b->hypothesis[i]->pattern == PATTERN_ALL && b->trial[i].ok) return &b->trial[i];
    return NULL;
}

static void screen(void *context, int i) {
    struct batch *batch = context;
    trial_screen(batch->d, batch->hypothesis[i], alike(batch->before, batch->hypothesis[i]), &batch->trial[i]);
}

static void fit_on(void *context, int i) {
    struct batch *batch = context;
    if (batch->trial[i].ok && batch->trial[i].gain > batch->worth) trial_fit(batch->d, &batch->trial[i]);
}

/* Takes the first step of each trial of a batch, or, with a nonlinear law, several steps. Then fits
 * the trials near the best one to the end. */
static void try_all(int threads, struct batch *batch) {
    double best = 0.0;
    parallel_run(threads, batch->count, screen, batch);
    for (const struct batch *b = batch; b; b = b->before)
        for (int i = 0; i < b->count; i++) best = fmax(best, trial_sound_gain(&b->trial[i]));
    batch->worth = fmax(WORTH * best, TRIAL_LEAST);
    parallel_run(threads, batch->count, fit_on, batch);
}

/* Sorts the legs by their residuals, largest first. */
static void rank_legs(const struct diagnosis *d, int leg[LEGS]) {
    double square[LEGS] = {0}, *white = memory_get((size_t)d->fit.values, sizeof *white);
    memcpy(white, d->raw, (size_t)d->fit.values * sizeof *white);
    for (int i = 0; i < d->fit.residual->tests; i++) {
        residual_row *row = (residual_row *)white + i;
        whiten(&d->fit.whitener[i], *row);
        for (int k = 0; k < LEGS; k++) square[k] += fit_square(RESIDUALS * RESIDUAL_SIZE, (*row)[k][0]);
    }
    free(white);
    for (int k = 0; k < LEGS; k++) {
        int place = k;
        for (; place > 0 && square[k] > square[leg[place - 1]]; place--) leg[place] = leg[place - 1];
        leg[place] = k;
    }
}

/* True if fewer than `many` trials of the batch gain more than the best trial of the effect. */
static bool promising(const struct batch *batch, int effect, int many) {
    double gain = -INFINITY;
    int better = 0;
    for (int i = 0; i < batch->count; i++)
        if (batch->hypothesis[i]->effect == effect) gain = fmax(gain, trial_sound_gain(&batch->trial[i]));
    for (int i = 0; i < batch->count; i++) better += trial_sound_gain(&batch->trial[i]) > gain;
    return better < many;
}

/* True if the base has a value of this effect for each leg. A hypothesis with a single value for
 * all legs then replaces the base's values, and therefore looks worse than it is. */
static bool each_in_base(const struct diagnosis *d, int effect) {
    bool each = false;
    for (int i = 0; i < d->variables; i++)
        each = each || (d->variable[i].base && d->variable[i].effect == effect && d->variable[i].leg >= 0);
    return each;
}

/* Finds the leg, in a trial with a value for each leg, whose value differs most certainly from the
 * given one; -1: no value differs. A value at its bound is certain. */
static int single_out(const struct diagnosis *d, const struct trial *each) {
    const struct hypothesis *h = each->hypothesis;
    bool given = d->given->effects[h->effect].on;
    double surest = 0.0;
    int leg = -1;
    for (int i = 0; i < h->variables; i++) {
        const struct variable *v = &h->variable[i];
        double change = fabs(variable_get(v, &each->model) - (given ? variable_get(v, d->given) : v->neutral));
        double z = each->std[i] > 0.0 ? change / each->std[i] : change > 0.0 ? HUGE_VAL : 0.0;
        if (v->leg >= 0 && !effect_table[v->effect]->keys[v->key].shapes_law && z > surest) surest = z, leg = v->leg;
    }
    return leg;
}

static bool is_in(const struct batch *batch, const struct hypothesis *h) {
    bool in = false;
    for (int i = 0; i < batch->count; i++) in = in || batch->hypothesis[i] == h;
    return in;
}

/* Lists, for each trial with a value for each leg, the hypothesis of the same effect in the one leg
 * that stands out. */
static void list_single(const struct diagnosis *d, const struct batch *before, struct batch *batch) {
    for (int i = 0; i < before->count; i++) {
        const struct trial *each = &before->trial[i];
        if (!each->ok || each->hypothesis->pattern != PATTERN_EACH || !(each->gain > before->worth)) continue;
        int leg = single_out(d, each);
        for (int j = 0; j < d->hypotheses && leg >= 0; j++) {
            const struct hypothesis *h = &d->hypothesis[j];
            if (h->effect == each->hypothesis->effect && h->pattern == leg && !is_in(before, h)) batch->hypothesis[batch->count++] = h;
        }
    }
}

static int by_gain(const void *a, const void *b) {
    const struct trial *x = a, *y = b;
    double p = trial_sound_gain(x), q = trial_sound_gain(y);
    if (p == q) p = x->gain, q = y->gain; /* both trials are contradicted, or have equal gains */
    return p < q ? 1 : p > q ? -1 : 0;
}

/* Order of trials for qsort: polished ones first, by their evidence. Held-out cycles count as much
 * as fitted ones, so that more parameters alone gain nothing. */
static int by_evidence(const void *a, const void *b) {
    const struct trial *x = a, *y = b;
    bool first = x->ok && x->polished, second = y->ok && y->polished;
    if (!first || !second) return first != second ? second - first : by_gain(a, b);
    double p = trial_evidence(x), q = trial_evidence(y);
    return p < q ? 1 : p > q ? -1 : 0;
}

/* Returns the first listed trial of an effect, which has its best choice of legs; NULL if none is
 * listed. */
static const struct trial *best_pattern(const struct trial *finalist, int finalists, int effect) {
    for (int i = 0; i < finalists; i++)
        if (finalist[i].hypothesis->effect == effect) return &finalist[i];
    return NULL;
}

/* Gain on the fitted cycles that most trials share, whatever their effect: the median gain. It is
 * above zero if the linear steps of the base are wrong, as beside backlash. Backlash depends on all
 * forces, so the residuals are not linear within a step. */
static double shared_gain(const struct trial *trial, int count) {
    double *gain = memory_get((size_t)count, sizeof *gain);
    int n = 0;
    for (int i = 0; i < count; i++)
        if (trial[i].ok) gain[n++] = trial[i].gain;
    sort_ascending(n, gain);
    double middle = n ? fmax(gain[n / 2], 0.0) : 0.0;
    free(gain);
    return middle;
}

/* Copies the first trial, in order of gain, that may be added. Returns false if there is none. */
static bool first_sound(const struct trial *trial, int count, struct trial *sound) {
    for (int i = 0; i < count; i++) {
        if (!trial[i].ok || trial[i].bound || trial_contradicted(&trial[i])) continue;
        *sound = trial[i];
        return true;
    }
    return false;
}

/* True if a trial has too little evidence to become the best one or its rival. Never true on a
 * single leg, where polishing takes little time and sets of effects are searched widely. best: the
 * first sound trial. */
static bool is_far(const struct diagnosis *d, const struct trial *best, const struct trial *t) {
    if (params_legs(d->given) == 1) return false;
    bool each = t->hypothesis->pattern == PATTERN_EACH;
    double evidence = trial_rise(best) + best->held_gain;
    return trial_ahead(best, t) > (1.0 - FAR_SHARE) * evidence || (each ? t->gain : trial_rise(t)) + t->held_gain < LEAST_EVIDENCE;
}

/* Polishes trials one after the other, but for hopeless ones. */
static void polish(const struct diagnosis *d, struct trial *trial, int count) {
    double least = HUGE_VAL; /* sum of squares of the best polished trial */
    for (int i = 0; i < count; i++) {
        struct trial *t = &trial[i];
        bool hopeless = t->square > HOPELESS * least && !trial_contradicted(t);
        if (!t->ok || !(trial_rise(t) > 0.0) || hopeless) continue;
        trial_polish(d, t);
        if (t->ok && t->polished && !t->bound) least = fmin(least, t->square);
    }
}

/* Polishes the finalists, each with all threads, and sorts all trials, the best first. Finalists
 * are chosen from the best few effects that are not far from the best one: for each, the trial with
 * the best choice of legs, and all trials whose gain is near that of this trial. A contradicted
 * trial is a finalist if its gain exceeds `worth` by more than twice shared_gain(), and if
 * TRIAL_KEPT of its gain exceeds the gain of its effect's first finalist. worth: gain above which
 * trials were fitted further. */
static void finish(const struct diagnosis *d, double worth, struct trial *trial, int count) {
    struct trial *finalist = memory_get((size_t)count, sizeof *finalist);
    int effects = 0, finalists = 0, others = 0;
    qsort(trial, (size_t)count, sizeof *trial, by_gain);
    struct trial *sound = memory_get(1, sizeof *sound);
    bool some = first_sound(trial, count, sound);
    double rise = trial_rise(&trial[0]), shared = shared_gain(trial, count);
    for (int i = 0; i < count; i++) {
        const struct trial *best = best_pattern(finalist, finalists, trial[i].hypothesis->effect);
        bool rises = trial[i].hypothesis->pattern != PATTERN_EACH && trial_rise(&trial[i]) > NEAR_SHARE * rise;
        /* one value for all legs is a special case of a value for each leg, and may be the whole
         * effect, whatever the first steps showed */
        bool limit = best && best->hypothesis->pattern == PATTERN_EACH && trial[i].hypothesis->pattern == PATTERN_ALL;
        bool first = trial_fitted_gain(&trial[i]) > TRIAL_LEAST && (effects < FINALISTS || rises) && !(some && is_far(d, sound, &trial[i]));
        bool near = best ? limit || trial[i].gain > NEAR_SHARE * best->gain : first;
        bool anew = trial[i].gain > worth + 2.0 * shared && (!best || TRIAL_KEPT * trial[i].gain > best->gain);
        bool chosen = trial[i].ok && (trial_contradicted(&trial[i]) ? anew : near);
        effects += chosen && !best;
        if (chosen) finalist[finalists++] = trial[i];
        else trial[others++] = trial[i];
    }
    memmove(trial + finalists, trial, (size_t)others * sizeof *trial);
    memcpy(trial, finalist, (size_t)finalists * sizeof *trial);
    polish(d, trial, finalists);
    qsort(trial, (size_t)count, sizeof *trial, by_evidence);
    free(sound);
    free(finalist);
}

int trials_run(const struct diagnosis *d, struct trial *trial) {
    /* copy of the diagnosis that uses one thread, for trials that run in parallel */
    struct diagnosis *alone = memory_get(1, sizeof *alone);
    int threads = d->fit.threads;
    *alone = *d;
    alone->fit.threads = alone->held_out.threads = 1;
    struct batch *first = memory_get(1, sizeof *first), *second = memory_get(1, sizeof *second), *third = memory_get(1, sizeof *third);
    int leg[LEGS];
    first->d = second->d = third->d = alone;
    for (int i = 0; i < d->hypotheses; i++)
        if (d->hypothesis[i].pattern == PATTERN_ALL) first->hypothesis[first->count++] = &d->hypothesis[i];
    first->trial = trial;
    try_all(threads, first);
    rank_legs(d, leg);
    for (int i = 0; i < d->hypotheses; i++) {
        const struct hypothesis *h = &d->hypothesis[i];
        bool tried = h->pattern == leg[0] || (h->pattern == leg[1] && promising(first, h->effect, TRIED_ONE_LEG)) ||
                     (h->pattern == PATTERN_EACH && (promising(first, h->effect, TRIED_EACH) ||
                                                     hypothesis_equations(h) == EQUATIONS_FORCE || each_in_base(d, h->effect)));
        if (tried) second->hypothesis[second->count++] = h;
    }
    second->trial = trial + first->count;
    second->before = first;
    try_all(threads, second);
    list_single(d, second, third);
    third->trial = second->trial + second->count;
    third->before = second;
    try_all(threads, third);
    int count = first->count + second->count + third->count;
    finish(d, third->worth, trial, count);
    free(first);
    free(second);
    free(third);
    free(alone);
    return count;
}
