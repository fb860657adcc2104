#include "measured.h"

#include <math.h>
#include <stdlib.h>

#include "force.h"
#include "frequency.h"
#include "noise.h"
#include "noise_check.h"
#include "numeric.h"
#include "params.h"
#include "residual.h"
#include "rounding.h"
#include "sampling.h"
#include "units.h"

static const double SLOWER = 1.25;        /* a recording is slower than the commands if its sampling
                                           * period exceeds the command period times this; jitter is
                                           * less */
static const double IN_STEP = 1e-3;       /* relative tolerance within which the sampling period
                                           * counts as a whole number of command periods */
static const double FREQUENCY_SAME = 5e-5;  /* largest relative difference of two frequencies that
                                             * count as the same: two crystals differ by less */

/* Finds the command period. hexid's controller commands every cycle, however slow the recording.
 * The command period of another controller is unknown, so it is taken to be the sampling period. */
static void find_commands(struct measured *m, const struct params *params) {
    double cycle_s = params->loop.period_s, many = fmax(round(m->step_s / cycle_s), 1.0);
    bool slower = !params_mechanism(params)->refuses.run && m->step_s > SLOWER * cycle_s;
    m->in_step = !slower || fabs(m->step_s / (many * cycle_s) - 1.0) < IN_STEP;
    m->command_s = !slower ? m->step_s : m->in_step ? m->step_s / many : cycle_s;
}

typedef double resolutions[CHANNELS][LEGS];

/* Finds the resolution of each channel in `read` from its samples: of the sensor, or of the bus or
 * file that the samples came through; 0 if none is found. */
static void find_resolutions(const struct recording_test *test, int legs, int channels, const enum channel *read, resolutions step) {
    for (int k = 0; k < legs; k++)
        for (int i = 0; i < channels; i++) {
            const double *first = spectrum_channel(test->sample, read[i]) + k;
            step[read[i]][k] = noise_measure(test->count, first, sizeof *test->sample / sizeof(double)).step;
        }
}

/* Readings of a test, from which its three spectra are measured. */
struct readings {
    const struct recording_test *test;
    const struct params *params;
    bool pressures;
    int channels;               /* number of channels in `read`, which are read from sensors */
    const enum channel *read;
    resolutions resolution;
    spectrum_cycle *row[CYCLES_ALL]; /* harmonics of each averaged cycle, by enum cycles - 1 */
};

/* Describes how one leg's channel is rounded in the cycles of a spectrum. middle: set to the mean
 * of each cycle. */
static struct rounding rounded(const struct readings *of, const struct spectrum *s, int which, enum channel ch, int leg, double step_s,
                               double middle[CYCLES_MAX]) {
    for (int i = 0; i < s->cycles; i++) middle[i] = of->row[which - 1][i][ch][leg][0];
    return (struct rounding){.step = of->resolution[ch][leg],
                             .scatter = s->scatter[ch][leg],
                             .first_phase = s->omega * of->test->sample[of->test->first].test_time_s,
                             .places = s->offsets * (int)ceil(2.0 * PI / s->omega / step_s - 1e-6),
                             .cycles = s->cycles,
                             .middle = middle};
}

/* Finds the standard deviations that rounding errors in step with a leg's motion give its length,
 * and its pressures and their force A1 P1 - A2 P2, or the reading of its force sensor. */
