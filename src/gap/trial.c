#include "trial.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "memory.h"

static const double IDLE = 1e-6;         /* a strength of an effect does nothing if it changes the
                                          * sum of squares by less than this share */
static const double DOUBTLESS_GAIN = 36.0; /* gain in squared white residuals that is beyond doubt:
                                            * z = 6 */
static const double BEND = 0.1;          /* a law counts as proportional if its rms deviation from
                                          * proportionality is less than this share of the rms
                                          * change that the effect makes */
static const double SHORTEST_STEP = 0.1; /* as long as the machine would be impossible, the base's
                                          * linear step is halved, down to about this share of the
                                          * full step; if that does not help, the base stays where
                                          * it is */
enum { SCREEN_SETS = 1, SCREEN_BENT = 3, TRIAL_SETS = 6, POLISH_SETS = 8 };

enum { WEAK, TYPICAL, STARTS = 7 };
/* strengths at which a trial may start, as multiples of the typical strength. Several are tried,
 * because some effects, such as a rate limit, have no gradient at strengths where they act always
 * or never */
static const double start_strength[STARTS] = {[WEAK] = 0.1, [TYPICAL] = 1.0, -0.1, -1.0, 0.3, 10.0, -10.0};

/* True if the effect is proportional to its strength. without, weak, typical: white residuals
 * without the effect, with a weak one and with a typical one. */
static bool in_proportion(int values, const double *without, const double *weak, const double *typical) {
    double bend = 0.0, square = 0.0;
    for (int i = 0; i < values; i++) {
        double change = typical[i] - without[i], straight = start_strength[TYPICAL] / start_strength[WEAK] * (weak[i] - without[i]);
        bend += (change - straight) * (change - straight), square += change * change;
    }
    return bend < BEND * BEND * square;
}

/* The best of a trial's possible starts, so far. */
struct start {
    struct params *model;
    double square;      /* sum of squared white residuals with the linear part at its optimum;
                         * HUGE_VAL: there is no start yet */
    /* raw: raw residuals of the best start, NULL if they are not computed; other: work space for
     * the residuals of the next one */
    double *raw;
    double *other;
    bool bent;          /* the law is not proportional to the effect's strength */
};

/* Keeps a start if its sum of squares, with the linear part at its optimum, is the least so far. */
static void keep_better(struct start *s, const struct params *model, double square) {
    if (!(square < s->square)) return;
    double *raw = s->raw;
    s->raw = s->other, s->other = raw;
    s->square = square, *s->model = *model;
}

/* Tries a start with this strength of the effect and keeps it if it is the best so far. white: set
 * to the start's white residuals. without: sum of squares without the effect. */
static void try_start(const struct diagnosis *d, const struct hypothesis *h, const struct params *base, double strength, double without,
                      const struct linear_part *linear, double *white, struct start *s) {
    struct params model = *base;
    if (!hypothesis_at(h, strength, &model)) return;
    double square = fit_start(&d->fit, &model, h->variables, h->variable, linear, s->other, white);
    /* an effect that never acts, such as a rate limit that is not reached, has no gradient, so no
     * fit can start there */
    bool idle = fabs(square - without) < IDLE * without;
    if (!idle) keep_better(s, &model, square);
}

double trial_ahead(const struct trial *best, const struct trial *t) {
    bool each = best->hypothesis->pattern == PATTERN_EACH || t->hypothesis->pattern == PATTERN_EACH;
    return (each ? best->gain - t->gain : trial_rise(best) - trial_rise(t)) + best->held_gain - t->held_gain;
}

double trial_rise(const struct trial *t) { return t->gain + DIAGNOSIS_PENALTY * t->parameters; }

static void rate(const struct diagnosis *d, struct trial *t, double square, const double *std) {
    const struct hypothesis *h = t->hypothesis;
    t->square = square;
    t->parameters = 0.0;
    memcpy(t->std, std, (size_t)h->variables * sizeof *t->std);
    for (int i = 0; i < h->variables; i++) t->parameters += fmax(1.0 - pow(std[i] * h->variable[i].prior_inverse_std, 2.0), 0.0);
    t->gain = d->square - square - DIAGNOSIS_PENALTY * t->parameters - (h->pattern >= 0 ? 2.0 * log(LEGS) : 0.0);
}

