#include "places.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "inverse_dynamics.h"
#include "memory.h"
#include "units.h"

enum { FEATURES = 6 };

static const char *const feature_names[FEATURES] = {"static",         "peak_speed",   "peak_acceleration", "velocity_reversal",
                                                    "spool_reversal", "one_direction"};

static double sign(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }

/* Feature of the motion that explains the largest share of a leg's squared residual. */
static const char *feature(const struct residual_test *t, int leg, const double *residual) {
    const struct spectrum *s = &t->spectrum;
    double product[FEATURES] = {0}, square[FEATURES] = {0}, mean = 0.0, value[PHASES], best = -1.0;
    int found = 0;
    for (int i = 0; i < t->phases; i++) {
        value[i] = 0.0;
        for (int a = 0; a < t->size; a++) value[i] += t->basis[i][a] * residual[a];
        mean += value[i] / t->phases;
    }
    for (int i = 0; i < t->phases; i++) {
        const double *basis = t->cycle + i * SPECTRUM_SIZE;
        double motion[3], valve[3];
        spectrum_at(s->mean[CHANNEL_LENGTH][leg], t->harmonics, s->omega, basis, motion);
        spectrum_at(s->mean[CHANNEL_VALVE][leg], s->harmonics, s->omega, basis, valve);
        double regressor[FEATURES] = {1.0, motion[1], motion[2], sign(motion[1]), sign(valve[0]), fabs(motion[1])};
        for (int f = 0; f < FEATURES; f++) {
            product[f] += regressor[f] * (f == 0 ? mean : value[i] - mean);
            square[f] += regressor[f] * regressor[f];
        }
    }
    for (int f = 0; f < FEATURES; f++) {
        double share = square[f] > 0.0 ? product[f] * product[f] / square[f] : 0.0;
        if (share > best) best = share, found = f;
    }
    return feature_names[found];
}

static enum gap_channel channel_of(int kind) { return kind == RESIDUAL_FORCE ? GAP_FORCE : kind == RESIDUAL_P1 ? GAP_P1 : GAP_P2; }

static int by_share(const void *a, const void *b) {
    const struct gap_place *x = a, *y = b;
    return x->share < y->share ? 1 : x->share > y->share ? -1 : 0;
}

int places_find(const struct diagnosis *d, const struct recording *recording, const struct params *model,
                struct gap_place place[GAP_PLACES]) {
    int tests = d->odd.tests, all = tests * LEGS * RESIDUALS * RESIDUAL_SIZE, n = 0;
    struct gap_place *list = memory_get((size_t)all, sizeof *list);
    double whole = 0.0;

    for (int i = 0; i < tests; i++) {
        const struct residual_test *t = &d->odd.test[i];
        const struct recording_test *of = &recording->test[t->of];
        residual_row raw, white;
        if (!residual_evaluate(t, model, EQUATIONS_ALL, ALL_LEGS, raw)) continue;
        memcpy(white, raw, sizeof white);
        whiten(&d->held_out.whitener[i], white);

        for (int k = 0; k < LEGS; k++)
            for (int q = 0; q < RESIDUALS; q++)
                for (int a = 0, next = 0; a < t->size; a = next) {
                    double share = 0.0; /* sum of squares of the sine's and the cosine's residual at
                                         * one frequency */
                    for (next = a; next < t->size && t->rate[next] == t->rate[a]; next++) share += white[k][q][next] * white[k][q][next];
                    if (!(share > 0.0)) continue; /* the residual is not evaluated */
                    bool steady = t->spectrum.cycles;
                    list[n++] = (struct gap_place){.test = of->test,
                                                   .dof = of->dof,
                                                   .at_s = of->start_s,
                                                   .segment_s = of->segment_s,
                                                   .frequency_hz = steady ? of->frequency_hz : t->rate[a] / (2.0 * PI),
                                                   .leg = k,
                                                   .harmonic = steady ? (a + 1) / 2 : 1,
                                                   .channel = channel_of(q),
                                                   .share = share,
                                                   .feature = feature(t, k, raw[k][q])};
                    whole += share;
                }
    }

    if (n) qsort(list, (size_t)n, sizeof *list, by_share);
    if (n > GAP_PLACES) n = GAP_PLACES;
    for (int i = 0; i < n; i++) place[i] = list[i], place[i].share /= whole;
    free(list);
    return n;
}
