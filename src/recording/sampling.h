/* When a test was sampled: rate, jitter and holes, by the rows' own times. Pure; any thread. */
#ifndef HEXID_SAMPLING_H
#define HEXID_SAMPLING_H

#include "recording.h"

struct sampling {
    double step_s;    /* from row to row, what is lost apart */
    double jitter_s;  /* rms of the steps about that, holes apart */
    int64_t lost;     /* rows that are not there */
    double gap_s;     /* the longest step */
};

/* Of all samples of the test, whose times increase. All zero with fewer than two. */
struct sampling sampling_measure(const struct recording_test *test);

#endif
