#include "diagnose.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base.h"
#include "machine.h"
#include "memory.h"

static const double IDLE = 1e-6;         /* relative change of the squares */
static const double PENALTY = 8.0;       /* of white squares, a parameter: ln of the
                                          * number of values, about */
static const double WORTH = 0.1;         /* of the best one's gain after the first steps, and */
static const double WORTH_LEAST = 4.0;   /* so much: a trial is fitted on; beyond the 1 that each
                                          * parameter gains by chance: it is polished */
static const double SURE = 36.0;         /* gained beyond doubt, z = 6 */
static const double RIDGE = 1e-4;        /* on the diagonal of the columns' products, relative
                                          * (Levenberg 1944): where the base is moved linearly,
                                          * noise moves it by 50 deviations of a column at most */
static const double KEPT = 0.5;          /* of a gain, by the cycles held out: else it is
                                          * contradicted */
static const double BEND = 0.1;          /* of a signature: a law that bends less is taken
                                          * for one in proportion */
static const double SHORTEST_STEP = 0.1; /* of the base's linear one, before none is taken */
static const double NEAR = 0.9;          /* of the gain with the base moved linearly:
                                          * polishing may turn the order */
static const double NOISE_SQUARE = 0.8;  /* mean square of white noise at most: not 1, as a third of
                                          * the variance is what no model meets (BASE_ERROR), and a
                                          * half of the cycles' scatter is motion, which the
                                          * equations follow; 0.4 to 0.6 is measured */
static const double SCATTER = 6.0;       /* of that mean, in standard deviations */
static const double LAW_SIGMAS = 4.0;    /* of its law_error that an effect may leave */
static const double FEW_CYCLES = 10.0;   /* mean square of Student's t of two or three cycles, which
                                          * has none */
enum { POLISH_ITERATIONS = 5, FINALISTS = 5 };
enum {
    SCREEN_ITERATIONS = 1,
    SCREEN_BENT = 3,
    TRIAL_ITERATIONS = 6,
    BASE_ITERATIONS = 6,
    THREADS_MAX = 16,
    TRIED_ONE_LEG = 8,
    TRIED_EACH = 3
};

static double held_square(const struct diagnosis *d, const struct params *model) {
    double *white = memory_get((size_t)d->held_out.values, sizeof *white), square = INFINITY;
    if (fit_residual(&d->held_out, model, white)) square = fit_square(d->held_out.values, white);
    free(white);
    return square;
}

/* Of each row held out the square by which the laws of the effects there are may be off. */
static double *law_errors(const struct diagnosis *d) {
    size_t values = (size_t)d->held_out.values;
    double *sum = memory_get(values, sizeof *sum), *part = memory_get(values, sizeof *part);
    for (int e = 0; effect_table[e]; e++) {
        if (!(d->given->effects[e].on || d->found[e]) || !fit_part(&d->held_out, &d->model, e, part)) continue;
        for (size_t i = 0; i < values; i++) sum[i] += pow(effect_table[e]->law_error * part[i], 2.0);
    }
    free(part);
    return sum;
}

double diagnosis_law_error(const struct diagnosis *d) {
    double *error = law_errors(d), sum = 0.0;
    for (int i = 0; i < d->held_out.values; i++) sum += error[i];
    free(error);
    return sum;
}

/* Mean square of noise over its deviation, where that is known from so many cycles' scatter alone
 * (Student's t); 0 cycles: from all samples. */
static double student(int cycles) { return !cycles ? 1.0 : cycles > 3 ? (cycles - 1.0) / (cycles - 3.0) : FEW_CYCLES; }

/* What noise makes of a weighted sum of white squares, beyond doubt: from the sums of its weights
 * and of their squares. */
static double noise_at_most(double weights, double squares) { return NOISE_SQUARE * weights + SCATTER * sqrt(2.0 * squares); }

double diagnosis_noise(const struct diagnosis *d) {
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < d->odd.tests; i++) {
        double one = student(d->odd.test[i].spectrum.cycles);
        sum += one * d->held_out.whitener[i].values, squares += one * one * d->held_out.whitener[i].values;
    }
    return noise_at_most(sum, squares);
}

