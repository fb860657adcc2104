#include "places.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "units.h"

enum { FEATURES = 6, POINTS = 128 };

static const char *const feature_names[FEATURES] = {"static", "peak_speed", "peak_acceleration", "velocity_reversal", "spool_reversal",
                                                    "one_direction"};

static double sign(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }

/* What the residual of a leg looks like most: the share of its square that a template of the motion takes. */
static const char *feature(const struct residual_test *t, int leg, const double *residual) {
    const struct spectrum *s = &t->spectrum;
    double product[FEATURES] = {0}, square[FEATURES] = {0}, mean = residual[0], best = -1.0;
    int found = 0;
    for (int i = 0; i < POINTS; i++) {
        double t_s = 2.0 * PI * i / POINTS / s->omega, motion[3], valve[3], r[3];
        spectrum_value(s->mean[CHANNEL_LENGTH][leg], t->harmonics, s->omega, t_s, motion);
        spectrum_value(s->mean[CHANNEL_VALVE][leg], s->harmonics, s->omega, t_s, valve);
        spectrum_value(residual, t->harmonics, s->omega, t_s, r);
        double shape[FEATURES] = {1.0, motion[1], motion[2], sign(motion[1]), sign(valve[0]), fabs(motion[1])};
        for (int f = 0; f < FEATURES; f++) {
            product[f] += shape[f] * (f == 0 ? mean : r[0] - mean);
            square[f] += shape[f] * shape[f];
        }
    }
    for (int f = 0; f < FEATURES; f++) {
        double share = square[f] > 0.0 ? product[f] * product[f] / square[f] : 0.0;
        if (share > best) best = share, found = f;
    }
    return feature_names[found];
}

static enum gap_channel channel_of(int kind) {
    return kind == RESIDUAL_FORCE ? GAP_FORCE : kind == RESIDUAL_P1 ? GAP_P1 : GAP_P2;
}

static int by_share(const void *a, const void *b) {
    const struct gap_place *x = a, *y = b;
    return x->share < y->share ? 1 : x->share > y->share ? -1 : 0;
}

int places_find(const struct diagnosis *d, const struct recording *recording, const struct params *model,
                struct gap_place place[GAP_PLACES]) {
    int tests = d->odd.tests, all = tests * LEGS * RESIDUALS * (1 + RESIDUAL_HARMONICS), n = 0;
    struct gap_place *list = calloc((size_t)all, sizeof *list);
    double whole = 0.0;
    for (int i = 0; i < tests && list; i++) {
        residual_row raw, white;
        if (!residual_evaluate(&d->odd.test[i], model, PART_ALL, raw)) continue;
        memcpy(white, raw, sizeof white);
        whiten(&d->held_out.whitener[i], white);
        for (int k = 0; k < LEGS; k++)
            for (int q = 0; q < RESIDUALS; q++)
                for (int h = 0; h <= d->odd.test[i].harmonics; h++) {
                    double share = 0.0;
                    for (int a = h ? 2 * h - 1 : 0; a <= 2 * h; a++) share += white[k][q][a] * white[k][q][a];
                    if (!(share > 0.0)) continue; /* not evaluated */
                    list[n++] = (struct gap_place){.test = recording->test[i].test, .dof = recording->test[i].dof,
                                                   .frequency_hz = recording->test[i].frequency_hz, .leg = k, .harmonic = h,
                                                   .channel = channel_of(q), .share = share,
                                                   .feature = feature(&d->odd.test[i], k, raw[k][q])};
                    whole += share;
                }
    }
    if (n) qsort(list, (size_t)n, sizeof *list, by_share);
    if (n > GAP_PLACES) n = GAP_PLACES;
    for (int i = 0; i < n; i++) place[i] = list[i], place[i].share /= whole;
    free(list);
    return n;
}
