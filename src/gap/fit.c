#include "fit.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "memory.h"
#include "numeric.h"
#include "parallel.h"
#include "params.h"

enum { COLUMNS_MAX = FIT_VARIABLES + LINEAR_BESIDE, ACTIVE_SWEEPS = 200 };

static const double LEAST_DAMPING = 1e-3, MOST_DAMPING = 10.0; /* range of a step's damping */
static const double BASE_ERROR = 1e-3; /* error of integrators and of omitted harmonics, as a share
                                        * of a channel's variation */
static const double ENOUGH = 1e-4; /* a fit ends when a step lowers the sum of squares by less than
                                    * this share */
static const double PROMISE = 0.5; /* columns are kept for the next step if this one lowered the sum
                                    * of squares by at least this share of the prediction */
static const double HOLDS = 1e-3;  /* columns hold as long as the sum of squares has fallen by less
                                    * than this share since they were computed; until then they are
                                    * wrong by a few hundredths at most */

void variable_set(const struct variable *v, struct params *params, double value) {
    double *place = (double *)(void *)((char *)params + v->offset);
    for (int i = 0; i < v->legs; i++)
        if (v->leg < 0 || v->leg == i) place[i] = value;
    if (v->effect >= 0) params->effects[v->effect].on = true;
}

double variable_get(const struct variable *v, const struct params *params) {
    const double *place = (const double *)(const void *)((const char *)params + v->offset);
    return place[v->leg < 0 ? 0 : v->leg];
}

void fit_data_init(struct fit_data *d, const struct residual_data *residual, const struct params *model, int threads) {
    *d = (struct fit_data){
        .residual = residual, .threads = threads, .values = residual->tests * (int)(sizeof(residual_row) / sizeof(double))};
    d->whitener = memory_get((size_t)residual->tests, sizeof *d->whitener);
    for (int i = 0; i < residual->tests; i++) {
        whitener_init(&d->whitener[i], &residual->test[i], model, BASE_ERROR);
        d->evaluated += d->whitener[i].values;
    }
}

void fit_data_free(struct fit_data *d) { free(d->whitener); }

/* Evaluation of a model's raw residuals; threads share its tests. */
struct evaluation {
    const struct residual_data *residual;
    const struct params *model;
    enum residual_equations equations;
    int leg;
    residual_row *row;
    atomic_bool impossible;
};

static void evaluate(void *context, int test) {
    struct evaluation *e = context;
    if (e->impossible) return;
    if (!residual_evaluate(&e->residual->test[test], e->model, e->equations, e->leg, e->row[test])) e->impossible = true;
}

static bool raw_residual(const struct fit_data *d, const struct params *model, enum residual_equations equations, int leg, double *raw) {
    struct evaluation e = {.residual = d->residual, .model = model, .equations = equations, .leg = leg, .row = (residual_row *)raw};
    parallel_run(d->threads, d->residual->tests, evaluate, &e);
    return !e.impossible;
}

static void whiten_all(const struct fit_data *d, double *raw) {
    residual_row *row = (residual_row *)raw;
    for (int i = 0; i < d->residual->tests; i++) whiten(&d->whitener[i], row[i]);
}

bool fit_residual(const struct fit_data *d, const struct params *model, double *white) {
    if (!raw_residual(d, model, EQUATIONS_ALL, ALL_LEGS, white)) return false;
    whiten_all(d, white);
    return true;
}

double fit_square(int n, const double *white) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += white[i] * white[i];
    return sum;
}

bool fit_contribution(const struct fit_data *d, const struct params *model, int effect, double *white) {
    double *without = memory_get((size_t)d->values, sizeof *without);
    struct params rest = *model;
    rest.effects[effect].on = false;
    bool found = fit_residual(d, model, white) && fit_residual(d, &rest, without);
    for (int i = 0; i < d->values && found; i++) white[i] -= without[i];
    free(without);
    return found;
}

static void whiten_copy(const struct fit_data *d, const double *raw, double *white) {
    memcpy(white, raw, (size_t)d->values * sizeof *white);
    whiten_all(d, white);
}

static double step_of(const struct variable *v, double value) { return value + v->step > v->max ? -v->step : v->step; }

