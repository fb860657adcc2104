#include "frequency.h"

#include <math.h>

#include "dense.h"
#include "units.h"

static const double MOST_HZ = 40.0;      /* no platform is tested faster */
static const double OF_FREQUENCY = 0.5;  /* of the motion's square: it moves at this frequency */
static const double SEARCH_S = 10.0;     /* an hour's record is not searched as a whole */
enum { ITERATIONS = 8, CYCLES_LEAST = 2, SEARCH_CYCLES = 8 };

/* The sinusoid of a frequency in a leg's length, s sin wt + c cos wt, by least squares
 * with a constant. */
struct wave {
    double s, c;
    double variance; /* of the length */
};

static struct wave wave_at(const struct recording_test *t, int leg, double hz, double from_s, double until_s) {
    double h[9] = {0}, g[3] = {0}, square = 0.0, zero = 0.0;
    for (int i = t->first; i < t->end && t->sample[i].test_time_s < until_s; i++) {
        const struct recording_sample *s = &t->sample[i];
        if (!s->good || s->test_time_s < from_s) continue;
        if (!(h[0] > 0.0)) zero = s->length_m[leg];
        double phase = 2.0 * PI * hz * s->test_time_s, row[3] = {1.0, sin(phase), cos(phase)}, x = s->length_m[leg] - zero;
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

/* Share of the motion's square that is of a frequency. */
static double share_at(const struct recording_test *t, int from_leg, int legs, double hz, double until_s) {
    double of_frequency = 0.0, all = 0.0;
    for (int k = from_leg; k < from_leg + legs; k++) {
        struct wave w = wave_at(t, k, hz, -HUGE_VAL, until_s);
        of_frequency += 0.5 * (w.s * w.s + w.c * w.c), all += w.variance;
    }
    return all > 0.0 ? of_frequency / all : 0.0;
}

/* Where the leg that moves most has most of its motion, to an eighth of a resolution. */
static double search(const struct recording_test *t, int legs, double span_s, double until_s) {
    double most = 0.0, best = 0.0, hz = (double)NAN;
    int leg = 0;
    for (int k = 0; k < legs; k++) {
        struct wave w = wave_at(t, k, CYCLES_LEAST / span_s, -HUGE_VAL, until_s);
        if (w.variance > most) most = w.variance, leg = k;
    }
    for (double f = CYCLES_LEAST / span_s; f < MOST_HZ; f += 0.25 / span_s) {
        double share = share_at(t, leg, 1, f, until_s);
        if (share > best) best = share, hz = f;
    }
    return hz;
}

/* From the phases of two halves of whole cycles. */
static double turn(const struct recording_test *t, int legs, double hz, double start_s, double span_s) {
    double half_s = floor(0.5 * span_s * hz) / hz;
    double along = 0.0, across = 0.0;
    for (int k = 0; k < legs; k++) {
        struct wave a = wave_at(t, k, hz, start_s, start_s + half_s), b = wave_at(t, k, hz, start_s + half_s, start_s + 2.0 * half_s);
        along += a.s * b.s + a.c * b.c, across += a.s * b.c - a.c * b.s;
    }
    return half_s > 0.0 ? atan2(across, along) / (2.0 * PI * half_s) : (double)NAN;
}

double frequency_fit(const struct recording_test *t, int legs, double near_hz) {
    double start_s = t->sample[t->first].test_time_s, span_s = t->sample[t->end - 1].test_time_s - start_s;
    double window_s = span_s, hz = near_hz;
    if (!(share_at(t, 0, legs, near_hz, HUGE_VAL) > OF_FREQUENCY)) {
        window_s = fmin(span_s, fmax(SEARCH_S, SEARCH_CYCLES / near_hz));
        hz = search(t, legs, window_s, start_s + window_s);
    }
    for (;; window_s = fmin(2.0 * window_s, span_s)) { /* longer as it becomes sure */
        double step = HUGE_VAL;
        for (int i = 0; i < ITERATIONS && fabs(step) > 1e-9 * hz; i++) hz += step = turn(t, legs, hz, start_s, window_s);
        if (!(hz * window_s > CYCLES_LEAST)) return (double)NAN;
        if (window_s >= span_s) return hz;
    }
}