/* Weights: the inverse of a row's variance, laws in it, to this power. */
static double weigh(int rows, const double *white, const double *noise, const double *law, double power) {
    double left = 0.0, laws = 0.0, sum = 0.0, squares = 0.0;
    for (int i = 0; i < rows; i++) {
        double doubt = LAW_SIGMAS * LAW_SIGMAS * law[i], weight = noise[i] > 0.0 ? pow(1.0 + doubt, -power) : 0.0;
        left += weight * white[i] * white[i], laws += weight * doubt;
        sum += weight * noise[i], squares += pow(weight * noise[i], 2.0);
    }
    return left / (noise_at_most(sum, squares) + laws);
}

double diagnosis_weigh(int rows, const double *white, const double *noise, const double *law) {
    return fmax(weigh(rows, white, noise, law, 1.0), weigh(rows, white, noise, law, 2.0));
}

double diagnosis_beyond_laws(const struct diagnosis *d) {
    enum { ROWS = sizeof(residual_row) / sizeof(double) };
    size_t values = (size_t)d->held_out.values;
    double *law = law_errors(d), *white = memory_get(values, sizeof *white), *noise = memory_get(values, sizeof *noise);
    for (int i = 0; i < d->held_out.values; i++) {
        int row = i % ROWS, leg = row / RESIDUAL_SIZE / RESIDUALS, kind = row / RESIDUAL_SIZE % RESIDUALS;
        bool evaluated = d->held_out.whitener[i / ROWS].inverse[leg][row % RESIDUAL_SIZE][kind][kind] > 0.0;
        noise[i] = evaluated ? student(d->odd.test[i / ROWS].spectrum.cycles) : 0.0;
    }
    bool moves = fit_residual(&d->held_out, &d->model, white);
    double beyond = moves ? diagnosis_weigh(d->held_out.values, white, noise, law) : (double)INFINITY;
    free(law);
    free(white);
    free(noise);
    return beyond;
}

int diagnosis_init(struct diagnosis *d, const struct params *given, const struct recording *recording, struct error *error) {
    *d = (struct diagnosis){.given = given, .model = *given};
    int status = residual_prepare(&d->even, recording, CYCLES_EVEN, error);
    if (!status) status = residual_prepare(&d->odd, recording, CYCLES_ODD, error);
    if (status) return status;
    fit_data_init(&d->fit, &d->even, given);
    fit_data_init(&d->held_out, &d->odd, given);
    d->variables = base_variables(given, d->even.parts, d->variable);
    d->column = memory_get((size_t)FIT_VARIABLES * (size_t)d->fit.values, sizeof *d->column);
    d->gram = memory_get((size_t)FIT_VARIABLES * FIT_VARIABLES, sizeof *d->gram);
    d->raw = memory_get((size_t)d->fit.values, sizeof *d->raw);
    d->hypothesis = memory_get(HYPOTHESES_MAX, sizeof *d->hypothesis);
    if (!diagnosis_refit(d, BASE_ITERATIONS))
        return error_set(error, STATUS_USAGE, "the measured lengths are no motion of the machine in the configuration: check geometry");
    return STATUS_OK;
}

void diagnosis_free(struct diagnosis *d) {
    residual_free(&d->even);
    residual_free(&d->odd);
    fit_data_free(&d->fit);
    fit_data_free(&d->held_out);
    free(d->column);
    free(d->gram);
    free(d->raw);
    free(d->hypothesis);
}

bool diagnosis_refit(struct diagnosis *d, int iterations) {
    struct fit_result r = fit_model(&d->fit, &d->model, d->variables, d->variable, NULL, NULL, iterations);
    bool fitted = r.ok && fit_columns(&d->fit, &d->model, d->variables, d->variable, d->column) && fit_raw(&d->fit, &d->model, d->raw);
    if (!fitted) return false;
    fit_gram(d->variables, d->fit.values, d->column, d->gram);
    for (int i = 0; i < d->variables; i++) d->gram[i * d->variables + i] *= 1.0 + RIDGE;
    memcpy(d->std, r.std, sizeof d->std);
    d->square = r.square;
    d->held_square = held_square(d, &d->model);
    d->hypotheses = hypotheses_list(d->given, &d->model, d->found, d->even.parts, d->hypothesis);
    return true;
}

enum start { WEAK, TYPICAL, STARTS = 7 };
/* of the typical effect; a limit is reached always or never but at the strength between */
static const double start_strength[STARTS] = {[WEAK] = 0.1, [TYPICAL] = 1.0, -0.1, -1.0, 0.3, 10.0, -10.0};

