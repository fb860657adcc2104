#include "frequency.h"

#include <math.h>
#include <stddef.h>

#include "dense.h"
#include "units.h"

static const double OF_FREQUENCY = 0.5;  /* if more than this share of the variance is at near_hz,
                                          * no other frequency is searched */
static const double SEARCH_S = 10.0;     /* length of the part in which a frequency is searched,
                                          * because searching an hour would take too long; the
                                          * part is longer if SEARCH_CYCLES cycles of near_hz
                                          * take longer */
/* The legs follow the reference if their frequency differs from the reference's by less than this
 * share. The share is not 0, because the legs may still be settling. */
static const double FOLLOWED = 1e-3;
enum { ITERATIONS = 8, REPEATS_LEAST = 2, SEARCH_CYCLES = 8 };

/* A group of channels: `count` numbers side by side in a sample, `offset` bytes from its start. */
struct signals {
    size_t offset;
    int count;
};

static double value_of(const struct recording_sample *s, struct signals of, int k) {
    return ((const double *)(const void *)((const char *)s + of.offset))[k];
}

/* Sinusoid s sin wt + c cos wt of one frequency, as fitted to a signal by least squares together
 * with a constant. */
struct wave {
    double s, c;
    double variance; /* variance of the signal */
};

static struct wave wave_at(const struct recording_test *t, struct signals of, int k, double hz, double from_s, double until_s) {
    double h[9] = {0}, g[3] = {0}, square = 0.0, zero = 0.0;
    for (int i = t->first; i < t->end && t->sample[i].test_time_s < until_s; i++) {
        const struct recording_sample *s = &t->sample[i];
        if (s->refused || s->test_time_s < from_s) continue;
        if (!(h[0] > 0.0)) zero = value_of(s, of, k);
        double phase = 2.0 * PI * hz * s->test_time_s, row[3] = {1.0, sin(phase), cos(phase)}, x = value_of(s, of, k) - zero;
        for (int a = 0; a < 3; a++) {
            g[a] += row[a] * x;
            for (int b = 0; b <= a; b++) h[3 * a + b] += row[a] * row[b];
        }
        square += x * x;
    }
    double n = h[0], mean = g[0] / n;
    if (!(n > 3.0) || !dense_factor(3, 3, h)) return (struct wave){0};
    dense_solve(3, 3, h, g);
    return (struct wave){g[1], g[2], fmax(square / n - mean * mean, 0.0)};
}

/* Share of the variance of a group of channels that is at one frequency. */
static double share_at(const struct recording_test *t, struct signals of, double hz, double until_s) {
    double of_frequency = 0.0, all = 0.0;
    for (int k = 0; k < of.count; k++) {
        struct wave w = wave_at(t, of, k, hz, -HUGE_VAL, until_s);
        of_frequency += 0.5 * (w.s * w.s + w.c * w.c), all += w.variance;
    }
    return all > 0.0 ? of_frequency / all : 0.0;
}

/* Selects the channel of the group that moves most, and finds the frequency with the largest share
 * of its variance. Frequencies are tried in steps of a quarter of the resolution 1 / span_s. */
static double search(const struct recording_test *t, struct signals of, double span_s, double until_s) {
    double most = 0.0, best = 0.0, hz = (double)NAN;
    struct signals one = {of.offset, 1};
    for (int k = 0; k < of.count; k++) {
        struct wave w = wave_at(t, of, k, REPEATS_LEAST / span_s, -HUGE_VAL, until_s);
        if (w.variance > most) most = w.variance, one.offset = of.offset + (size_t)k * sizeof(double);
    }
    for (double f = REPEATS_LEAST / span_s; f < RECORDING_FASTEST_HZ; f += 0.25 / span_s) {
        double share = share_at(t, one, f, until_s);
        if (share > best) best = share, hz = f;
    }
    return hz;
}

/* Error of a frequency, Hz, from the phase shift between the two halves of the span. Each half is
 * cut to whole cycles. */
static double turn(const struct recording_test *t, struct signals of, double hz, double start_s, double span_s) {
    double half_s = floor(0.5 * span_s * hz) / hz;
    double along = 0.0, across = 0.0;
    for (int k = 0; k < of.count; k++) {
        struct wave a = wave_at(t, of, k, hz, start_s, start_s + half_s),
                    b = wave_at(t, of, k, hz, start_s + half_s, start_s + 2.0 * half_s);
        along += a.s * b.s + a.c * b.c, across += a.s * b.c - a.c * b.s;
    }
    return half_s > 0.0 ? atan2(across, along) / (2.0 * PI * half_s) : (double)NAN;
}

static double refine(const struct recording_test *t, struct signals of, double hz, double start_s, double span_s) {
    double step = HUGE_VAL;
    for (int i = 0; i < ITERATIONS && fabs(step) > 1e-9 * hz; i++) hz += step = turn(t, of, hz, start_s, span_s);
    return hz;
}

static double fit(const struct recording_test *t, struct signals of, double near_hz) {
    double start_s = t->sample[t->first].test_time_s, span_s = t->sample[t->end - 1].test_time_s - start_s;
    double window_s = span_s, hz = near_hz;
    if (!(share_at(t, of, near_hz, HUGE_VAL) > OF_FREQUENCY)) {
        window_s = fmin(span_s, fmax(SEARCH_S, SEARCH_CYCLES / near_hz));
        hz = search(t, of, window_s, start_s + window_s);
    }
    /* the window grows only as the frequency becomes more accurate, so that the number of cycles in
     * it is never wrong by one */
    for (;; window_s = fmin(2.0 * window_s, span_s)) {
        hz = refine(t, of, hz, start_s, window_s);
        if (!(hz * window_s > REPEATS_LEAST)) return (double)NAN;
        if (window_s >= span_s) break;
    }
    /* While a machine settles, the phase of its motion changes, but less and less. Therefore the
     * second half of the record gives a better frequency. */
    if (0.5 * span_s * hz >= SEARCH_CYCLES) hz = refine(t, of, hz, start_s + 0.5 * span_s, 0.5 * span_s);
    return hz;
}

double frequency_fit(const struct recording_test *t, int legs, bool reference, double near_hz) {
    double hz = fit(t, (struct signals){offsetof(struct recording_sample, length_m), legs}, near_hz);
    double asked_hz = reference ? fit(t, (struct signals){offsetof(struct recording_sample, ref), DOFS}, near_hz) : (double)NAN;
    return fabs(hz / asked_hz - 1.0) < FOLLOWED ? asked_hz : hz;
}