/* True if a variable affects its own leg's residuals alone. apart: equations in which the legs are
 * independent. */
static bool is_own(enum residual_equations apart, const struct variable *v) { return v->own && !(v->equations & ~apart); }

/* Number of variables, from v on, that are the same quantity of different legs. One evaluation
 * gives the columns of all of them, because the legs are independent. */
static int of_own_legs(enum residual_equations apart, int variables, const struct variable *v, const double *const *known) {
    int n = 1;
    while (n < variables && is_own(apart, v) && is_own(apart, &v[n]) && v[n].offset == v->offset && v[n].leg > v[n - 1].leg &&
           !(known && known[n]))
        n++;
    return n;
}

/* Clears the values of other legs in a column; they belong to the other variables of the group. */
static void clear_other_legs(const struct fit_data *d, int leg, double *column) {
    residual_row *row = (residual_row *)column;
    for (int i = 0; i < d->residual->tests; i++)
        for (int k = 0; k < LEGS; k++)
            if (k != leg) memset(row[i][k], 0, sizeof row[i][k]);
}

/* The only leg whose residuals these variables move, or ALL_LEGS. */
static int only_leg(enum residual_equations apart, int variables, const struct variable *v) {
    bool one = variables > 0;
    for (int i = 0; i < variables; i++) one = one && is_own(apart, &v[i]) && v[i].leg == v[0].leg;
    return one ? v[0].leg : ALL_LEGS;
}

/* Columns that are being computed. Group i holds many[i] variables from first[i] on, which are
 * moved in one evaluation. */
struct columns {
    struct fit_data share; /* the data, with one group's share of the threads */
    const struct params *model;
    const double *raw;
    const struct variable *v;
    double *column;
    enum residual_equations apart;
    int groups, first[FIT_VARIABLES], many[FIT_VARIABLES];
    atomic_bool impossible;
};

static void move_group(void *context, int group) {
    struct columns *s = context;
    const struct fit_data *d = &s->share;
    const struct variable *v = s->v + s->first[group];
    size_t values = (size_t)d->values;
    double *c = s->column + (size_t)s->first[group] * values;
    int many = s->many[group];
    struct params moved = *s->model;
    if (s->impossible) return;
    for (int j = 0; j < many; j++) {
        double value = variable_get(&v[j], s->model);
        variable_set(&v[j], &moved, value + step_of(&v[j], value));
    }
    memcpy(c, s->raw, values * sizeof *c);
    if (!raw_residual(d, &moved, v->equations, many > 1 ? ALL_LEGS : only_leg(s->apart, 1, v), c)) {
        s->impossible = true;
        return;
    }
    for (size_t a = 0; a < values; a++) c[a] -= s->raw[a];
    for (int j = many - 1; j >= 0; j--) {
        double *own = c + (size_t)j * values, step = step_of(&v[j], variable_get(&v[j], s->model));
        for (size_t a = 0; a < values; a++) own[a] = c[a] / step;
        if (is_own(s->apart, &v[j])) clear_other_legs(d, v[j].leg, own);
        whiten_all(d, own);
    }
}

bool fit_columns(const struct fit_data *d, const struct params *model, const double *raw, int variables, const struct variable *v,
                 const double *const *known, double *column) {
    struct columns s = {.share = *d, .model = model, .raw = raw, .v = v, .column = column, .apart = residual_legs_apart(model)};
    for (int i = 0, n; i < variables; i += n) {
        n = 1;
        if (known && known[i]) continue;
        n = of_own_legs(s.apart, variables - i, v + i, known ? known + i : NULL);
        s.first[s.groups] = i, s.many[s.groups++] = n;
    }
    s.share.threads = s.groups > 0 && s.groups < d->threads ? d->threads / s.groups : 1;
    parallel_run(d->threads, s.groups, move_group, &s);
    return !s.impossible;
}

/* Factors the m rows and columns of h that `place` lists, with a ridge of 1e-10 of the diagonal. If
 * they are linearly dependent, the ridge is raised until the factorisation succeeds. Returns false
 * if no ridge up to 1e-4 suffices. */