/* Finds the best start of a hypothesis. The effect's configured values, if any, are one of the
 * starts. If the law is proportional, its best strength is computed; otherwise all strengths are
 * tried, and the law counts as nonlinear. from: a trial of the effect with all legs alike, or NULL;
 * a hypothesis with a value for each leg starts from this trial, unless the configuration has the
 * effect. room: work space for three sets of residuals. Returns false if there is no start. */
static bool best_start(const struct diagnosis *d, const struct hypothesis *h, const struct params *base, const struct trial *from,
                       const struct linear_part *linear, double *room, struct start *s) {
    int values = d->fit.values;
    double *none = room, *weak = none + values, *white = weak + values;
    bool given = d->given->effects[h->effect].on;
    *s->model = *base;
    if (h->pattern == PATTERN_EACH && from && !given) {
        s->model->effects[h->effect] = from->model.effects[h->effect];
        s->raw = NULL;
        return true;
    }
    double without = fit_start(&d->fit, base, 0, NULL, linear, s->other, none);
    if (given) {
        struct params model = *base;
        for (int i = 0; i < h->variables; i++) variable_set(&h->variable[i], &model, variable_get(&h->variable[i], &model));
        keep_better(s, &model, fit_start(&d->fit, &model, h->variables, h->variable, linear, s->other, weak));
    }
    memcpy(weak, none, (size_t)values * sizeof *weak);
    for (int i = 0; i < STARTS; i++) {
        memcpy(white, none, (size_t)values * sizeof *white);
        try_start(d, h, base, start_strength[i], without, linear, i == WEAK ? weak : white, s);
        if (i != TYPICAL || !in_proportion(values, none, weak, white)) continue;
        for (int a = 0; a < values; a++) white[a] -= none[a];
        try_start(d, h, base, fit_share(&d->fit, none, white, linear), without, linear, weak, s);
        return s->square < HUGE_VAL;
    }
    s->bent = true;
    return s->square < HUGE_VAL;
}

/* Makes the base of a trial. This is the current model, in which variables parallel to the
 * hypothesis have their given values, or, with as_found, those of the last fit. Fills in box and
 * priors of all variables, relative to this base. Returns true if the base differs from the current
 * model. */
static bool without_parallel(const struct diagnosis *d, const struct hypothesis *h, bool as_found, struct params *base, double *min,
                             double *max, struct fit_prior *prior) {
    bool changed = false;
    *base = d->model;
    for (int i = 0; i < d->variables; i++) {
        struct variable v_drawn = d->variable[i], *v = &v_drawn;
        enum parallel how = v->base ? hypothesis_parallel(h, v) : PARALLEL_NOT;
        bool parallel = how == PARALLEL_SAME;
        double value = variable_get(v, parallel && !as_found ? d->given : &d->model);
        if (how == PARALLEL_DRAWN) variable_add_prior(v);
        prior[i] = (struct fit_prior){v->prior_inverse_std, value - v->neutral};
        if (parallel) variable_set(v, base, value);
        min[i] = parallel ? 0.0 : v->min - value, max[i] = parallel ? 0.0 : v->max - value;
        changed = changed || (parallel && !as_found);
    }
    return changed;
}

/* True if a value is at an end of its range, unless this end is the neutral value. */
static bool at_bound(const struct trial *t) {
    bool bound = false;
    for (int i = 0; i < t->hypothesis->variables; i++) {
        const struct variable *v = &t->hypothesis->variable[i];
        double value = variable_get(v, &t->model), margin = 1e-6 * (v->max - v->min);
        bool end = value <= v->min + margin || value >= v->max - margin;
        bound = bound || (end && fabs(value - v->neutral) > margin);
    }
    return bound;
}

/* Sets the variables of the model, except those parallel to the hypothesis, to their values in
 * `from` plus x. The step is shortened if the machine would become impossible: a linear step may
 * make a mass negative. */
static void move_others(const struct diagnosis *d, const struct hypothesis *h, const struct params *from, const double *x,
                        struct params *model) {
    bool possible = false;
    for (double share = 1.0; !possible; share = share > SHORTEST_STEP ? 0.5 * share : 0.0) {
        for (int i = 0; i < d->variables; i++) {
            const struct variable *v = &d->variable[i];
            if (v->base && hypothesis_parallel(h, v) == PARALLEL_SAME) continue;
            variable_set(v, model, variable_get(v, from) + share * x[i]);
        }
        possible = !(share > 0.0) || hypothesis_possible(model);
    }
}

