/* Tables of a test, made once for all models: the motion as a Fourier series, and the matrices that
 * project values in time onto coefficient rows. */
#include "residual.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "inverse_dynamics.h"
#include "numeric.h"
#include "params.h"
#include "units.h"
#include "whiten.h"

static const double SETTLE_CYCLES = 1.5; /* run-up of the simulation of a cycle: pressures behind a
                                          * long supply hose then have forgotten their start */
static const double LEAD_S = 2.0;        /* longest run-up of a segment's spools: a spool that
                                          * crosses its range in that time forgets its start */
static const double SUBSTEP_S = 0.5e-3;   /* step of the Runge-Kutta method: its error is 1e-4 of a
                                           * 100 Hz spool's lag */
static const double SLOWER = 1.25;        /* a recording is slower than the commands if its sampling
                                           * period exceeds the command period times this; jitter is
                                           * less */
enum { COUPLING_POINTS = 2048 };

/* Makes t->projection for a cycle: the least squares fit of samples to coefficients, which is exact
 * even if the cycle is no whole number of samples. */
static bool project_cycle(struct residual_test *t) {
    double product[RESIDUAL_SIZE][RESIDUAL_SIZE] = {0}, basis[RESIDUAL_SIZE];
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < t->fitted; i++) {
            double t_s = t->first_s + (t->samples - t->fitted + i) * t->step_s;
            spectrum_basis(t->spectrum.omega * t_s, t->harmonics, basis);
            if (pass) dense_solve(t->size, RESIDUAL_SIZE, product[0], basis);
            for (int a = 0; a < t->size; a++) {
                if (pass) t->projection[a * t->fitted + i] = basis[a];
                else
                    for (int b = 0; b <= a; b++) product[a][b] += basis[a] * basis[b];
            }
        }
        if (!pass && !dense_factor(t->size, RESIDUAL_SIZE, product[0])) return false;
    }
    return true;
}

static void tabulate(struct residual_test *t, double first_phase) {
    for (int i = 0; i < PHASES; i++) spectrum_basis(first_phase + 2.0 * PI * i / PHASES, SPECTRUM_HARMONICS, t->cycle + i * SPECTRUM_SIZE);
}

static int allocate(struct residual_test *t, struct error *error) {
    t->coupling = calloc(RESIDUAL_SIZE, sizeof *t->coupling);
    t->cycle = malloc((size_t)PHASES * SPECTRUM_SIZE * sizeof(double));
    t->basis = calloc(PHASES, sizeof *t->basis);
    t->project = calloc(PHASES, sizeof *t->project);
    t->series = calloc(PHASES, sizeof *t->series);
    t->valve = malloc((size_t)(LEGS * (t->lead + t->samples)) * sizeof(double));
    t->projection = malloc((size_t)(RESIDUAL_SIZE * t->fitted) * sizeof(double));
    bool all = t->coupling && t->cycle && t->basis && t->project && t->series && t->valve && t->projection;
    return all ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
}

/* Stores the commands' noise over the simulated time: the commands less their mean cycle. Each
 * instant takes the nearest sample; without a good sample within half a sampling period, the noise
 * is 0. */
static void take_dither(struct residual_test *t, const struct recording_test *test) {
    double sampling_s = test->measured->step_s;
    for (int i = 0, j = test->first; i < t->samples; i++) {
        double at_s = t->first_s + i * t->step_s, value[3];
        while (j + 1 < test->end && test->sample[j].test_time_s < at_s - 0.5 * sampling_s) j++;
        const struct recording_sample *s = &test->sample[j];
        bool there = !s->refused && fabs(s->test_time_s - at_s) <= 0.5 * sampling_s;
        for (int k = 0; k < LEGS; k++) {
            spectrum_value(t->spectrum.mean[CHANNEL_VALVE][k], t->spectrum.harmonics, t->spectrum.omega, s->test_time_s, value);
            t->dither[i * LEGS + k] = there ? s->valve[k] - value[0] : 0.0;
        }
    }
}

