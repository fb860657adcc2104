#include "covariance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "memory.h"
#include "numeric.h"

enum { ROW = sizeof(residual_row) / sizeof(double), BANDS = 4 };

/* The part `repeats` of the remainder (covariance.h) is a force on leg 1, a function of position
 * and speed that is bilinear between nodes: POSITIONS nodes over the range of the motion, and
 * SPEEDS nodes from 0 to the greatest speed. Each direction has its own nodes, because friction
 * jumps where the direction changes. */
enum { POSITIONS = 3, SPEEDS = 3, FEATURES = 2 * POSITIONS * SPEEDS };

static int leg_of(int value) { return value % ROW / RESIDUAL_SIZE / RESIDUALS; }
static int kind_of(int value) { return value % ROW / RESIDUAL_SIZE % RESIDUALS; }
static int coefficient_of(int value) { return value % RESIDUAL_SIZE; }

/* Band of a coefficient. The first band has the three slowest coefficients, the constant among
 * them; each further band is one octave, and the last one is open. */
static int band_of(int value) {
    int a = coefficient_of(value);
    return a < 3 ? 0 : a < 5 ? 1 : a < 9 ? 2 : 3;
}

/* 1 / standard deviation of a raw residual's noise, given the residuals of the channels before it;
 * 0: the residual is not evaluated. */
static double inverse_of(const struct fit_data *d, int value) {
    return d->whitener[value / ROW].inverse[leg_of(value)][coefficient_of(value)][kind_of(value)][kind_of(value)];
}

static void find_spread(struct covariance *c, const struct fit_data *reference, const double *white, const struct fit_data *d) {
    double sum[RESIDUALS][BANDS] = {{0}}, count[RESIDUALS][BANDS] = {{0}};
    for (int i = 0; i < reference->values; i++) {
        double inverse = inverse_of(reference, i);
        if (!(inverse > 0.0)) continue;
        sum[kind_of(i)][band_of(i)] += (square(white[i]) - 1.0) / square(inverse);
        count[kind_of(i)][band_of(i)]++;
    }
    for (int i = 0; i < d->values; i++)
        if (c->evaluated[i])
            c->spread[i] = fmax(sum[kind_of(i)][band_of(i)], 0.0) / fmax(count[kind_of(i)][band_of(i)], 1.0) * square(inverse_of(d, i));
}

/* Replaces squares by their means over the same test, leg, channel and band. */
static void smooth(int values, double *x) {
    for (int i = 0, next; i < values; i = next) {
        double sum = 0.0;
        for (next = i; next < values && band_of(next) == band_of(i) && next / RESIDUAL_SIZE == i / RESIDUAL_SIZE; next++) sum += x[next];
        for (int j = i; j < next; j++) x[j] = sum / (next - i);
    }
}

/* Adds the possible error of a family's laws, from the contribution of those effects of the family
 * that the model has. */
static void add_family(struct covariance *c, const struct diagnosis *reference, const struct fit_data *d, int family) {
    double *with = memory_get((size_t)d->values, sizeof *with), *without = memory_get((size_t)d->values, sizeof *without);
    struct params rest = reference->model;
    double error = 0.0;
    for (int e = 0; effect_table[e]; e++) {
        if ((int)effect_table[e]->family != family || !rest.effects[e].on || !(reference->found[e] || reference->given->effects[e].on))
            continue;
        rest.effects[e].on = false;
        error = fmax(error, effect_table[e]->law_error);
    }
    if (error > 0.0 && fit_residual(d, &reference->model, with) && fit_residual(d, &rest, without)) {
        for (int i = 0; i < d->values; i++) with[i] = square(with[i] - without[i]);
        smooth(d->values, with);
        for (int i = 0; i < d->values; i++) c->law[i] += with[i], c->least[i] += square(error) * with[i];
    }
    free(with);
    free(without);
}

/* Weight at x of a node in a grid of n nodes from 0 to 1, for linear interpolation. */
static double hat(int node, int n, double x) { return fmax(1.0 - fabs(x * (n - 1) - node), 0.0); }