static bool factor_some(int n, const double *h, int m, const int *place, double *a) {
    for (double ridge = 1e-10; ridge < 2e-4; ridge *= 100.0) {
        for (int i = 0; i < m; i++)
            for (int j = 0; j <= i; j++) a[i * m + j] = h[place[i] * n + place[j]] * (i == j ? 1.0 + ridge : 1.0);
        if (dense_factor(m, m, a)) return true;
    }
    return false;
}

/* Solves h x + g = 0 for the free variables; the others keep their x. */
static bool solve_free(int n, const double *h, const double *g, const bool *is_free, double *x) {
    double a[COLUMNS_MAX * COLUMNS_MAX], b[COLUMNS_MAX];
    int place[COLUMNS_MAX], m = 0;
    for (int i = 0; i < n; i++)
        if (is_free[i]) place[m++] = i;
    for (int i = 0; i < m; i++) {
        b[i] = -g[place[i]];
        for (int j = 0; j < n; j++)
            if (!is_free[j]) b[i] -= h[place[i] * n + j] * x[j];
    }
    if (!factor_some(n, h, m, place, a)) return false;
    dense_solve(m, m, a, b);
    for (int i = 0; i < m; i++) x[place[i]] = b[i];
    return true;
}

/* Solves h x + g = 0 within the box by an active set, starting from x clipped to the box. A
 * variable at a bound stays there until the gradient points inwards. Near the solution few sweeps
 * suffice. */
static bool box_solve(int n, const double *h, const double *g, const double *min, const double *max, double *x, bool *is_free) {
    for (int i = 0; i < n; i++) x[i] = fmin(fmax(x[i], min[i]), max[i]), is_free[i] = x[i] > min[i] && x[i] < max[i];

    for (int sweep = 0; sweep < ACTIVE_SWEEPS; sweep++) {
        double to[COLUMNS_MAX], share = 1.0, worst = 0.0;
        int blocked = -1, released = -1;
        memcpy(to, x, (size_t)n * sizeof *x);
        if (!solve_free(n, h, g, is_free, to)) return false;

        for (int i = 0; i < n; i++) {
            if (!is_free[i] || (to[i] >= min[i] && to[i] <= max[i])) continue;
            double bound = to[i] < min[i] ? min[i] : max[i], reach = (bound - x[i]) / (to[i] - x[i]);
            if (reach < share || blocked < 0) share = fmax(reach, 0.0), blocked = i;
        }
        for (int i = 0; i < n; i++)
            if (is_free[i]) x[i] += share * (to[i] - x[i]);
        if (blocked >= 0) {
            x[blocked] = to[blocked] < min[blocked] ? min[blocked] : max[blocked];
            is_free[blocked] = false;
            continue;
        }

        for (int i = 0; i < n; i++) {
            if (is_free[i] || !(max[i] > min[i])) continue;
            double slope = g[i];
            for (int j = 0; j < n; j++) slope += h[i * n + j] * x[j];
            double gain = (x[i] <= min[i] ? -slope : slope) / sqrt(h[i * n + i]);
            if (gain > worst + 1e-9) worst = gain, released = i;
        }
        if (released < 0) return true;
        is_free[released] = true;
    }
    return true;
}

/* Scalar product. Four independent sums are faster than one, because each addition to a sum waits
 * for the one before. */
static double dot(int n, const double *a, const double *b) {
    double sum[4] = {0}, rest = 0.0;
    int i = 0;
    for (; i + 4 <= n; i += 4)
        for (int j = 0; j < 4; j++) sum[j] += a[i + j] * b[i + j];
    for (; i < n; i++) rest += a[i] * b[i];
    return sum[0] + sum[1] + sum[2] + sum[3] + rest;
}

void fit_gram(int n, int values, const double *column, double *gram) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++)
            gram[i * n + j] = gram[j * n + i] = dot(values, column + (size_t)i * (size_t)values, column + (size_t)j * (size_t)values);
}

/* Sets up the normal equations h x + g = 0 of the least squares. Products of the columns from
 * first_known on are taken from `gram`. */