/* Prepares a steady sinusoid, from the harmonics of its mean cycle. */
static int prepare_cycle(struct residual_test *t, const struct recording_test *test, enum cycles which, struct error *error) {
    const struct spectrum *s = measured_spectrum(test, which);
    if (!s)
        return error_set(error, STATUS_USAGE,
                         "test %s: fewer than two whole cycles of %g Hz: the others miss more than a tenth of their "
                         "samples, or a piece at once: lost, flagged or no number",
                         test->dof == DOF_NONE ? "of any motion" : dof_names[test->dof], test->frequency_hz);
    t->spectrum = *s;
    t->harmonics = s->harmonics < RESIDUAL_HARMONICS ? s->harmonics : RESIDUAL_HARMONICS;
    t->size = residual_motion_size(t);
    t->first_s = test->sample[test->first].test_time_s;
    double cycle = 1.0 / test->frequency_hz / t->step_s;
    t->measured = (int)ceil(1.0 / test->frequency_hz / test->measured->step_s - 1e-6);
    t->fitted = (int)ceil(cycle - 1e-6);
    t->samples = (int)ceil(fmax(SETTLE_CYCLES * cycle, MEASURED_SETTLE_S / t->step_s)) + t->fitted;
    t->phases = PHASES;
    int status = allocate(t, error);
    if (status) return status;
    if (!project_cycle(t)) return error_set(error, STATUS_USAGE, "test %d: too few samples a cycle", test->test + 1);
    tabulate(t, 0.0);
    for (int a = 0; a < t->size; a++) {
        t->rate[a] = (a + 1) / 2 * s->omega;
        t->curve[a] = t->rate[a] * t->rate[a];
        t->weight[a] = a ? 0.5 : 1.0;
        t->coupling[a][a] = 1.0;
        for (int ch = 0; ch < CHANNELS; ch++)
            for (int k = 0; k < LEGS; k++)
                t->row[ch][k][a] = s->mean[ch][k][a], t->std[ch][k][a] = hypot(s->std[ch][k][a], s->in_step[ch][k][a]);
        for (int i = 0; i < PHASES; i++) {
            t->basis[i][a] = t->cycle[i * SPECTRUM_SIZE + a];
            t->project[i][a] = t->series[i][a] = t->basis[i][a] / PHASES / t->weight[a];
        }
    }
    for (int i = 0; i < t->samples; i++)
        for (int k = 0; k < LEGS; k++) {
            double value[3];
            spectrum_value(s->mean[CHANNEL_VALVE][k], s->harmonics, s->omega, t->first_s + i * t->step_s, value);
            t->valve[i * LEGS + k] = value[0];
        }
    if (!t->chambers) return STATUS_OK;
    t->dither = malloc((size_t)(LEGS * t->samples) * sizeof(double));
    if (!t->dither) return error_set(error, STATUS_IO, "out of memory");
    take_dither(t, test);
    return STATUS_OK;
}

/* Rises smoothly from 0 to 1 while x goes from -1 to 1; rise(x)^2 + rise(-x)^2 = 1. */
static double rise(double x) { return x <= -1.0 ? 0.0 : x >= 1.0 ? 1.0 : sin(0.25 * PI * (1.0 + sin(0.5 * PI * x))); }

/* Values at t_s of the windowed cosines, one per coefficient, of the segment that begins at
 * start_s. */
static void local_cosines(double t_s, double start_s, double segment_s, double value[RESIDUAL_SIZE]) {
    double x = (t_s - start_s) / segment_s, window = rise(x / MEASURED_OVERLAP) * rise((1.0 - x) / MEASURED_OVERLAP);
    for (int a = 0; a < RESIDUAL_SIZE; a++) value[a] = window * cos(PI * (a + 0.5) * x);
}

/* Length of record, s, that can be used before a segment's first simulated sample: it goes back to
 * the nearest gap, and is at most LEAD_S. */
static double lead_s(const struct recording_test *test, double first_s) {
    double gap_s = residual_gap_s(test->segment_s, test->measured->step_s), from_s = first_s;
    int i = test->first;
    while (i + 1 < test->end && test->sample[i + 1].test_time_s <= first_s) i++;
    for (; i >= 0 && from_s > first_s - LEAD_S && from_s - test->sample[i].test_time_s <= gap_s; i--)
        if (!test->sample[i].refused) from_s = test->sample[i].test_time_s;
    return fmin(first_s - from_s, LEAD_S);
}