/* White residuals without, at the weak and at the typical strength: in proportion? */
static bool in_proportion(int values, const double *without, const double *weak, const double *typical) {
    double bend = 0.0, square = 0.0;
    for (int i = 0; i < values; i++) {
        double change = typical[i] - without[i], straight = start_strength[TYPICAL] / start_strength[WEAK] * (weak[i] - without[i]);
        bend += (change - straight) * (change - straight), square += change * change;
    }
    return bend < BEND * BEND * square;
}

/* A model at this strength of the effect, and its white residuals. The best is the one with which
 * the rest, moved linearly, comes closest. */
static void try_start(const struct diagnosis *d, const struct hypothesis *h, const struct params *base, double strength, double without,
                      const struct linear_part *linear, double *white, double *least, struct params *best) {
    struct params model = *base;
    if (!hypothesis_at(h, strength, &model)) return;
    double square = fit_start(&d->fit, &model, h->variables, h->variable, linear, white);
    /* a limit that is not reached: no way leads out of there */
    bool idle = fabs(square - without) < IDLE * without;
    if (!idle && square < *least) *least = square, *best = model;
}

double trial_rise(const struct trial *t) { return t->gain + PENALTY * t->parameters; }

/* Gain and deviations of a trial from its fit. */
static void rate(const struct diagnosis *d, struct trial *t, double square, const double *std) {
    const struct hypothesis *h = t->hypothesis;
    t->square = square;
    t->parameters = 0.0;
    memcpy(t->std, std, (size_t)h->variables * sizeof *t->std);
    for (int i = 0; i < h->variables; i++) t->parameters += fmax(1.0 - pow(std[i] * h->variable[i].pull, 2.0), 0.0);
    t->gain = d->square - square - PENALTY * t->parameters - (h->shape >= 0 ? 2.0 * log(LEGS) : 0.0);
}

/* The start from which the rest of the model, moved linearly, comes closest; of an effect that is
 * given its own values are one. A law in proportion has its best strength at once; else it is bent.
 * from: the same effect, all legs alike, fitted; or NULL. room: for three residuals. */
static bool best_start(const struct diagnosis *d, const struct hypothesis *h, const struct params *base, const struct trial *from,
                       const struct linear_part *linear, double *room, struct params *best, bool *bent) {
    int values = d->fit.values;
    double least = HUGE_VAL, *none = room, *weak = none + values, *white = weak + values;
    bool given = d->given->effects[h->effect].on;
    *best = *base;
    *bent = false;
    if (h->shape == SHAPE_EACH && from && !given) {
        best->effects[h->effect] = from->model.effects[h->effect];
        return true;
    }
    double without = fit_start(&d->fit, base, 0, NULL, linear, none);
    for (int i = 0; i < h->variables && given; i++) variable_set(&h->variable[i], best, variable_get(&h->variable[i], best));
    if (given) least = fit_start(&d->fit, best, h->variables, h->variable, linear, weak);
    memcpy(weak, none, (size_t)values * sizeof *weak);
    for (int i = 0; i < STARTS; i++) {
        memcpy(white, none, (size_t)values * sizeof *white);
        try_start(d, h, base, start_strength[i], without, linear, i == WEAK ? weak : white, &least, best);
        if (i != TYPICAL || !in_proportion(values, none, weak, white)) continue;
        for (int a = 0; a < values; a++) white[a] -= none[a];
        try_start(d, h, base, fit_share(&d->fit, none, white, linear), without, linear, weak, &least, best);
        return least < HUGE_VAL;
    }
    *bent = true;
    return least < HUGE_VAL;
}

/* The model so far without what is parallel to the hypothesis: that stands at its given value, or
 * as found. Fills the box of the others, and what draws them. */
static bool without_parallel(const struct diagnosis *d, const struct hypothesis *h, bool as_found, struct params *base, double *min,
                             double *max, struct fit_pull *pull) {
    bool changed = false;
    *base = d->model;
    for (int i = 0; i < d->variables; i++) {
        struct variable v_drawn = d->variable[i], *v = &v_drawn;
        enum parallel how = v->base ? hypothesis_parallel(h, v) : PARALLEL_NOT;
        bool parallel = how == PARALLEL_SAME;
        double value = variable_get(v, parallel && !as_found ? d->given : &d->model);
        if (how == PARALLEL_DRAWN) variable_draw(v);
        pull[i] = (struct fit_pull){v->pull, value - v->neutral};
        if (parallel) variable_set(v, base, value);
        min[i] = parallel ? 0.0 : v->min - value, max[i] = parallel ? 0.0 : v->max - value;
        changed = changed || (parallel && !as_found);
    }
    return changed;
}