static void normal_equations(int n, int values, const double *residual, const double *const *column, int first_known, const double *gram,
                             double *h, double *g) {
    for (int i = 0; i < n; i++) {
        g[i] = dot(values, column[i], residual);
        for (int j = 0; j <= i; j++)
            h[i * n + j] = h[j * n + i] = j < first_known ? dot(values, column[i], column[j])
                                                          : gram[(i - first_known) * (n - first_known) + j - first_known];
    }
}

/* Computes the standard deviations of the solution. A value that cannot move gets 0, as does a
 * value at its bound without a prior. A value at its bound with a prior gets a standard deviation
 * that includes the prior, and adds to the deviations of the other values. */
static void deviations(int n, const double *h, const struct fit_prior *prior, const double *min, const double *max, const bool *is_free,
                       double *std) {
    double a[COLUMNS_MAX * COLUMNS_MAX], diagonal[COLUMNS_MAX], work[COLUMNS_MAX];
    int place[COLUMNS_MAX], m = 0;
    for (int i = 0; i < n; i++) {
        std[i] = 0.0;
        if (is_free[i] || (prior && prior[i].inverse_std > 0.0 && max[i] > min[i])) place[m++] = i;
    }
    if (!factor_some(n, h, m, place, a)) return;
    dense_inverse_diagonal(m, m, a, diagonal, work);
    for (int i = 0; i < m; i++) std[place[i]] = sqrt(diagonal[i]);
}

static bool solve_box(int n, double *h, double *g, const struct fit_prior *prior, const double *min, const double *max, double *x,
                      double *std) {
    bool is_free[COLUMNS_MAX];
    for (int i = 0; i < n && prior; i++) h[i * n + i] += square(prior[i].inverse_std), g[i] += square(prior[i].inverse_std) * prior[i].off;
    for (int i = 0; i < n; i++)        /* a column of zeros has no influence, so its variable
                                        * stays */
        if (!(h[i * n + i] > 0.0)) h[i * n + i] = 1.0;
    if (!box_solve(n, h, g, min, max, x, is_free)) return false;
    if (std) deviations(n, h, prior, min, max, is_free, std);
    return true;
}

bool fit_box(int n, int values, const double *residual, const double *const *column, const struct fit_prior *prior, const double *min,
             const double *max, double *x, double *std) {
    double h[COLUMNS_MAX * COLUMNS_MAX], g[COLUMNS_MAX];
    normal_equations(n, values, residual, column, n, NULL, h, g);
    memset(x, 0, (size_t)n * sizeof *x);
    return solve_box(n, h, g, prior, min, max, x, std);
}

/* Finds the least sum of squares of the white residuals that the linear part can reach, with the
 * penalty of its priors, and sets linear->x. Without a linear part, returns the sum of squares
 * itself. Returns INFINITY if the equations are singular. */
static double linear_square(int values, const double *white, const struct linear_part *linear) {
    double h[COLUMNS_MAX * COLUMNS_MAX], g[COLUMNS_MAX], slope[COLUMNS_MAX], sum = fit_square(values, white);
    int n = linear ? linear->n : 0;
    if (!n) return sum;
    memcpy(h, linear->gram, (size_t)(n * n) * sizeof *h);
    for (int i = 0; i < n; i++) g[i] = slope[i] = dot(values, linear->column + (size_t)i * (size_t)values, white);
    if (!solve_box(n, h, g, linear->prior, linear->min, linear->max, linear->x, NULL)) return INFINITY;
    for (int i = 0; i < n; i++) sum += linear->x[i] * (2.0 * slope[i] + dot(n, linear->gram + i * n, linear->x));
    for (int i = 0; i < n; i++) sum += square(linear->prior[i].inverse_std * (linear->x[i] + linear->prior[i].off));
    return sum;
}

static enum residual_equations equations_of(int variables, const struct variable *v) {
    enum residual_equations equations = 0;
    for (int i = 0; i < variables; i++) equations |= v[i].equations;
    return equations;
}

double fit_start(const struct fit_data *d, const struct params *model, int variables, const struct variable *v,
                 const struct linear_part *linear, double *raw, double *white) {
    int leg = only_leg(residual_legs_apart(model), variables, v);
    memcpy(raw, linear->raw, (size_t)d->values * sizeof *raw);
    if (variables && !raw_residual(d, model, equations_of(variables, v), leg, raw)) return INFINITY;
    whiten_copy(d, raw, white);
    return linear_square(d->values, white, linear);
}