/* Fills t->valve with the commands, each held to the next sample. If the recording is slower than
 * the commands, the commands between two samples are interpolated. */
static void hold_commands(struct residual_test *t, const struct recording_test *test) {
    const struct recording_sample *sample = test->sample, *held;
    bool slower = test->measured->step_s > SLOWER * t->step_s;
    int j = 0, next;
    while (j < test->count && sample[j].refused) j++;
    if (j == test->count) return;
    held = &sample[j];
    for (int i = 0; i < t->lead + t->samples; i++) {
        double at_s = t->first_s + (i - t->lead) * t->step_s, share = 0.0;
        for (; j < test->count && sample[j].test_time_s <= at_s + 0.5 * t->step_s; j++)
            if (!sample[j].refused) held = &sample[j];
        for (next = j; next < test->count && sample[next].refused;) next++;
        if (slower && next < test->count) share = (at_s - held->test_time_s) / (sample[next].test_time_s - held->test_time_s);
        if (!(share > 0.0)) next = (int)(held - sample), share = 0.0;
        for (int k = 0; k < LEGS; k++) t->valve[i * LEGS + k] = held->valve[k] + share * (sample[next].valve[k] - held->valve[k]);
    }
}

/* Fills t->projection, which turns a segment's simulated samples into a coefficient row: the
 * least-squares fit of the series, then the projection onto the row, as for measured samples. The
 * run-up is left out. t->coupling, which prepare_segment() has computed as an integral, is replaced
 * by the sum over these samples. share: simulated over measured sampling period. */
static void project_samples(struct residual_test *t, int settling, double share, const double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]) {
    double basis[SPECTRUM_SIZE], weight[RESIDUAL_SIZE][SPECTRUM_SIZE] = {{0}};
    for (int a = 0; a < t->size; a++)
        for (int b = 0; b < SPECTRUM_SIZE; b++)
            for (int c = 0; c < SPECTRUM_SIZE; c++) weight[a][b] += t->coupling[a][c] * inverse[c][b];
    memset(t->coupling, 0, RESIDUAL_SIZE * sizeof *t->coupling);
    for (int i = 0; i < t->fitted; i++) {
        spectrum_basis(t->spectrum.omega * (t->first_s + (settling + i) * t->step_s), SPECTRUM_HARMONICS, basis);
        for (int a = 0; a < t->size; a++) {
            double value = 0.0;
            for (int b = 0; b < SPECTRUM_SIZE; b++) value += share * weight[a][b] * basis[b];
            t->projection[a * t->fitted + i] = value;
            for (int b = 0; b < SPECTRUM_SIZE; b++) t->coupling[a][b] += value * basis[b];
        }
    }
}

/* Makes a segment's coefficient rows of the measured values, and their standard deviations. */
static void take_rows(struct residual_test *t, const double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]) {
    for (int a = 0; a < t->size; a++) {
        double variance = 0.0, curve = 0.0;
        for (int b = 0; b < SPECTRUM_SIZE; b++)
            for (int c = 0; c < SPECTRUM_SIZE; c++) {
                double both = t->coupling[a][b] * inverse[b][c] * t->coupling[a][c],
                       rate = t->spectrum.omega * ((b + 1) / 2) * ((c + 1) / 2);
                variance += both, curve += both * rate * rate * t->spectrum.omega * t->spectrum.omega;
            }
        t->curve[a] = sqrt(fmax(curve, 0.0) / fmax(variance, 1e-300));
        for (int ch = 0; ch < CHANNELS; ch++)
            for (int k = 0; k < LEGS; k++) {
                t->std[ch][k][a] = t->spectrum.noise[ch][k] * sqrt(fmax(variance, 0.0));
                for (int b = 0; b < SPECTRUM_SIZE; b++) t->row[ch][k][a] += t->coupling[a][b] * t->spectrum.mean[ch][k][b];
            }
    }
}

/* Makes t->series, the least squares fit of values at a segment's phases to Fourier
 * coefficients, and t->project, this fit followed by the projection onto the row. */
