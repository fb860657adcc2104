#include "evidence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "memory.h"
#include "numeric.h"

static int rows_of(const struct covariance *c) {
    int rows = 0;
    for (int i = 0; i < c->values; i++) rows += c->evaluated[i];
    return rows;
}

/* Copies the evaluated values. scale: NULL, or factors, the root of which multiplies each value. */
static void compress(const struct covariance *c, const double *from, const double *scale, double *to) {
    for (int i = 0, n = 0; i < c->values; i++)
        if (c->evaluated[i]) to[n++] = from[i] * (scale ? sqrt(scale[i]) : 1.0);
}

/* Returns 1 / standard deviation of the normal distribution whose highest density equals the
 * density of a value's prior at this value. The reciprocal of the value, such as a lag, has half a
 * normal distribution as its prior. The standard deviation of this prior is three times the typical
 * size of the reciprocal, also on a small machine, because such constants do not grow with the
 * machine. */
static double reciprocal_density(const struct effect_key *k, double value) {
    double wide = 3.0 * fabs(1.0 / k->typical - 1.0 / k->neutral), off = (1.0 / value - 1.0 / k->neutral) / wide;
    return 2.0 * exp(-0.5 * off * off) / (wide * value * value);
}

static double uniform_inverse_std(const struct variable *v, double value) {
    const struct effect_key *k = v->effect >= 0 ? &effect_table[v->effect]->keys[v->key] : NULL;
    return k && !v->base && k->reciprocal ? fmax(reciprocal_density(k, value), 1e-300) : sqrt(2.0 * PI) / (v->max - v->min);
}

void linearised_init(struct linearised *l, const struct diagnosis *d, const struct covariance *c, const double *variance) {
    size_t values = (size_t)d->fit.values;
    *l = (struct linearised){.rows = rows_of(c), .variables = d->variables};
    size_t rows = (size_t)l->rows;
    double *white = memory_get(values, sizeof *white), *column = memory_get(values * (size_t)l->variables, sizeof *column);
    l->white = memory_get(rows, sizeof *l->white);
    l->column = memory_get(rows * (size_t)l->variables, sizeof *l->column);
    held_init(&l->held, d, c, l->rows, variance);
    if (l->held.places) held_residuals(d, white, column);
    else fit_residual(&d->fit, &d->model, white);
    compress(c, white, variance, l->white);
    for (int i = 0; i < l->variables; i++) {
        const struct variable *v = &d->variable[i];
        double value = variable_get(v, &d->model);
        compress(c, (l->held.places ? column : d->column) + (size_t)i * values, variance, l->column + (size_t)i * rows);
        bool normal = v->prior_inverse_std > 0.0;
        l->inverse_std[i] = normal ? v->prior_inverse_std : uniform_inverse_std(v, value);
        l->uniform[i] = !normal;
        l->off[i] = normal ? value - v->neutral : 0.0;
        l->least[i] = v->min - value, l->most[i] = v->max - value;
        l->one_sided += normal && !v->base && (v->min >= v->neutral || v->max <= v->neutral);
    }
    free(white);
    free(column);
}

void linearised_free(struct linearised *l) {
    free(l->white);
    free(l->column);
    held_free(&l->held);
}

/* The linear least-squares problem. column: columns of the model's variables, then of the
 * covariance's features; each is for a change by one standard deviation of the prior. white:
 * residuals. Columns and residuals are divided by the standard deviation of noise and remainder
 * together. */
struct problem {
    int n, rows;
    double *column, *white, log_variance;
};