/* Fits a hypothesis from its best start, or goes on with an earlier trial. */
static void try_one(const struct diagnosis *d, const struct hypothesis *h, const struct trial *from, int sets, struct trial *t) {
    double min[FIT_VARIABLES], max[FIT_VARIABLES], x[FIT_VARIABLES] = {0};
    size_t values = (size_t)d->fit.values;
    double *own = memory_get(6 * values, sizeof *own);
    struct fit_prior prior[FIT_VARIABLES];
    struct linear_part linear = {.n = d->variables,
                                 .raw = d->raw,
                                 .column = d->column,
                                 .gram = d->gram,
                                 .min = min,
                                 .max = max,
                                 .prior = prior,
                                 .x = x,
                                 .worth = TRIAL_LEAST};
    struct params base;
    struct start start = {.model = &t->model, .square = HUGE_VAL, .raw = own + values, .other = own + 2 * values};
    bool again = t->ok;
    t->ok = false;

    if (without_parallel(d, h, t->as_found, &base, min, max, prior)) {
        linear.raw = own;
        if (!fit_raw(&d->fit, &base, own)) goto end;
    }
    if (again) move_others(d, h, &base, x, &t->model);
    else if (!best_start(d, h, &base, from, &linear, own + 3 * values, &start)) goto end;

    const double *raw = again ? NULL : start.raw;
    struct fit_result r = fit_model(&d->fit, &t->model, h->variables, h->variable, NULL, &linear, raw, start.bent ? SCREEN_BENT : sets,
                                    NULL);
    if (!r.ok) goto end;
    move_others(d, h, &base, x, &t->model);

    t->ok = true;
    rate(d, t, r.square, r.std);
    /* a trial that gains no more than noise is not evaluated on the held-out cycles; its gain there
     * is assumed to equal that on the fitted ones */
    bool seen = again || t->gain > TRIAL_LEAST;
    t->held_square = seen ? diagnosis_held_square(d, &t->model) : d->held_square - (d->square - t->square);
    t->held_gain = d->held_square - t->held_square;
    t->bound = at_bound(t);
end:
    free(own);
}

bool trial_contradicted(const struct trial *t) {
    return t->ok && !t->polished && t->gain > DOUBTLESS_GAIN && !(t->held_gain > TRIAL_KEPT * t->gain);
}

double trial_sound_gain(const struct trial *t) { return !t->ok ? -HUGE_VAL : trial_contradicted(t) ? 0.0 : t->gain; }

/* Lists the variables that are fitted together with an effect: those of the model that are not
 * parallel to the effect, then the effect's own. place: set to the indices of the model's variables
 * in the model. Returns the number of the model's variables in the list, or -1 if there are more
 * than FIT_VARIABLES variables in all. */
static int list_together(const struct diagnosis *d, const struct hypothesis *h, struct variable v[FIT_VARIABLES],
                         int place[FIT_VARIABLES]) {
    int n = 0;
    for (int i = 0; i < d->variables; i++) {
        const struct variable *b = &d->variable[i];
        enum parallel how = b->base ? hypothesis_parallel(h, b) : PARALLEL_NOT;
        if (how == PARALLEL_SAME) continue;
        v[n] = *b, place[n] = i;
        if (how == PARALLEL_DRAWN) variable_add_prior(&v[n]);
        n++;
    }
    if (n + h->variables > FIT_VARIABLES) return -1;
    memcpy(v + n, h->variable, (size_t)h->variables * sizeof *v);
    return n;
}

/* Finds the columns of the base variables at a trial that is near its optimum. The first n of v are
 * variables of the model. Columns that the effect does not change are those of the model; the
 * others are computed in `room`. Returns false if the model cannot make the measured motion. */
static bool base_columns(const struct diagnosis *d, const struct trial *t, const double *raw, int n, const struct variable *v,
                         const int *place, double *room, const double **known) {
    size_t values = (size_t)d->fit.values;
    int base = 0;
    for (; base < n && v[base].base; base++) /* base variables come first */
        if (!(v[base].equations & hypothesis_equations(t->hypothesis))) known[base] = d->column + (size_t)place[base] * values;
    if (!fit_columns(&d->fit, &t->model, raw, base, v, known, room)) return false;
    for (int i = 0; i < base; i++)
        if (!known[i]) known[i] = room + (size_t)i * values;
    return true;
}

