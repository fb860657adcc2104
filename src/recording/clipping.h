/* Finds channels that saturate. Pure. */
#ifndef HEXID_CLIPPING_H
#define HEXID_CLIPPING_H

#include "recording.h"

/* Range of a channel. top: value at which the channel saturates; HUGE_VAL if unknown. step:
 * resolution of its readings; 0 if unknown. smooth: the channel is a length, which does not jump
 * and may saturate at both ends. */
struct recording_scale {
    double top, step;
    bool smooth;
};

/* Number of samples in the test's evaluated part at which the channel is saturated; 0 if there are
 * so few that the motion itself may have caused them. first: points to the channel's value in the
 * first sample of this part; the values of later samples follow at the distance of a struct
 * recording_sample. */
int recording_clipped(const struct recording_test *t, const double *first, const struct recording_scale *scale);

#endif