double fit_share(const struct fit_data *d, const double *white, const double *change, const struct linear_part *linear) {
    double h[COLUMNS_MAX * COLUMNS_MAX], g[COLUMNS_MAX], min[COLUMNS_MAX], max[COLUMNS_MAX], x[COLUMNS_MAX] = {0};
    const double *column[COLUMNS_MAX] = {change};
    struct fit_prior prior[COLUMNS_MAX] = {{0}};
    int n = 1 + linear->n;
    min[0] = -HUGE_VAL, max[0] = HUGE_VAL;
    for (int i = 1; i < n; i++) {
        column[i] = linear->column + (size_t)(i - 1) * (size_t)d->values;
        min[i] = linear->min[i - 1], max[i] = linear->max[i - 1], prior[i] = linear->prior[i - 1];
    }
    normal_equations(n, d->values, white, column, 1, linear->gram, h, g);
    return solve_box(n, h, g, prior, min, max, x, NULL) ? x[0] : 0.0;
}

bool fit_raw(const struct fit_data *d, const struct params *model, double *raw) {
    return raw_residual(d, model, EQUATIONS_ALL, ALL_LEGS, raw);
}

/* Returns the penalty of priors, in squared white residuals. counted: true for the priors of
 * effects and of penalised base variables, whose penalty fit_result.square includes; false for the
 * priors of all other base variables. */
static double prior_cost(const struct params *model, int variables, const struct variable *v, bool counted) {
    double sum = 0.0;
    for (int i = 0; i < variables; i++)
        if (v[i].prior_inverse_std > 0.0 && (!v[i].base || v[i].penalised) == counted)
            sum += square(v[i].prior_inverse_std * (variable_get(&v[i], model) - v[i].neutral));
    return sum;
}

/* State of a fit: the model, its variables and its residuals. */
struct descent {
    const struct fit_data *d;
    struct params *model;
    int variables;
    const struct variable *v;
    const struct linear_part *linear;
    enum residual_equations equations;  /* equations of the residuals that the variables move */
    int leg;                            /* the only leg whose residuals the variables move, or
                                         * ALL_LEGS */
    /* residuals at the model; square: their sum of squared white residuals, with the penalty of the
     * priors */
    double square, *raw, *white;
    double *tried_raw, *tried_white;    /* residuals of a step that is tried */
};

/* Sum of squared white residuals of a model with the penalty of the priors. */
static double objective(const struct descent *s, const struct params *model, const double *white) {
    double cost = prior_cost(model, s->variables, s->v, false) + prior_cost(model, s->variables, s->v, true);
    return linear_square(s->d->values, white, s->linear) + cost;
}

static void swap(double **a, double **b) {
    double *first = *a;
    *a = *b, *b = first;
}

/* Moves the model by x. Returns false if the sum of squares does not fall: then nothing has changed
 * but s->linear->x, which belongs to the rejected step. */
static bool move(struct descent *s, const double *x) {
    struct params moved = *s->model;
    for (int i = 0; i < s->variables; i++) variable_set(&s->v[i], &moved, variable_get(&s->v[i], s->model) + x[i]);
    memcpy(s->tried_raw, s->raw, (size_t)s->d->values * sizeof *s->raw);
    if (!raw_residual(s->d, &moved, s->equations, s->leg, s->tried_raw)) return false;
    whiten_copy(s->d, s->tried_raw, s->tried_white);
    double square = objective(s, &moved, s->tried_white);
    if (!(square < s->square)) return false;
    *s->model = moved;
    s->square = square;
    swap(&s->raw, &s->tried_raw);
    swap(&s->white, &s->tried_white);
    return true;
}

/* Normal equations h x + g = 0 of a step within a box, and the priors, of n variables. */
struct step {
    int n, moved; /* number of all variables. The first `moved` ones are the fit's own variables;
                   * the others are the linear part */
    double h[COLUMNS_MAX * COLUMNS_MAX], g[COLUMNS_MAX], min[COLUMNS_MAX], max[COLUMNS_MAX];
    struct fit_prior prior[COLUMNS_MAX];
};

