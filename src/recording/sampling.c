#include "sampling.h"

#include <math.h>

enum { PASSES = 6 };

static double step_at(const struct recording_test *t, int i) { return t->sample[i].test_time_s - t->sample[i - 1].test_time_s; }

struct sampling sampling_measure(const struct recording_test *t) {
    struct sampling s = {0};
    if (t->count < 2) return s;
    double span_s = t->sample[t->count - 1].test_time_s - t->sample[0].test_time_s, square = 0.0, periods = 0.0;
    int whole = 0;
    s.step_s = span_s / (t->count - 1);
    for (int pass = 0; pass < PASSES; pass++) { /* a step is counted as the whole number of periods
                                                 * nearest to it, so that gaps do not lengthen the
                                                 * period */
        periods = 0.0;
        for (int i = 1; i < t->count; i++) periods += fmax(1.0, round(step_at(t, i) / s.step_s));
        s.step_s = span_s / periods;
    }
    for (int i = 1; i < t->count; i++) {
        double step_s = step_at(t, i);
        s.gap_s = fmax(s.gap_s, step_s);
        if (step_s < 1.5 * s.step_s) square += (step_s - s.step_s) * (step_s - s.step_s), whole++;
    }
    s.jitter_s = whole ? sqrt(square / whole) : 0.0;
    s.lost = (int64_t)fmin(periods - (t->count - 1), 1e15);
    return s;
}
