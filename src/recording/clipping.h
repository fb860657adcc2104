/* Finds channels that saturate. Pure. */
#ifndef HEXID_CLIPPING_H
#define HEXID_CLIPPING_H

#include "recording.h"

/* Range of a channel: it saturates at `top`, HUGE_VAL if unknown, and is read in steps of `step`, 0
 * if unknown. smooth: a length, which does not jump and saturates at both ends. */
struct recording_scale {
    double top, step;
    bool smooth;
};

/* Number of samples in the test's evaluated part at which the channel is saturated; 0 if there are
 * so few that the motion itself may have caused them. first: the channel's value in the first
 * sample of this part. */
int recording_clipped(const struct recording_test *t, const double *first, const struct recording_scale *scale);

#endif