/* Solves a step whose diagonal is raised by the share `damping` (Marquardt 1963). Without damping
 * the step is a Gauss-Newton step. Damping shortens it, first along directions on which the
 * residuals hardly depend. The linear part is not damped, because its x is no step but a value, and
 * the residuals are linear in it. */
static bool solve_step(const struct step *p, double damping, double *x, double *std) {
    double h[COLUMNS_MAX * COLUMNS_MAX], g[COLUMNS_MAX];
    memcpy(h, p->h, (size_t)(p->n * p->n) * sizeof *h);
    memcpy(g, p->g, (size_t)p->n * sizeof *g);
    for (int i = 0; i < p->moved; i++) h[i * p->n + i] *= 1.0 + damping;
    return solve_box(p->n, h, g, p->prior, p->min, p->max, x, std);
}

/* Predicted sum of squares at x, if the residuals were linear. */
static double promised(const struct descent *s, const struct step *p, const double *x) {
    double sum = fit_square(s->d->values, s->white);
    for (int i = 0; i < p->n; i++) {
        sum += square(p->prior[i].inverse_std * (x[i] + p->prior[i].off));
        sum += x[i] * (2.0 * p->g[i] + dot(p->n, p->h + i * p->n, x));
    }
    return sum;
}

/* Moves the model by a step that is damped until the sum of squares falls; without `damp` only the
 * undamped step is tried. Returns false if no step lowers the sum. */
static bool descend(struct descent *s, const struct step *p, bool damp, double *x) {
    double linear[COLUMNS_MAX];
    size_t size = s->linear ? (size_t)s->linear->n * sizeof *linear : 0;
    if (size) memcpy(linear, s->linear->x, size);
    for (double damping = LEAST_DAMPING; !move(s, x); damping *= 10.0) {
        if (!damp || damping > MOST_DAMPING || !solve_step(p, damping, x, NULL)) {
            if (size) memcpy(s->linear->x, linear, size);
            return false;
        }
    }
    return true;
}

/* Sets up the step from the model. column: columns of all variables, those of the linear part
 * last. */
static void set_up(const struct descent *s, const double *const *column, struct step *p) {
    const struct linear_part *linear = s->linear;
    p->moved = s->variables, p->n = p->moved + (linear ? linear->n : 0);
    for (int i = 0; i < p->moved; i++) {
        double value = variable_get(&s->v[i], s->model);
        p->min[i] = s->v[i].min - value, p->max[i] = s->v[i].max - value;
        p->prior[i] = (struct fit_prior){s->v[i].prior_inverse_std, value - s->v[i].neutral};
    }
    for (int i = p->moved, j = 0; i < p->n; i++, j++)
        p->min[i] = linear->min[j], p->max[i] = linear->max[j], p->prior[i] = linear->prior[j];
    normal_equations(p->n, s->d->values, s->white, column, p->moved, linear ? linear->gram : NULL, p->h, p->g);
}

/* Columns of a fit, first those of its own variables, then those of the linear part. A base
 * variable's column holds for any model near the one for which it was computed. */
struct jacobian {
    const double *column[COLUMNS_MAX];
    double *own;     /* room for the columns that are not known beforehand */
    double square;   /* sum of squares of the model for which the base's columns were computed */
};

/* Computes the columns that are not known. keep: leaves the columns of the base as they are. */
static bool compute(const struct descent *s, const double *const *known, bool keep, struct jacobian *j) {
    const double *kept[COLUMNS_MAX];
    for (int i = 0; i < s->variables; i++) kept[i] = keep && s->v[i].base ? j->column[i] : known ? known[i] : NULL;
    if (!keep) j->square = s->square;
    return fit_columns(s->d, s->model, s->raw, s->variables, s->v, kept, j->own);
}

static bool holds(const struct descent *s, const struct jacobian *j) { return j->square - s->square < HOLDS * s->square; }