static bool fit_series(struct residual_test *t) {
    double product[SPECTRUM_SIZE][SPECTRUM_SIZE] = {0};
    for (int i = 0; i < t->phases; i++) {
        memcpy(t->series[i], t->cycle + i * SPECTRUM_SIZE, sizeof t->series[i]);
        for (int a = 0; a < SPECTRUM_SIZE; a++)
            for (int b = 0; b <= a; b++) product[a][b] += t->series[i][a] * t->series[i][b];
    }
    for (int a = 0; a < SPECTRUM_SIZE; a++) product[a][a] += 1e-6 * t->phases;
    if (!dense_factor(SPECTRUM_SIZE, SPECTRUM_SIZE, product[0])) return false;
    for (int i = 0; i < t->phases; i++) dense_solve(SPECTRUM_SIZE, SPECTRUM_SIZE, product[0], t->series[i]);
    for (int i = 0; i < t->phases; i++)
        for (int a = 0; a < t->size; a++)
            for (int b = 0; b < SPECTRUM_SIZE; b++) t->project[i][a] += t->coupling[a][b] * t->series[i][b];
    return true;
}

/* Prepares a segment of any motion, whose row contains local cosines. The chambers' simulation
 * starts before the segment. */
static int prepare_segment(struct residual_test *t, const struct recording_test *test, struct error *error) {
    const struct measured *m = test->measured;
    const struct spectrum *s = measured_spectrum(test, CYCLES_ALL);
    double value[RESIDUAL_SIZE], basis[SPECTRUM_SIZE];
    double segment_s = test->segment_s, begin_s = test->start_s - MEASURED_OVERLAP * segment_s,
           span_s = (1.0 + 2.0 * MEASURED_OVERLAP) * segment_s;
    int settling = t->chambers ? (int)ceil(MEASURED_SETTLE_S / t->step_s) : 0;
    t->first_s = m->first_s;
    t->fitted = (int)(span_s / t->step_s) + 1;
    t->samples = settling + t->fitted;
    t->lead = t->chambers ? (int)(lead_s(test, t->first_s) / t->step_s) : 0;
    t->harmonics = SPECTRUM_HARMONICS;
    double period_s = MEASURED_STRETCH * (begin_s + span_s - t->first_s), omega = 2.0 * PI / period_s;
    /* The highest frequency of a row is at most that of the series. The period of the series
     * includes the run-up, so a short segment gets fewer coefficients. */
    t->size = (int)fmin(2.0 * segment_s * SPECTRUM_HARMONICS / period_s + 0.5, RESIDUAL_SIZE);
    t->phases = (int)(PHASES * span_s / period_s);
    int status = allocate(t, error);
    if (status) return status;
    if (!s)
        return error_set(error, STATUS_USAGE, "at %.4g s: too many samples of a piece of %.3g s are lost, flagged or no number",
                         test->start_s, segment_s);
    t->spectrum = *s;
    tabulate(t, omega * begin_s);
    hold_commands(t, test);
    if (t->chambers && !fast_motion_fit(&t->fast, test, m->step_s, s, t->first_s, m->until_s))
        return error_set(error, STATUS_IO, "out of memory");
    for (int a = 0; a < t->size; a++) t->rate[a] = PI * (a + 0.5) / segment_s, t->weight[a] = 0.5;
    for (int i = 0; i < t->phases; i++) local_cosines(begin_s + i * period_s / PHASES, test->start_s, segment_s, t->basis[i]);
    for (int i = 0; i < COUPLING_POINTS; i++) {
        double t_s = begin_s + (i + 0.5) * span_s / COUPLING_POINTS;
        local_cosines(t_s, test->start_s, segment_s, value);
        spectrum_basis(omega * t_s, SPECTRUM_HARMONICS, basis);
        for (int a = 0; a < t->size; a++)
            for (int b = 0; b < SPECTRUM_SIZE; b++) t->coupling[a][b] += 2.0 / segment_s * span_s / COUPLING_POINTS * value[a] * basis[b];
    }
    project_samples(t, settling, t->step_s / m->step_s, m->inverse);
    take_rows(t, m->inverse);
    return fit_series(t) ? STATUS_OK : error_set(error, STATUS_USAGE, "at %.4g s: too short a piece", test->start_s);
}