/* A value at the end of its range that is not the one that adds nothing. */
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

/* The variables of the model so far, moved by x; but for those that stand as given, or are the
 * hypothesis's own number. Only so far as the machine stays one: a linear step may leave a body
 * less than no mass. */
static void move_others(const struct diagnosis *d, const struct hypothesis *h, const struct params *from, const double *x,
                        struct params *model) {
    bool possible = false;
    for (double share = 1.0; !possible; share = share > SHORTEST_STEP ? 0.5 * share : 0.0) {
        for (int i = 0; i < d->variables; i++) {
            const struct variable *v = &d->variable[i];
            if (v->base && hypothesis_parallel(h, v) == PARALLEL_SAME) continue;
            variable_set(v, model, variable_get(v, from) + share * x[i]);
        }
        struct machine machine;
        struct error impossible;
        machine_init(&machine, model);
        possible = !(share > 0.0) || machine_check(&machine, &impossible) == 0;
    }
}

/* From the best start; where it was tried already, on from there. */
static void try_one(const struct diagnosis *d, const struct hypothesis *h, const struct trial *from, int iterations, struct trial *t) {
    double min[FIT_VARIABLES], max[FIT_VARIABLES], x[FIT_VARIABLES] = {0};
    double *own = memory_get(4 * (size_t)d->fit.values, sizeof *own);
    struct fit_pull pull[FIT_VARIABLES];
    struct linear_part linear = {
        .n = d->variables, .raw = d->raw, .column = d->column, .gram = d->gram, .min = min, .max = max, .pull = pull, .x = x};
    struct params base;
    bool again = t->ok, bent = false;
    t->ok = false;

    if (without_parallel(d, h, t->as_found, &base, min, max, pull)) {
        linear.raw = own;
        if (!fit_raw(&d->fit, &base, own)) goto end;
    }
    if (again) move_others(d, h, &base, x, &t->model);
    else if (!best_start(d, h, &base, from, &linear, own + d->fit.values, &t->model, &bent)) goto end;

    struct fit_result r = fit_model(&d->fit, &t->model, h->variables, h->variable, NULL, &linear, bent ? SCREEN_BENT : iterations);
    if (!r.ok) goto end;
    move_others(d, h, &base, x, &t->model);

    t->ok = true;
    rate(d, t, r.square, r.std);
    /* else it is noise, and as much on the cycles held out */
    bool seen = again || t->gain > WORTH_LEAST;
    t->held_square = seen ? held_square(d, &t->model) : d->held_square - (d->square - t->square);
    t->held_gain = d->held_square - t->held_square;
    t->bound = at_bound(t);
end:
    free(own);
}

/* What the base's linear step gained on the fitted cycles is not there on the others: beside this
 * effect the base's columns are others. What a spring does at rest is its stiffness times the shift
 * that the joints cause. */
static bool contradicted(const struct trial *t) { return t->ok && !t->polished && t->gain > SURE && !(t->held_gain > KEPT * t->gain); }

/* What is contradicted has gained nothing yet. */
static double sound_gain(const struct trial *t) { return !t->ok ? -HUGE_VAL : contradicted(t) ? 0.0 : t->gain; }

/* What the linear part promised, made true: base and effect fitted together. near: the trial begins
 * near where it ends, so that the base's columns hardly change on the way. No room for so many
 * variables: the trial stays as it is. */
static void fit_together(const struct diagnosis *d, bool near, struct trial *t) {
    struct variable v[FIT_VARIABLES];
    bool once[FIT_VARIABLES] = {false};
    const struct hypothesis *h = t->hypothesis;
    int n = 0, base;
    for (int i = 0; i < d->variables; i++) {
        const struct variable *b = &d->variable[i];
        enum parallel how = b->base ? hypothesis_parallel(h, b) : PARALLEL_NOT;
        if (how == PARALLEL_SAME) continue;
        once[n] = near && b->base;
        v[n] = *b;
        if (how == PARALLEL_DRAWN) variable_draw(&v[n]);
        n++;
    }
    base = n;
    if (base + h->variables > FIT_VARIABLES) return;
    for (int i = 0; i < h->variables; i++) v[n++] = h->variable[i];
    struct fit_result r = fit_model(&d->fit, &t->model, n, v, once, NULL, POLISH_ITERATIONS);
    t->ok = r.ok;
    if (!t->ok) return;
    rate(d, t, r.square, r.std + base);
    t->held_square = held_square(d, &t->model);
    t->held_gain = d->held_square - t->held_square;
    t->polished = true;
    t->bound = at_bound(t);
}