/* Range of position and speed over all tests. */
struct range {
    double least_m, most_m, fastest_mps;
};

static void motion_at(const struct residual_test *t, int phase, double motion[3]) {
    spectrum_at(t->spectrum.mean[CHANNEL_LENGTH][0], t->harmonics, t->spectrum.omega, t->cycle + phase * SPECTRUM_SIZE, motion);
}

static struct range range_of(const struct residual_data *data) {
    struct range r = {HUGE_VAL, -HUGE_VAL, 0.0};
    for (int i = 0; i < data->tests; i++)
        for (int k = 0; k < data->test[i].phases; k++) {
            double motion[3];
            motion_at(&data->test[i], k, motion);
            r.least_m = fmin(r.least_m, motion[0]), r.most_m = fmax(r.most_m, motion[0]),
            r.fastest_mps = fmax(r.fastest_mps, fabs(motion[1]));
        }
    return r;
}

static double feature_at(int feature, const struct range *r, const double motion[3]) {
    int way = feature % 2 ? 1 : -1, position = feature / 2 % POSITIONS, speed = feature / 2 / POSITIONS;
    if (motion[1] * way <= 0.0 || !(r->most_m > r->least_m)) return 0.0;
    return hat(position, POSITIONS, (motion[0] - r->least_m) / (r->most_m - r->least_m)) *
           hat(speed, SPEEDS, fabs(motion[1]) / r->fastest_mps);
}

/* Mean square, N^2, of leg 1's force residual under the reference model. */
static double left_n2(const struct fit_data *d, const double *raw) {
    double sum = 0.0, tests = 0.0;
    for (int i = 0; i < d->residual->tests; i++, tests++)
        for (int a = 0; a < d->residual->test[i].size; a++) sum += d->residual->test[i].weight[a] * square(raw[i * ROW + a]);
    return sum / tests;
}

static void find_features(struct covariance *c, const struct fit_data *d, double size_n) {
    struct range r = range_of(d->residual);
    c->features = FEATURES;
    c->feature = memory_get((size_t)FEATURES * (size_t)d->values, sizeof *c->feature);
    for (int f = 0; f < FEATURES; f++) {
        residual_row *row = (residual_row *)(c->feature + (size_t)f * (size_t)d->values);
        for (int i = 0; i < d->residual->tests; i++) {
            const struct residual_test *t = &d->residual->test[i];
            for (int k = 0; k < t->phases; k++) {
                double motion[3];
                motion_at(t, k, motion);
                double value = size_n * feature_at(f, &r, motion);
                for (int a = 0; a < t->size && value != 0.0; a++) row[i][0][RESIDUAL_FORCE][a] += t->project[k][a] * value;
            }
            whiten(&d->whitener[i], row[i]);
        }
    }
}

void covariance_init(struct covariance *c, const struct diagnosis *reference, const struct fit_data *d) {
    size_t values = (size_t)d->values;
    *c = (struct covariance){.values = d->values,
                             .evaluated = memory_get(values, sizeof *c->evaluated),
                             .spread = memory_get(values, sizeof *c->spread),
                             .law = memory_get(values, sizeof *c->law),
                             .least = memory_get(values, sizeof *c->least)};
    double *white = memory_get((size_t)reference->fit.values, sizeof *white);
    for (int i = 0; i < d->values; i++) c->evaluated[i] = inverse_of(d, i) > 0.0;
    if (fit_residual(&reference->fit, &reference->model, white)) find_spread(c, &reference->fit, white, d);
    free(white);
    for (int family = 0; family < EFFECT_FAMILIES; family++) add_family(c, reference, d, family);
    if (params_legs(reference->given) == 1) find_features(c, d, sqrt(left_n2(&reference->fit, reference->raw)));
}

void covariance_free(struct covariance *c) {
    free(c->evaluated);
    free(c->spread);
    free(c->law);
    free(c->least);
    free(c->feature);
}

double covariance_of(const struct covariance *c, const struct covariance_size *size, int i) {
    return 1.0 + square(size->spread) * c->spread[i] + c->least[i] + square(size->law) * c->law[i];
}
