/* Sampling of a test: period, jitter and gaps, from the samples' own times. Pure; any thread. */
#ifndef HEXID_SAMPLING_H
#define HEXID_SAMPLING_H

#include "recording.h"

struct sampling {
    double step_s;    /* sampling period (sampling_step_s) */
    double jitter_s;  /* rms deviation of the steps from step_s; gaps do not count */
    int64_t lost;     /* number of samples missing in gaps */
    double gap_s;     /* longest time between two successive samples */
};

/* Mean period of the samples first <= i < end of a test, s. Gaps do not count, even if they make up
 * most of the time. NaN with fewer than two samples. */
double sampling_step_s(const struct recording_test *test, int first, int end);

/* Measures all samples of the test, whose times must increase. All results are zero with fewer than
 * two samples. */
struct sampling sampling_measure(const struct recording_test *test);

#endif