/* What is contradicted is fitted from the model so far, too, with the effect as it typically is, or
 * as the configuration has it. */
static void polish(const struct diagnosis *d, struct trial *t) {
    struct trial anew = *t;
    double unmoved[FIT_VARIABLES] = {0};
    int effect = t->hypothesis->effect;
    bool given = d->given->effects[effect].on;
    if (given) anew.model.effects[effect] = d->given->effects[effect];
    anew.ok = contradicted(t) && (given || hypothesis_at(t->hypothesis, start_strength[TYPICAL], &anew.model));
    if (anew.ok) {
        move_others(d, t->hypothesis, &d->model, unmoved, &anew.model);
        fit_together(d, false, &anew);
    }
    fit_together(d, true, t);
    if (anew.polished && !(t->ok && t->square < anew.square)) *t = anew;
}

struct crew {
    const struct diagnosis *d;
    const struct hypothesis *hypothesis[HYPOTHESES_MAX];
    const struct crew *before;      /* whose trials are starts, or NULL */
    struct trial *trial;
    int count;
    double worth;                   /* gain after the first steps of those that are fitted on */
    _Atomic int next;
};

/* The trial of the same effect with all legs alike. */
static const struct trial *alike(const struct crew *before, const struct hypothesis *h) {
    for (int i = 0; before && i < before->count; i++)
        if (before->hypothesis[i]->effect == h->effect && before->trial[i].ok) return &before->trial[i];
    return NULL;
}

/* A friction that is stronger in one direction stands for a constant force, but for none that is
 * larger than the friction itself: then one direction has none left. */
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

/* So the constant force stays where it was found, where that explains more. */
static void try_beside_constant(const struct diagnosis *d, const struct trial *from, struct trial *t) {
    struct trial beside = {.hypothesis = t->hypothesis, .as_found = true};
    if (!one_direction(d, t)) return;
    try_one(d, t->hypothesis, from, SCREEN_ITERATIONS, &beside);
    if (beside.ok && beside.gain > t->gain + SURE) *t = beside;
}

static void *screen(void *argument) {
    struct crew *crew = argument;
    for (int i; (i = atomic_fetch_add(&crew->next, 1)) < crew->count;) {
        const struct trial *from = alike(crew->before, crew->hypothesis[i]);
        crew->trial[i] = (struct trial){.hypothesis = crew->hypothesis[i]};
        try_one(crew->d, crew->hypothesis[i], from, SCREEN_ITERATIONS, &crew->trial[i]);
        if (crew->trial[i].ok) try_beside_constant(crew->d, from, &crew->trial[i]);
    }
    return NULL;
}

static void *fit_on(void *argument) {
    struct crew *crew = argument;
    for (int i; (i = atomic_fetch_add(&crew->next, 1)) < crew->count;)
        if (crew->trial[i].ok && crew->trial[i].gain > crew->worth)
            try_one(crew->d, crew->hypothesis[i], NULL, TRIAL_ITERATIONS - SCREEN_ITERATIONS, &crew->trial[i]);
    return NULL;
}

static void run_crew(struct crew *crew, void *(*work_on)(void *), int threads) {
    pthread_t thread[THREADS_MAX];
    int started = 0;
    atomic_store(&crew->next, 0);
    while (started < threads - 1 && started < THREADS_MAX && pthread_create(&thread[started], NULL, work_on, crew) == 0) started++;
    work_on(crew);
    for (int i = 0; i < started; i++) pthread_join(thread[i], NULL);
}

/* One step of each, more where a law is bent; only what comes near the best one then is
 * fitted to its end. */
static void try_all(struct crew *crew, int threads) {
    double best = 0.0;
    run_crew(crew, screen, threads);
    for (int i = 0; crew->before && i < crew->before->count; i++) best = fmax(best, sound_gain(&crew->before->trial[i]));
    for (int i = 0; i < crew->count; i++) best = fmax(best, sound_gain(&crew->trial[i]));
    crew->worth = fmax(WORTH * best, WORTH_LEAST);
    run_crew(crew, fit_on, threads);
}