static void list_columns(const struct descent *s, const double *const *known, struct jacobian *j) {
    size_t values = (size_t)s->d->values;
    for (int i = 0; i < s->variables; i++) j->column[i] = known && known[i] ? known[i] : j->own + (size_t)i * values;
    for (int i = 0; s->linear && i < s->linear->n; i++) j->column[s->variables + i] = s->linear->column + (size_t)i * values;
}

/* Sets up the step from the model, and solves it. Returns false if the equations are singular. */
static bool plan(const struct descent *s, const struct jacobian *j, struct step *step, double *x, struct fit_result *result) {
    double std[COLUMNS_MAX];
    set_up(s, j->column, step);
    memset(x, 0, (size_t)s->variables * sizeof *x);
    for (int k = s->variables; k < step->n; k++) x[k] = s->linear->x[k - s->variables];
    if (!solve_step(step, 0.0, x, std)) return false;
    memcpy(result->std, std, (size_t)s->variables * sizeof *std);
    return true;
}

/* Moves the model to the least sum of squares, computing the columns of all variables at most
 * `sets` times. Without a linear part the base's columns are kept for further steps as long as they
 * hold or predict the steps well, because the residuals are almost linear in the base's variables,
 * and computing their columns takes as long as a hundred steps. Columns that are computed the last
 * time serve one step only. A fit with kept columns ends only if they hold and predict little
 * further gain. Returns false if the columns cannot be computed. */
static bool fit_steps(struct descent *s, const double *const *known, int sets, struct jacobian *j, struct fit_result *result) {
    double x[COLUMNS_MAX];
    struct step *step = memory_get(1, sizeof *step);
    bool keep = false, ok = true, done = false;
    list_columns(s, known, j);
    while (!done && (keep || sets-- > 0)) {
        ok = compute(s, known, keep, j);
        if (!ok || !plan(s, j, step, x, result)) break;
        double before = s->square, promise = before - promised(s, step, x);
        if (s->linear && promise < s->linear->worth) break;
        bool fell = descend(s, step, !keep, x), enough = !fell || before - s->square < ENOUGH * s->square;
        bool little = promise < HOLDS * s->square;
        done = enough && (!keep || (little && holds(s, j)));
        keep = !s->linear && sets > 0 && !enough && (holds(s, j) || before - s->square > PROMISE * promise);
    }
    free(step);
    return ok;
}

/* Computes the columns at the result, and the standard deviations from them, unless the present
 * columns hold there. */
static bool finish(const struct descent *s, const double *const *known, struct jacobian *j, struct fit_result *result) {
    double x[COLUMNS_MAX];
    if (holds(s, j)) return true;
    if (!compute(s, known, false, j)) return false;
    struct step *step = memory_get(1, sizeof *step);
    plan(s, j, step, x, result);
    free(step);
    return true;
}

struct fit_result fit_model(const struct fit_data *d, struct params *model, int variables, const struct variable *v,
                            const double *const *known, const struct linear_part *linear, const double *raw, int sets, double *column) {
    size_t values = (size_t)d->values;
    struct fit_result result = {0};
    double *room = memory_get((size_t)(4 + (column ? 0 : variables)) * values, sizeof *room);
    struct descent s = {.d = d, .model = model, .variables = variables, .v = v, .linear = linear, .raw = room, .white = room + values};
    s.tried_raw = room + 2 * values, s.tried_white = room + 3 * values;

    s.equations = equations_of(variables, v);
    s.leg = only_leg(residual_legs_apart(model), variables, v);
    if (raw || linear) memcpy(s.raw, raw ? raw : linear->raw, values * sizeof *room);
    result.ok = raw || raw_residual(d, model, linear ? s.equations : EQUATIONS_ALL, linear ? s.leg : ALL_LEGS, s.raw);
    if (result.ok) {
        struct jacobian j = {.own = column ? column : room + 4 * values, .square = HUGE_VAL};
        whiten_copy(d, s.raw, s.white);
        s.square = objective(&s, model, s.white);
        bool ok = fit_steps(&s, known, sets, &j, &result);
        if (column) result.ok = ok && finish(&s, known, &j, &result);
    }

    result.square = s.square - prior_cost(model, variables, v, false);
    free(room);
    return result;
}