/* Fits base and effect together. near: the trial is near its optimum; the base's columns are then
 * computed once. If there are too many variables or the columns cannot be computed, the trial stays
 * as it is. */
static void fit_together(const struct diagnosis *d, bool near, struct trial *t) {
    struct variable v[FIT_VARIABLES];
    const double *known[FIT_VARIABLES] = {NULL};
    const struct hypothesis *h = t->hypothesis;
    int place[FIT_VARIABLES], before = list_together(d, h, v, place);
    if (before < 0) return;
    size_t values = (size_t)d->fit.values;
    double *raw = memory_get(values, sizeof *raw), *room = memory_get(near ? (size_t)before * values : 0, sizeof *room);
    bool found = !near || (fit_raw(&d->fit, &t->model, raw) && base_columns(d, t, raw, before, v, place, room, known));
    struct fit_result r = {0};
    if (found) r = fit_model(&d->fit, &t->model, before + h->variables, v, known, NULL, near ? raw : NULL, POLISH_SETS, NULL);
    free(raw);
    free(room);
    if (!found) return;
    t->ok = r.ok;
    if (!t->ok) return;
    rate(d, t, r.square, r.std + before);
    t->held_square = diagnosis_held_square(d, &t->model);
    t->held_gain = d->held_square - t->held_square;
    t->polished = true;
    t->bound = at_bound(t);
}

/* A contradicted trial is also fitted from the current model, with the effect at its configured
 * values, or, without these, at its typical ones. The better result counts. */
void trial_polish(const struct diagnosis *d, struct trial *t) {
    struct trial anew = *t;
    double unmoved[FIT_VARIABLES] = {0};
    int effect = t->hypothesis->effect;
    bool given = d->given->effects[effect].on;
    if (given) anew.model.effects[effect] = d->given->effects[effect];
    anew.ok = trial_contradicted(t) && (given || hypothesis_at(t->hypothesis, start_strength[TYPICAL], &anew.model));
    if (anew.ok) {
        move_others(d, t->hypothesis, &d->model, unmoved, &anew.model);
        fit_together(d, false, &anew);
    }
    fit_together(d, !trial_contradicted(t), t);
    if (anew.polished && !(t->ok && t->square < anew.square)) *t = anew;
}

/* True if the hypothesis is a friction that replaces a constant force of the base, and its value
 * for one direction is zero. The difference between the directions can imitate only a constant
 * force that is no larger than the friction, so the true force may then be larger. */
static bool one_direction(const struct diagnosis *d, const struct trial *t) {
    const struct hypothesis *h = t->hypothesis;
    bool constant = false, none = false;
    for (int i = 0; i < d->variables; i++)
        constant = constant || (d->variable[i].offset == offsetof(struct params, axis.force_offset_n) &&
                                hypothesis_parallel(h, &d->variable[i]) == PARALLEL_SAME);
    for (int i = 0; i < h->variables; i++)
        none = none ||
               fabs(variable_get(&h->variable[i], &t->model) - h->variable[i].neutral) <= 1e-6 * (h->variable[i].max - h->variable[i].min);
    return constant && none;
}

/* Tries the hypothesis once more with the constant force kept in the base, and takes that trial if
 * it explains clearly more. */
static void try_beside_constant(const struct diagnosis *d, const struct trial *from, struct trial *t) {
    struct trial beside = {.hypothesis = t->hypothesis, .as_found = true};
    if (!one_direction(d, t)) return;
    try_one(d, t->hypothesis, from, SCREEN_SETS, &beside);
    if (beside.ok && beside.gain > t->gain + DOUBTLESS_GAIN) *t = beside;
}

void trial_screen(const struct diagnosis *d, const struct hypothesis *h, const struct trial *alike, struct trial *t) {
    *t = (struct trial){.hypothesis = h};
    try_one(d, h, alike, SCREEN_SETS, t);
    if (t->ok) try_beside_constant(d, alike, t);
}

void trial_fit(const struct diagnosis *d, struct trial *t) { try_one(d, t->hypothesis, NULL, TRIAL_SETS - SCREEN_SETS, t); }