/* The legs with most to explain, most first. */
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

/* Is the effect among so many that explain most so far? */
static bool promising(const struct crew *crew, int effect, int many) {
    double gain = -INFINITY;
    int better = 0;
    for (int i = 0; i < crew->count; i++)
        if (crew->hypothesis[i]->effect == effect) gain = fmax(gain, sound_gain(&crew->trial[i]));
    for (int i = 0; i < crew->count; i++) better += sound_gain(&crew->trial[i]) > gain;
    return better < many;
}

/* Has the base a value of this effect in each leg? With one number for all legs, which takes their
 * place, it looks worse than it is. */
static bool each_in_base(const struct diagnosis *d, int effect) {
    bool each = false;
    for (int i = 0; i < d->variables; i++)
        each = each || (d->variable[i].base && d->variable[i].effect == effect && d->variable[i].leg >= 0);
    return each;
}

static int by_gain(const void *a, const void *b) {
    const struct trial *x = a, *y = b;
    double p = sound_gain(x), q = sound_gain(y);
    if (p == q) p = x->gain, q = y->gain; /* of two that are contradicted */
    return p < q ? 1 : p > q ? -1 : 0;
}

/* What gains next to nothing is as good as it is. */
static void *polish_next(void *argument) {
    struct crew *crew = argument;
    for (int i; (i = atomic_fetch_add(&crew->next, 1)) < crew->count;)
        if (crew->trial[i].ok && trial_rise(&crew->trial[i]) - crew->trial[i].parameters > WORTH_LEAST) polish(crew->d, &crew->trial[i]);
    return NULL;
}

/* Of what is fitted truly, the cycles held out judge as much as the fitted ones: many parameters
 * cannot win there by their number. */
static int by_evidence(const void *a, const void *b) {
    const struct trial *x = a, *y = b;
    bool first = x->ok && x->polished, second = y->ok && y->polished;
    if (!first || !second) return first != second ? second - first : by_gain(a, b);
    double p = trial_evidence(x), q = trial_evidence(y);
    return p < q ? 1 : p > q ? -1 : 0;
}

/* The first of an effect's trials: its best shape. NULL: none yet. */
static const struct trial *best_shape(const struct trial *finalist, int finalists, int effect) {
    for (int i = 0; i < finalists; i++)
        if (finalist[i].hypothesis->effect == effect) return &finalist[i];
    return NULL;
}

/* Best first; the best few effects, each in its best shape and those that come near it, and what is
 * contradicted come first, polished. */
static void finish(struct crew *crew, struct trial *trial, int count, int threads) {
    struct trial *finalist = memory_get((size_t)count, sizeof *finalist);
    int effects = 0, finalists = 0, others = 0;
    qsort(trial, (size_t)count, sizeof *trial, by_gain);
    double rise = trial_rise(&trial[0]);
    for (int i = 0; i < count; i++) {
        const struct trial *best = best_shape(finalist, finalists, trial[i].hypothesis->effect);
        bool rises = trial[i].hypothesis->shape != SHAPE_EACH && trial_rise(&trial[i]) > NEAR * rise;
        /* a limit of each leg's own: it may be all there is, whatever the first steps said */
        bool limit = best && best->hypothesis->shape == SHAPE_EACH && trial[i].hypothesis->shape == SHAPE_ALL;
        bool near = best ? limit || trial[i].gain > NEAR * best->gain : effects < FINALISTS || rises;
        bool anew = trial[i].gain > crew->worth && (!best || KEPT * trial[i].gain > best->gain);
        bool chosen = trial[i].ok && (contradicted(&trial[i]) ? anew : near);
        effects += chosen && !best;
        if (chosen) finalist[finalists++] = trial[i];
        else trial[others++] = trial[i];
    }
    memmove(trial + finalists, trial, (size_t)others * sizeof *trial);
    memcpy(trial, finalist, (size_t)finalists * sizeof *trial);
    crew->trial = trial;
    crew->count = finalists;
    run_crew(crew, polish_next, threads);
    qsort(trial, (size_t)count, sizeof *trial, by_evidence);
    free(finalist);
}

