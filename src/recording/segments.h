/* Splits a test into segments in time: rest, steady repetition, and any other motion (ramps,
 * sweeps, steps). Only the measured lengths decide; the motion that the file states is not used.
 * For sampling rates from 100 Hz to 10 kHz. Ordinary threads; heap. */
#ifndef HEXID_SEGMENTS_H
#define HEXID_SEGMENTS_H

#include "recording.h"

enum segment_kind {
    /* For half a second or longer all legs stay within their noise, or within 0.3 % of their
     * range. */
    SEGMENT_REST,
    /* At least four cycles of one frequency and amplitude. Beyond their noise, successive cycles
     * differ by at most 5 % of the motion, or by up to 20 % if such a difference is usual in the
     * whole segment, as in a loop that oscillates a little. */
    SEGMENT_STEADY,
    SEGMENT_MOVING, /* all other motion */
    SEGMENT_KINDS
};
extern const char *const segment_names[SEGMENT_KINDS]; /* "rest", "steady", "moving" */

struct segment {
    int first, end;      /* samples of the test: first <= i < end */
    enum segment_kind kind;
    double frequency_hz; /* repetition rate of a steady segment, with a relative error of at most
                          * 1e-3; otherwise NaN */
};

/* All segments of a test in order, without gaps, from the first sample to the last. Neighbours
 * differ in kind or frequency. */
struct segments {
    int count;
    struct segment *segment;
};

/* Splits all samples of the test, not only its evaluated part. Refused samples count as lost. Times
 * must increase. step_s: sampling period (sampling.h). With fewer than ten good samples the result
 * is one moving segment. Returns -3 without memory. */
int segments_find(struct segments *p, const struct recording_test *test, double step_s, int legs, struct error *error);
void segments_free(struct segments *p);

/* The segment of this kind with the most samples, or NULL. */
const struct segment *segments_longest(const struct segments *p, enum segment_kind kind);

#endif
