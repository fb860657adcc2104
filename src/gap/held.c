#include "held.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "memory.h"

/* Notes the evaluated rows of a leg in a test. before: number of evaluated rows before these.
 * Returns the number with these included. */
static int note_rows(struct held *h, const struct fit_data *d, const struct covariance *c, const double *variance, int test, int leg,
                     int before, double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE]) {
    enum { VALUES = RESIDUALS * RESIDUAL_SIZE };
    struct held_rows *place = &h->place[h->places];
    int begin = (test * LEGS + leg) * VALUES, row = before;
    for (int i = 0; i < VALUES; i++) {
        int a = i % RESIDUAL_SIZE, kind = i / RESIDUAL_SIZE;
        if (!c->evaluated[begin + i]) continue;
        h->coefficient[row] = a;
        h->per_n[row++] = d->whitener[test].inverse[leg][a][kind][RESIDUAL_FORCE] * sqrt(variance[begin + i]);
    }
    place->first = before, place->rows = row - before;
    memcpy(place->covariance, covariance, sizeof place->covariance);
    double trace = 0.0;
    for (int a = 0; a < RESIDUAL_SIZE; a++) trace += covariance[a][a];
    h->places += place->rows > 0 && trace > 0.0;
    return row;
}

void held_init(struct held *h, const struct diagnosis *d, const struct covariance *c, int rows, const double *variance) {
    const struct residual_data *data = d->fit.residual;
    double covariance[LEGS][RESIDUAL_SIZE][RESIDUAL_SIZE];
    *h = (struct held){.place = memory_get((size_t)data->tests * LEGS, sizeof *h->place),
                       .coefficient = memory_get((size_t)rows, sizeof *h->coefficient),
                       .per_n = memory_get((size_t)rows, sizeof *h->per_n)};
    for (int i = 0, row = 0; i < data->tests; i++) {
        residual_held(&data->test[i], &d->model, covariance);
        for (int leg = 0; leg < LEGS; leg++) row = note_rows(h, &d->fit, c, variance, i, leg, row, covariance[leg]);
    }
    if (!h->places) held_free(h), *h = (struct held){0};
}

void held_free(struct held *h) {
    free(h->place);
    free(h->coefficient);
    free(h->per_n);
}

void held_residuals(const struct diagnosis *d, double *white, double *column) {
    struct residual_data data = *d->fit.residual;
    struct fit_data sliding = d->fit;
    double *raw = memory_get((size_t)d->fit.values, sizeof *raw);
    sliding.residual = &data;
    data.test = memory_get((size_t)data.tests, sizeof *data.test);
    memcpy(data.test, d->fit.residual->test, (size_t)data.tests * sizeof *data.test);
    for (int i = 0; i < data.tests; i++) data.test[i].slides = true;
    fit_residual(&sliding, &d->model, white);
    fit_raw(&sliding, &d->model, raw);
    fit_columns(&sliding, &d->model, raw, d->variables, d->variable, NULL, column);
    free(raw);
    free(data.test);
}

/* Solves L y = x in place for a factor L of n rows. */
static void solve_lower(int n, const double *factor, double *x) {
    for (int i = 0; i < n; i++) x[i] = (x[i] - dense_dot(i, factor + i * n, x)) / factor[i * n + i];
}

/* Finds the factor L of the covariance L L' of a leg's rows. Without the friction each row has a
 * variance of 1. Returns false if the covariance is not positive definite to rounding. */
static bool factor_rows(const struct held *h, const struct held_rows *place, const double *weight, double *factor) {
    int n = place->rows, first = place->first;
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            double n2 = place->covariance[h->coefficient[first + i]][h->coefficient[first + j]];
            double per_n2 = weight[first + i] * h->per_n[first + i] * weight[first + j] * h->per_n[first + j];
            factor[i * n + j] = n2 * per_n2 + (i == j ? 1.0 : 0.0);
        }
    return dense_factor(n, n, factor);
}

double held_whiten(const struct held *h, int rows, const double *weight, double *white, int columns, double *column) {
    enum { MOST = RESIDUALS * RESIDUAL_SIZE };
    double factor[MOST * MOST], log_determinant = 0.0;
    for (int i = 0; i < h->places; i++) {
        int n = h->place[i].rows, first = h->place[i].first;
        if (!factor_rows(h, &h->place[i], weight, factor)) continue;
        solve_lower(n, factor, white + first);
        for (int j = 0; j < columns; j++) solve_lower(n, factor, column + (size_t)j * (size_t)rows + first);
        for (int j = 0; j < n; j++) log_determinant += 2.0 * log(factor[j * n + j]);
    }
    return log_determinant;
}