int diagnosis_try(const struct diagnosis *d, struct trial *trial, int threads) {
    struct crew *first = memory_get(1, sizeof *first), *second = memory_get(1, sizeof *second);
    int leg[LEGS];
    first->d = second->d = d;
    for (int i = 0; i < d->hypotheses; i++)
        if (d->hypothesis[i].shape == SHAPE_ALL) first->hypothesis[first->count++] = &d->hypothesis[i];
    first->trial = trial;
    try_all(first, threads);
    rank_legs(d, leg);
    for (int i = 0; i < d->hypotheses; i++) {
        const struct hypothesis *h = &d->hypothesis[i];
        bool tried = h->shape == leg[0] || (h->shape == leg[1] && promising(first, h->effect, TRIED_ONE_LEG)) ||
                     (h->shape == SHAPE_EACH &&
                      (promising(first, h->effect, TRIED_EACH) || hypothesis_parts(h) == PART_FORCE || each_in_base(d, h->effect)));
        if (tried) second->hypothesis[second->count++] = h;
    }
    second->trial = trial + first->count;
    second->before = first;
    try_all(second, threads);
    int count = first->count + second->count;
    finish(second, trial, count, threads);
    free(first);
    free(second);
    return count;
}

/* The base without what is parallel to an addition, then the additions. */
static bool list_variables(struct diagnosis *d) {
    struct variable base[FIT_VARIABLES];
    int count = base_variables(d->given, d->even.parts, base);
    d->variables = 0;
    for (int i = 0; i < count; i++) {
        enum parallel how = PARALLEL_NOT;
        for (int j = 0; j < d->added; j++) {
            enum parallel one = hypothesis_parallel(&d->addition[j], &base[i]);
            how = one > how ? one : how;
        }
        if (how == PARALLEL_DRAWN) variable_draw(&base[i]);
        if (how != PARALLEL_SAME) d->variable[d->variables++] = base[i];
    }
    for (int j = 0; j < d->added; j++) {
        const struct hypothesis *h = &d->addition[j];
        if (d->variables + h->variables > FIT_VARIABLES) return false;
        memcpy(d->variable + d->variables, h->variable, (size_t)h->variables * sizeof *d->variable);
        d->variables += h->variables;
    }
    return true;
}

void diagnosis_estimate(struct diagnosis *d) {
    double noise = sqrt(fmin(d->square / d->fit.evaluated, 1.0)); /* of what it was taken for */
    for (int i = 0; i < d->variables; i++) {
        struct variable *v = &d->variable[i];
        if (!v->base) continue;
        variable_draw(v);
        v->pull *= noise;
    }
    diagnosis_refit(d, BASE_ITERATIONS);
}

/* Back to a model that was fitted already. */
static void restore(struct diagnosis *d, const struct params *model, const double std[FIT_VARIABLES]) {
    d->model = *model;
    list_variables(d);
    diagnosis_refit(d, 0);
    memcpy(d->std, std, sizeof d->std);
}

bool diagnosis_add(struct diagnosis *d, const struct trial *t) {
    struct params before = d->model;
    double std[FIT_VARIABLES];
    int effect = t->hypothesis->effect;
    memcpy(std, d->std, sizeof std);
    if (d->added == GAP_EFFECTS) return false;
    d->addition[d->added++] = *t->hypothesis;
    d->model = t->model;
    d->found[effect] = true;
    if (list_variables(d) && diagnosis_refit(d, BASE_ITERATIONS)) return true;
    d->added--;
    d->found[effect] = false;
    restore(d, &before, std);
    return false;
}

bool diagnosis_drop(struct diagnosis *d, int addition, double most) {
    int effect = d->addition[addition].effect;
    struct hypothesis dropped = d->addition[addition];
    struct params before = d->model;
    double square = d->square, held = d->held_square, std[FIT_VARIABLES];
    memcpy(std, d->std, sizeof std);
    d->model.effects[effect] = d->given->effects[effect];
    d->found[effect] = false; /* a hypothesis again */
    memmove(d->addition + addition, d->addition + addition + 1, (size_t)(--d->added - addition) * sizeof *d->addition);
    bool fitted = list_variables(d) && diagnosis_refit(d, BASE_ITERATIONS);
    if (fitted && d->square - square < most + PENALTY * dropped.variables && d->held_square - held < most) return true;
    d->found[effect] = true;
    memmove(d->addition + addition + 1, d->addition + addition, (size_t)(d->added++ - addition) * sizeof *d->addition);
    d->addition[addition] = dropped;
    restore(d, &before, std);
    return false;
}