static void state(const struct linearised *l, const struct covariance *c, const struct covariance_size *size, struct problem *p) {
    int features = size->repeats > 0.0 ? c->features : 0;
    size_t rows = (size_t)l->rows;
    double *weight = memory_get(rows, sizeof *weight);
    *p = (struct problem){.n = l->variables + features, .rows = l->rows};
    p->white = memory_get(rows, sizeof *p->white);
    p->column = memory_get(rows * (size_t)p->n, sizeof *p->column);
    for (int i = 0, n = 0; i < c->values; i++) {
        if (!c->evaluated[i]) continue;
        double variance = covariance_of(c, size, i);
        p->log_variance += log(variance);
        weight[n] = 1.0 / sqrt(variance), p->white[n] = weight[n] * l->white[n];
        for (int j = 0; j < features; j++)
            p->column[(size_t)(l->variables + j) * rows + (size_t)n] = weight[n] * size->repeats *
                                                                       c->feature[(size_t)j * (size_t)c->values + (size_t)i];
        n++;
    }
    for (int j = 0; j < l->variables; j++)
        for (size_t k = 0; k < rows; k++) p->column[(size_t)j * rows + k] = weight[k] * l->column[(size_t)j * rows + k] / l->inverse_std[j];
    p->log_variance += held_whiten(&l->held, p->rows, weight, p->white, p->n, p->column);
    free(weight);
}

/* A quadratic form 1/2 x' h x + g' x, and ranges of the values x. end: -1 or 1 for a value that is
 * fixed at the lower or upper end of its range; 0 for a free value. target: minimum of the form
 * over the free values, while the fixed ones stay. */
struct bounded {
    int n;
    const double *h, *g, *least, *most;
    double *x, *matrix, *target;
    int *end;
};

/* Finds the target. Returns false if h is not positive definite to rounding. */
static bool find_target(const struct bounded *p) {
    int n = p->n;
    for (int i = 0; i < n; i++) {
        p->target[i] = p->end[i] ? p->x[i] : -p->g[i];
        for (int j = 0; j < n; j++) {
            p->matrix[i * n + j] = p->end[i] || p->end[j] ? i == j : p->h[i * n + j];
            if (!p->end[i] && p->end[j]) p->target[i] -= p->h[i * n + j] * p->x[j];
        }
    }
    if (!dense_factor(n, n, p->matrix)) return false;
    dense_solve(n, n, p->matrix, p->target);
    return true;
}

static double value_at(const struct bounded *p, const double *x) {
    double sum = 0.0;
    for (int i = 0; i < p->n; i++) sum += x[i] * (0.5 * dense_dot(p->n, p->h + i * p->n, x) + p->g[i]);
    return sum;
}

/* Moves all values to the target, each no farther than to the end of its range, where it is fixed.
 * Returns false and moves nothing if this does not lower the form. */
static bool project(const struct bounded *p) {
    double *clipped = p->matrix; /* the matrix's factor is not needed any more */
    for (int i = 0; i < p->n; i++) clipped[i] = fmin(fmax(p->target[i], p->least[i]), p->most[i]);
    if (!(value_at(p, clipped) < value_at(p, p->x))) return false;
    for (int i = 0; i < p->n; i++) {
        if (!p->end[i] && clipped[i] != p->target[i]) p->end[i] = clipped[i] > p->target[i] ? -1 : 1;
        p->x[i] = clipped[i];
    }
    return true;
}

/* Moves towards the target until the first value reaches an end of its range, and fixes that value
 * there. */
static void move(const struct bounded *p) {
    double share = 1.0;
    int first = -1;
    for (int i = 0; i < p->n; i++) {
        double end = fmin(fmax(p->target[i], p->least[i]), p->most[i]);
        if (p->end[i] || end == p->target[i]) continue;
        double reached = fmax((end - p->x[i]) / (p->target[i] - p->x[i]), 0.0);
        if (reached < share || first < 0) share = fmin(share, reached), first = i;
    }
    for (int i = 0; i < p->n; i++) p->x[i] += share * (p->target[i] - p->x[i]);
    bool low = p->target[first] < p->least[first];
    p->end[first] = low ? -1 : 1, p->x[first] = low ? p->least[first] : p->most[first];
}

static bool in_range(const struct bounded *p) {
    bool in = true;
    for (int i = 0; i < p->n; i++) in = in && p->target[i] >= p->least[i] && p->target[i] <= p->most[i];
    return in;
}

/* Frees the fixed value whose gradient draws it most strongly away from its end. Returns false if
 * there is none. */
