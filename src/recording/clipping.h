/* Channels at the end of what they can read. Pure. */
#ifndef HEXID_CLIPPING_H
#define HEXID_CLIPPING_H

#include "recording.h"

/* What a channel can read: the end of its range, and its steps where they are known.
 * smooth: it cannot jump. */
struct recording_scale {
    double top, step;
    bool smooth;
};

/* Good samples of a test's evaluated part that are at the end of what their channel reads,
 * where those are too many to be the motion's own; else 0. first: the channel's value in
 * the first of them. */
int recording_clipped(const struct recording_test *t, const double *first, const struct recording_scale *scale);

#endif