static void find_in_step(struct measured *m, const struct readings *of, int leg) {
    struct cylinder_areas areas = cylinder_areas(&of->params->actuator);
    double variance[CYCLES_ALL][CHANNELS][SPECTRUM_SIZE] = {{{0}}}, middle[CYCLES_MAX];
    for (const enum channel *c = of->read; c < of->read + of->channels; c++) {
        struct rounding_shares shares = {.tones = 0};
        int places = 0; /* number of places for which `shares` were found */
        /* The mean of all cycles, the most certain one, is first. */
        for (int which = CYCLES_ALL; which >= CYCLES_EVEN; which--) {
            const struct spectrum *s = &m->spectrum[which - 1];
            if (!m->sufficient[which - 1]) continue;
            const struct rounding r = rounded(of, s, which, *c, leg, m->step_s, middle);
            if (r.places != places) rounding_find_shares(&r, s->harmonics, s->mean[*c][leg], &shares), places = r.places;
            rounding_in_step(&r, &shares, s->harmonics, variance[which - 1][*c]);
        }
    }
    for (int i = 0; i < CYCLES_ALL; i++) {
        for (int a = 0; a < SPECTRUM_SIZE && of->pressures; a++)
            variance[i][CHANNEL_FORCE][a] = square(areas.a1_m2[leg]) * variance[i][CHANNEL_P1][a] +
                                            square(areas.a2_m2[leg]) * variance[i][CHANNEL_P2][a];
        for (int ch = 0; ch < CHANNELS; ch++)
            for (int a = 0; a < SPECTRUM_SIZE; a++) m->spectrum[i].in_step[ch][leg][a] = sqrt(variance[i][ch][a]);
    }
}

/* Measures the spectra of a steady sinusoid. */
static int measure_cycles(struct measured *m, const struct recording *r, const struct recording_test *test, struct error *error) {
    static const enum channel chambers[] = {CHANNEL_LENGTH, CHANNEL_P1, CHANNEL_P2}, sensor[] = {CHANNEL_LENGTH, CHANNEL_FORCE};
    bool pressures = r->measured.pressures;
    int legs = params_legs(r->params);
    struct readings of = {
        .test = test, .params = r->params, .pressures = pressures, .channels = pressures ? 3 : 2, .read = pressures ? chambers : sensor};
    spectrum_cycle *room = malloc(CYCLES_ALL * CYCLES_MAX * sizeof *room);
    if (!room) return error_set(error, STATUS_IO, "out of memory");
    find_resolutions(test, legs, of.channels, of.read, of.resolution);
    for (int which = CYCLES_EVEN; which <= CYCLES_ALL; which++) {
        of.row[which - 1] = room + (which - 1) * CYCLES_MAX;
        m->sufficient[which - 1] = spectrum_measure(&m->spectrum[which - 1], of.row[which - 1], test, m->step_s, (enum cycles)which);
    }
    for (int k = 0; k < legs; k++) find_in_step(m, &of, k);
    free(room);
    return STATUS_OK;
}

/* Sampling instant nearest to t_s. A command begins there if the recording is in step with the
 * commands. */
static double sampled_s(const struct recording_test *test, double t_s) {
    int i = test->first;
    while (i + 1 < test->end && test->sample[i + 1].test_time_s <= t_s) i++;
    double before_s = test->sample[i].test_time_s, after_s = test->sample[i + 1 < test->end ? i + 1 : i].test_time_s;
    return t_s - before_s < after_s - t_s ? before_s : after_s;
}

/* Fits the series of a segment. The series begins before the segment, because the simulation of the
 * chambers needs a run-up. */
static void measure_segment(struct measured *m, const struct recording *r, const struct recording_test *test) {
    double margin_s = MEASURED_OVERLAP * test->segment_s, begin_s = test->start_s - margin_s;
    bool chambers = r->measured.pressures && r->measured.valve;
    int settling = chambers ? (int)ceil(MEASURED_SETTLE_S / m->command_s) : 0;
    m->first_s = sampled_s(test, begin_s - settling * m->command_s);
    m->until_s = begin_s + (1.0 + 2.0 * MEASURED_OVERLAP) * test->segment_s;
    double omega = 2.0 * PI / (MEASURED_STRETCH * (m->until_s - m->first_s));
    m->sufficient[0] = spectrum_cut(&m->spectrum[0], test, m->first_s, m->until_s, omega, m->inverse);
}

/* True if a test has an evaluated part of more than one instant. */
static bool lasts(const struct recording_test *t) {
    return t->first >= 0 && t->sample[t->end - 1].test_time_s > t->sample[t->first].test_time_s;
}