static bool release(const struct bounded *p) {
    double most = 1e-9;
    int which = -1;
    for (int i = 0; i < p->n; i++) {
        if (!p->end[i]) continue;
        double pull = p->end[i] * (p->g[i] + dense_dot(p->n, p->h + i * p->n, p->x)) / sqrt(p->h[i * p->n + i]);
        if (pull > most) most = pull, which = i;
    }
    if (which >= 0) p->end[which] = 0;
    return which >= 0;
}

/* Minimises 1/2 x' h x + g' x over x within its ranges by a primal active set. Each x starts at 0,
 * or at the end of its range nearest to 0, and no round raises the form. */
static void solve(const struct linearised *l, int n, const double *h, const double *g, double *x) {
    double *work = memory_get((size_t)(n * (n + 3)), sizeof *work);
    struct bounded p = {
        .n = n, .h = h, .g = g, .x = x, .matrix = work + 3 * n, .target = work, .end = memory_get((size_t)n, sizeof *p.end)};
    double *least = work + n, *most = work + 2 * n;
    for (int i = 0; i < n; i++) {
        least[i] = i < l->variables ? l->least[i] * l->inverse_std[i] : -HUGE_VAL;
        most[i] = i < l->variables ? l->most[i] * l->inverse_std[i] : HUGE_VAL;
        x[i] = fmin(fmax(0.0, least[i]), most[i]);
    }
    p.least = least, p.most = most;
    for (int round = 0; round < 4 * n && find_target(&p); round++) {
        if (!in_range(&p)) {
            if (!project(&p)) move(&p);
            continue;
        }
        memcpy(x, p.target, (size_t)n * sizeof *x);
        if (!release(&p)) break;
    }
    free(work);
    free(p.end);
}

double evidence_of(const struct linearised *l, const struct covariance *c, const struct covariance_size *size, double *change,
                   double *std) {
    struct problem p;
    state(l, c, size, &p);
    int n = p.n;
    double *h = memory_get((size_t)(n * n), sizeof *h), *factor = memory_get((size_t)(n * n), sizeof *factor);
    double *g = memory_get((size_t)n, sizeof *g), *x = memory_get((size_t)n, sizeof *x);
    double sum = dense_dot(p.rows, p.white, p.white), log_curvature = 0.0;
    for (int i = 0; i < n; i++) {
        const double *column = p.column + (size_t)i * (size_t)p.rows;
        double off = i < l->variables ? l->off[i] * l->inverse_std[i] : 0.0;
        bool uniform = i < l->variables && l->uniform[i];
        g[i] = dense_dot(p.rows, column, p.white) + off;
        sum += square(off);
        for (int j = 0; j <= i; j++) h[i * n + j] = h[j * n + i] = dense_dot(p.rows, column, p.column + (size_t)j * (size_t)p.rows);
        h[i * n + i] += uniform ? 1e-6 : 1.0;
    }
    memcpy(factor, h, (size_t)(n * n) * sizeof *h);
    for (int i = 0; i < l->variables; i++)
        if (l->uniform[i])
            factor[i * n + i] += 1.0; /* the data may leave a value undetermined; its uniform prior
                                       * still bounds it */
    solve(l, n, h, g, x);
    for (int i = 0; i < n; i++) sum += x[i] * (2.0 * g[i] + dense_dot(n, h + i * n, x));
    bool definite = dense_factor(n, n, factor);
    if (definite) {
        for (int i = 0; i < n; i++) log_curvature += 2.0 * log(factor[i * n + i]);
        double *diagonal = g, *work = p.white; /* g and p.white are needed no more; p.white is long
                                                * enough if rows >= n */
        if (std && p.rows >= n) {
            dense_inverse_diagonal(n, n, factor, diagonal, work);
            for (int i = 0; i < l->variables; i++) std[i] = sqrt(diagonal[i]) / l->inverse_std[i];
        }
    }
    for (int i = 0; i < l->variables && change; i++) change[i] = x[i] / l->inverse_std[i];
    free(h);
    free(factor);
    free(g);
    free(x);
    free(p.column);
    free(p.white);
    return definite ? -0.5 * (sum + p.log_variance + log_curvature) + l->one_sided * log(2.0) : -HUGE_VAL;
}
