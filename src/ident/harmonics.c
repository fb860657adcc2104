#include "harmonics.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "lin.h"

enum { COLUMNS = REGRESSORS_MAX + CHANNELS_MAX, DRIFT = 1, SINE = 2, COSINE = 3 };

static const double condition_limit = 1e5;

void harmonics_reset(struct harmonics *h, double omega, int harmonics, int channels) {
    assert(harmonics >= 1 && harmonics <= HARMONICS_MAX && channels >= 1 && channels <= CHANNELS_MAX);
    *h = (struct harmonics){.harmonics = harmonics, .channels = channels, .regressors = 2 + 2 * harmonics, .omega = omega};
}

/* Fills [1, t, sin wt, cos wt, ...]. Each harmonic after the first is the one before, rotated by w
 * t. */
static void regressors(const struct harmonics *h, double t_s, double *g) {
    double sine, cosine;
    sincos(h->omega * t_s, &sine, &cosine);
    g[0] = 1.0;
    g[DRIFT] = t_s - h->origin_s;
    g[SINE] = sine;
    g[COSINE] = cosine;
    for (int k = 4; k < h->regressors; k += 2) {
        g[k] = g[k - 2] * cosine + g[k - 1] * sine;
        g[k + 1] = g[k - 1] * cosine - g[k - 2] * sine;
    }
}

void harmonics_add(struct harmonics *h, double t_s, const double *values) {
    double row[COLUMNS] = {0}, *channel = row + REGRESSORS_MAX;
    if (h->samples++ == 0) {
        h->origin_s = t_s;
        memcpy(h->offset, values, (size_t)h->channels * sizeof *values);
    }
    regressors(h, t_s, row);
    for (int c = 0; c < h->channels; c++) channel[c] = values[c] - h->offset[c];
    for (int c = 0; c < CHANNELS_MAX; c++) h->square[c] += channel[c] * channel[c];
    /* Whole rows are faster than the lower triangle alone: their length is a compile-time
     * constant. */
    for (int r = 0; r < h->regressors; r++)
        for (int c = 0; c < COLUMNS; c++) h->product[r][c] += row[r] * row[c];
}

/* Normal equations with scaled regressors. The drift is scaled to unit length, all others by the
 * length of the constant: the column of a sine that is sampled only at its zeros then stays short,
 * and shows in the condition number. The right-hand sides are the channels, then two unit vectors
 * for the fundamental, whose solutions are two columns of the inverse. */
struct normal_equations {
    double gram[REGRESSORS_MAX * REGRESSORS_MAX];
    double right[REGRESSORS_MAX * (CHANNELS_MAX + 2)], solution[REGRESSORS_MAX * (CHANNELS_MAX + 2)];
    double scale[REGRESSORS_MAX];
};

static double scaled_solution(const struct harmonics *h, const struct normal_equations *e, int regressor, int column) {
    return e->scale[regressor] * e->solution[regressor * (h->channels + 2) + column];
}

static struct lin_report solve(const struct harmonics *h, struct normal_equations *e) {
    int n = h->regressors, m = h->channels + 2;
    for (int r = 0; r < n; r++) e->scale[r] = 1.0 / sqrt(r == DRIFT ? h->product[r][r] : h->product[0][0]);
    for (int r = 0; r < n; r++) {
        for (int c = 0; c < n; c++) e->gram[r * n + c] = e->scale[r] * e->scale[c] * h->product[r][c];
        for (int c = 0; c < h->channels; c++) e->right[r * m + c] = e->scale[r] * h->product[r][REGRESSORS_MAX + c];
        e->right[r * m + h->channels] = r == SINE ? e->scale[r] : 0.0;
        e->right[r * m + h->channels + 1] = r == COSINE ? e->scale[r] : 0.0;
    }
    return lin_solve_spd(n, m, e->gram, e->right, e->solution);
}

static void read_channel(const struct harmonics *h, const struct normal_equations *e, int c, struct harmonics_fit *fit) {
    double remainder = h->square[c];
    for (int r = 0; r < h->regressors; r++) remainder -= scaled_solution(h, e, r, c) * h->product[r][REGRESSORS_MAX + c];
    remainder = fmax(remainder, 0.0);
    fit->constant[c] = h->offset[c] + scaled_solution(h, e, 0, c);
    fit->drift_per_s[c] = scaled_solution(h, e, DRIFT, c);
    for (int k = 0; k < h->harmonics; k++) {
        fit->sine[c][k] = scaled_solution(h, e, SINE + 2 * k, c);
        fit->cosine[c][k] = scaled_solution(h, e, COSINE + 2 * k, c);
    }
    double variance = remainder / (double)(h->samples - h->regressors);
    double share = (scaled_solution(h, e, SINE, h->channels) + scaled_solution(h, e, COSINE, h->channels + 1)) / 2;
    fit->rms[c] = sqrt(remainder / (double)h->samples);
    fit->std[c] = sqrt(variance * share);
}

bool harmonics_solve(const struct harmonics *h, struct harmonics_fit *fit) {
    struct normal_equations e;
    double *all = (double *)fit;
    memset(fit, 0, sizeof *fit);
    bool solved = h->samples > h->regressors;
    if (solved) {
        struct lin_report report = solve(h, &e);
        fit->condition = sqrt(report.condition);
        solved = report.rank == h->regressors && fit->condition <= condition_limit;
    }
    for (int c = 0; c < h->channels && solved; c++) read_channel(h, &e, c, fit);
    for (size_t i = 0; i < sizeof *fit / sizeof *all && !solved; i++) all[i] = NAN;
    return solved;
}
