#include "waves.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "memory.h"
#include "residual.h"

typedef double channel_rows[GAP_CHANNELS][SPECTRUM_SIZE];

/* Instants per cycle or segment: at least eight for each period of the highest harmonic. */
enum { WAVE_POINTS = 128 };

double waves_distance(const struct wave_test *t, const double a[SPECTRUM_SIZE], const double b[SPECTRUM_SIZE]) {
    double difference[SPECTRUM_SIZE], square = 0.0;
    for (int i = 0; i < SPECTRUM_SIZE; i++) difference[i] = a[i] - b[i];
    for (int i = 0; i < WAVE_POINTS; i++) {
        double value[3];
        spectrum_value(difference, SPECTRUM_HARMONICS, t->omega, t->from_s + i * t->span_s / WAVE_POINTS, value);
        square += value[0] * value[0] / WAVE_POINTS;
    }
    return sqrt(square);
}

/* Mean square of a row's values about their mean, over the cycle or the segment. */
static double variation(const struct wave_test *t, const double row[SPECTRUM_SIZE]) {
    const double zero[SPECTRUM_SIZE] = {0};
    double sum = 0.0;
    for (int i = 0; i < WAVE_POINTS; i++) {
        double value[3];
        spectrum_value(row, SPECTRUM_HARMONICS, t->omega, t->from_s + i * t->span_s / WAVE_POINTS, value);
        sum += value[0] / WAVE_POINTS;
    }
    return pow(waves_distance(t, row, zero), 2.0) - sum * sum;
}

static void rows(const struct spectrum *s, int leg, channel_rows row) {
    memcpy(row[GAP_LENGTH], s->mean[CHANNEL_LENGTH][leg], sizeof *row);
    memcpy(row[GAP_P1], s->mean[CHANNEL_P1][leg], sizeof *row);
    memcpy(row[GAP_P2], s->mean[CHANNEL_P2][leg], sizeof *row);
    memcpy(row[GAP_VALVE], s->mean[CHANNEL_VALVE][leg], sizeof *row);
    memcpy(row[GAP_FORCE], s->mean[CHANNEL_FORCE][leg], sizeof *row);
}

static void put_measured(struct wave_test *t, const struct spectrum *s) {
    t->omega = s->omega;
    for (int leg = 0; leg < LEGS; leg++) {
        double noise[GAP_CHANNELS] = {[GAP_LENGTH] = s->noise[CHANNEL_LENGTH][leg],
                                      [GAP_P1] = s->noise[CHANNEL_P1][leg],
                                      [GAP_P2] = s->noise[CHANNEL_P2][leg],
                                      [GAP_FORCE] = s->noise[CHANNEL_FORCE][leg],
                                      [GAP_VALVE] = s->noise[CHANNEL_VALVE][leg]};
        channel_rows row;
        rows(s, leg, row);
        for (int ch = 0; ch < GAP_CHANNELS; ch++) {
            struct wave *w = &t->wave[ch][leg];
            memcpy(w->measured, row[ch], sizeof *row);
            memcpy(w->before, row[ch], sizeof *row);
            memcpy(w->after, row[ch], sizeof *row);
            w->noise = noise[ch];
        }
    }
}

static void find_variation(struct waves *w) {
    for (int ch = 0; ch < GAP_CHANNELS; ch++) {
        double square = 0.0;
        for (int i = 0; i < w->tests; i++)
            for (int leg = 0; leg < w->legs; leg++) square += variation(&w->test[i], w->test[i].wave[ch][leg].measured);
        w->variation[ch] = sqrt(square / (w->tests * w->legs));
    }
}

/* The model's two rows in struct wave. */
enum side { BEFORE, AFTER };

static double *side_row(struct wave *w, enum side side) { return side == BEFORE ? w->before : w->after; }