int measured_make(struct recording *r, int first, struct error *error) {
    int status = STATUS_OK;
    for (int i = first; i < r->tests && !status; i++) {
        struct recording_test *t = &r->test[i];
        bool segment = t->segment_s > 0.0;
        free(t->measured);
        struct measured *m = t->measured = calloc(1, sizeof *m + (segment ? 1 : CYCLES_ALL) * sizeof *m->spectrum);
        if (!m) return error_set(error, STATUS_IO, "out of memory");
        if (!lasts(t)) continue;
        m->step_s = sampling_step_s(t, t->first, t->end);
        find_commands(m, r->params);
        if (segment) measure_segment(m, r, t);
        else status = measure_cycles(m, r, t, error);
    }
    return status;
}

const struct spectrum *measured_spectrum(const struct recording_test *t, enum cycles which) {
    int i = t->segment_s > 0.0 ? 0 : (int)which - 1;
    return t->measured->sufficient[i] ? &t->measured->spectrum[i] : NULL;
}

static bool has_lengths(const struct recording_test *t, int legs) {
    for (int i = t->first; i < t->end; i++)
        if (all_finite(legs, t->sample[i].length_m)) return true;
    return false;
}

/* Decides whether a test is a steady sinusoid. If so, it gets the frequency at which the legs move,
 * for which the stated frequency is only a hint. If not, it is cut into segments, or removed from
 * `r` if that is impossible. A test with too few good samples stays as it is. */
static int measure_record(struct recording *r, int test, struct measured_record *record, struct error *error) {
    struct recording_test *t = &r->test[test];
    int legs = params_legs(r->params);
    *record = (struct measured_record){.lasts = lasts(t)};
    if (!record->lasts) return STATUS_OK;
    for (int i = t->first; i < t->end; i++) record->good += !t->sample[i].refused;
    record->lengths = has_lengths(t, legs);
    if (!record->lengths || 2 * record->good < t->end - t->first) return STATUS_OK;
    double fitted_hz = t->dof == DOF_NONE ? (double)NAN : frequency_fit(t, legs, r->measured.reference, t->frequency_hz);
    record->sinusoid = motion_sinusoid(t, legs, fitted_hz);
    if (!record->sinusoid) {
        int status = motion_cut(r, test, &record->cut, error);
        if (!status && record->cut.lacks) recording_remove(r, test);
        return status;
    }
    if (fabs(fitted_hz / t->stated_hz - 1.0) > FREQUENCY_SAME) t->frequency_hz = fitted_hz;
    record->frequency_hz = t->frequency_hz;
    return STATUS_OK;
}

/* Stores the tests' measured frequencies in the parameters of the run, so that the run can be
 * simulated at them. */
static void run_at(struct recording *r, int first) {
    double *hz = r->run[r->runs - 1].hz;
    for (int i = first; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        /* false for NaN, the frequency of a motion that is no sinusoid */
        bool other = t->dof != DOF_NONE && fabs(t->frequency_hz / hz[t->dof] - 1.0) > FREQUENCY_SAME;
        if (other) hz[t->dof] = t->frequency_hz;
    }
}

int measured_add(struct measured_recording *m, const struct recording *raw, struct error *error) {
    struct recording *r = &m->recording;
    int from = recording_first_of_run(raw), status = STATUS_OK;
    m->first = r->tests;
    r->params = raw->params, r->measured = raw->measured, r->runs = raw->runs;
    r->run[r->runs - 1] = raw->run[r->runs - 1];
    if (m->first + raw->tests - from > RECORDING_TESTS)
        return error_set(error, STATUS_USAGE, "more than %d tests and pieces of any motion", RECORDING_TESTS);
    for (int i = from; i < raw->tests; i++) {
        r->test[r->tests] = raw->test[i];
        r->test[r->tests].measured = NULL, r->test[r->tests++].borrowed = true;
    }
    for (int i = from, at = m->first; i < raw->tests && !status; i++) {
        int tests = r->tests;
        status = measure_record(r, at, &m->record[i], error);
        at += 1 + r->tests - tests;
    }
    run_at(r, m->first);
    return status ? status : measured_make(r, m->first, error);
}

void measured_free(struct measured_recording *m) { recording_free(&m->recording); }

int measured_noise(struct measured_recording *m, struct error *error) {
    struct residual_data data;
    int status = residual_prepare(&data, &m->recording, CYCLES_ALL, error);
    if (!status) status = noise_check(&m->recording, &data, &m->noise, error);
    residual_free(&data);
    return status;
}
