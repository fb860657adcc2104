#include "sampling.h"

#include <math.h>

static const double GAP = 1.5; /* a step is a gap if it is at least this many periods long */
enum { PASSES = 3 };

static double step_at(const struct recording_test *t, int i) { return t->sample[i].test_time_s - t->sample[i - 1].test_time_s; }

double sampling_step_s(const struct recording_test *t, int first, int end) {
    if (end - first < 2) return (double)NAN;
    double step_s = (t->sample[end - 1].test_time_s - t->sample[first].test_time_s) / (end - 1 - first);
    for (int pass = 0; pass < PASSES; pass++) { /* mean of the steps that are not gaps */
        double sum = 0.0;
        int steps = 0;
        for (int i = first + 1; i < end; i++) {
            double step = step_at(t, i);
            if (step < GAP * step_s) sum += step, steps++;
        }
        /* without gaps the first step_s is kept, because it has not the rounding errors of the
         * sum */
        if (steps == end - 1 - first) break;
        step_s = sum / steps;
    }
    return step_s;
}

struct sampling sampling_measure(const struct recording_test *t) {
    if (t->count < 2) return (struct sampling){0};
    struct sampling s = {.step_s = sampling_step_s(t, 0, t->count)};
    double square = 0.0, lost = 0.0;
    int whole = 0;
    for (int i = 1; i < t->count; i++) {
        double step_s = step_at(t, i);
        s.gap_s = fmax(s.gap_s, step_s);
        lost += fmax(1.0, round(step_s / s.step_s)) - 1.0;
        if (step_s < GAP * s.step_s) square += (step_s - s.step_s) * (step_s - s.step_s), whole++;
    }
    s.jitter_s = whole ? sqrt(square / whole) : 0.0;
    s.lost = (int64_t)fmin(lost, 1e15);
    return s;
}