static struct wave_test *add_test(struct waves *w, const struct recording_test *test, const struct spectrum *measured) {
    struct wave_test *t = &w->test[w->tests++];
    bool steady = !(test->segment_s > 0.0);
    *t = (struct wave_test){.run = test->run,
                            .test = test->test,
                            .dof = test->dof,
                            .at_s = test->start_s,
                            .segment_s = test->segment_s,
                            .from_s = steady ? 0.0 : test->start_s,
                            .span_s = steady ? 1.0 / test->frequency_hz : test->segment_s};
    put_measured(t, measured);
    return t;
}

static void prepare(struct waves *w, const struct recording *measured) {
    *w = (struct waves){.legs = params_legs(measured->params), .test = memory_get((size_t)measured->tests, sizeof *w->test)};
}

static void put_run(struct waves *w, const struct recording *simulated, enum side side) {
    for (int i = 0; i < w->tests; i++) {
        const struct recording_test *t = recording_find(simulated, w->test[i].run, w->test[i].dof);
        const struct spectrum *s = t ? measured_spectrum(t, CYCLES_ALL) : NULL;
        channel_rows row;
        if (!s) continue;
        for (int leg = 0; leg < LEGS; leg++) {
            rows(s, leg, row);
            for (int ch = 0; ch < GAP_CHANNELS; ch++) memcpy(side_row(&w->test[i].wave[ch][leg], side), row[ch], sizeof *row);
        }
    }
}

void waves_closed_loop(struct waves *w, const struct recording *measured, const struct recording *before, const struct recording *after) {
    prepare(w, measured);
    for (int i = 0; i < measured->tests; i++) {
        const struct spectrum *s = measured_spectrum(&measured->test[i], CYCLES_ALL);
        if (s) add_test(w, &measured->test[i], s);
    }
    put_run(w, before, BEFORE);
    put_run(w, after, AFTER);
    for (int ch = 0; ch < GAP_CHANNELS; ch++) w->evaluated[ch] = true;
    find_variation(w);
}

/* Makes the model's rows of force and pressures: the measured ones less the residuals of the
 * equations. Returns false if the model cannot make the measured motion. */
static bool put_residual(struct wave_test *t, const struct residual_test *residual, const struct params *model, enum side side) {
    static const enum gap_channel channel[RESIDUALS] = {[RESIDUAL_FORCE] = GAP_FORCE, [RESIDUAL_P1] = GAP_P1, [RESIDUAL_P2] = GAP_P2};
    residual_row row;
    if (!residual_evaluate(residual, model, EQUATIONS_ALL, ALL_LEGS, row)) return false;
    for (int leg = 0; leg < LEGS; leg++)
        for (int kind = 0; kind < RESIDUALS; kind++)
            for (int i = 0; i < residual->phases; i++) {
                double value = 0.0, *series = side_row(&t->wave[channel[kind]][leg], side);
                for (int a = 0; a < residual->size; a++) value += residual->basis[i][a] * row[leg][kind][a];
                for (int b = 0; b < 1 + 2 * residual->harmonics; b++) series[b] -= residual->series[i][b] * value;
            }
    return true;
}

int waves_motion(struct waves *w, const struct gap_result *result, const struct recording *measured, struct error *error) {
    struct residual_data data;
    prepare(w, measured);
    int status = residual_prepare(&data, measured, CYCLES_ALL, error);
    for (int i = 0; i < data.tests && !status; i++) {
        struct wave_test *t = add_test(w, &measured->test[data.test[i].of], &data.test[i].spectrum);
        bool made = put_residual(t, &data.test[i], &result->base_model, BEFORE) && put_residual(t, &data.test[i], &result->fitted, AFTER);
        if (!made) w->tests--;
    }
    residual_free(&data);
    w->evaluated[GAP_FORCE] = w->tests > 0;
    w->evaluated[GAP_P1] = w->evaluated[GAP_P2] = w->tests > 0 && measured->measured.pressures && measured->measured.valve;
    find_variation(w);
    return status;
}

void waves_free(struct waves *w) {
    free(w->test);
    *w = (struct waves){0};
}