static int prepare(struct residual_test *t, const struct recording *recording, int of, enum cycles which, struct error *error) {
    const struct recording_test *test = &recording->test[of];
    t->of = of;
    t->legs = params_legs(recording->params);
    t->pressures = recording->measured.pressures;
    t->chambers = recording->measured.pressures && recording->measured.valve;
    t->in_step = test->measured->in_step, t->step_s = test->measured->command_s;
    t->substeps = (int)ceil(t->step_s / SUBSTEP_S - 1e-6);
    /* Simpson's rule in residual_staircase() needs an even number of substeps. */
    if (t->substeps > 1) t->substeps += t->substeps % 2;
    int status = test->segment_s > 0.0 ? prepare_segment(t, test, error) : prepare_cycle(t, test, which, error);
    if (status) return status;
    for (int k = 0; k < t->legs; k++) t->speed_std_mps[k] = spectrum_speed_std(&t->spectrum, k, t->harmonics);
    whiten_force_std(t, recording->params, t->force_std_n);
    whiten_play_noise(t, recording->params, &t->play_noise);
    return STATUS_OK;
}

/* True if a test is to be prepared: any steady sinusoid, and a segment that is not refused and
 * whose number, even or odd, is in `which`. */
static bool wanted(const struct recording_test *test, enum cycles which) {
    return !(test->segment_s > 0.0) || (!test->refused && which & (test->segment % 2 ? CYCLES_ODD : CYCLES_EVEN));
}

double residual_margin_s(double segment_s) { return MEASURED_OVERLAP * segment_s; }

double residual_gap_s(double segment_s, double step_s) {
    /* one step is subtracted, because a segment begins at a sampling instant */
    return fmax(MEASURED_STRETCH * ((1.0 + 2.0 * MEASURED_OVERLAP) * segment_s - step_s) / (2 * SPECTRUM_HARMONICS), 2.5 * step_s);
}

int residual_prepare(struct residual_data *d, const struct recording *recording, enum cycles which, struct error *error) {
    *d = (struct residual_data){.test = calloc((size_t)recording->tests + 1, sizeof *d->test)};
    if (!d->test) return error_set(error, STATUS_IO, "out of memory");
    for (int i = 0; i < recording->tests; i++) {
        if (!wanted(&recording->test[i], which)) continue;
        int status = prepare(&d->test[d->tests++], recording, i, which, error);
        if (status) return status;
        d->equations = d->test[0].chambers    ? EQUATIONS_ALL
                       : d->test[0].pressures ? EQUATIONS_FORCE
                                              : EQUATIONS_FORCE | EQUATIONS_FORCE_SENSOR;
    }
    return STATUS_OK;
}

int residual_tabulate(struct residual_data *d, struct error *error) {
    for (int i = 0; i < d->tests; i++) {
        struct residual_test *t = &d->test[i];
        int nodes = 2 * t->substeps * t->samples + 1, size = residual_motion_size(t);
        if (!t->chambers) continue;
        t->node = malloc((size_t)nodes * (size_t)size * sizeof(double));
        if (!t->node) return error_set(error, STATUS_IO, "out of memory");
        for (int node = 0; node < nodes; node++) residual_node(t, node, t->node + (size_t)node * (size_t)size);
    }
    return STATUS_OK;
}

void residual_node(const struct residual_test *t, int node, double *basis) {
    double t_s = t->first_s + node * t->step_s / (2 * t->substeps);
    spectrum_basis(t->spectrum.omega * t_s, t->harmonics, basis);
}

void residual_free(struct residual_data *d) {
    for (int i = 0; i < d->tests; i++) {
        free(d->test[i].coupling);
        free(d->test[i].cycle);
        free(d->test[i].basis);
        free(d->test[i].project);
        free(d->test[i].series);
        free(d->test[i].node);
        fast_motion_free(&d->test[i].fast);
        free(d->test[i].valve);
        free(d->test[i].dither);
        free(d->test[i].projection);
    }
    free(d->test);
    *d = (struct residual_data){0};
}
