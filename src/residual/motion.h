/* Decides whether a test is a steady sinusoid. Any other motion is cut into segments, stretches of
 * the record that are evaluated like tests, with lengths that suit the motion's frequency band.
 * Only the measured lengths decide; the motion that the file states is a hint. No real time;
 * heap. */
#ifndef HEXID_MOTION_H
#define HEXID_MOTION_H

#include "recording.h"

/* True if the evaluated part is a steady sinusoid of this frequency, and not another steady motion
 * (segments.h): the sinusoid makes 99.5 % of the legs' mean square motion. Near the stated
 * frequency 50 % suffices if every cycle has at least half the mean amplitude, because a distorted
 * test is then likelier than another motion. False for a frequency of NaN. */
bool motion_sinusoid(const struct recording_test *test, int legs, double frequency_hz);

/* Least number of segments of all records, to fit and judge a model. */
enum { SEGMENTS_NEEDED = 6 };

/* Reasons why a record cannot be cut, in this order: too short to see how it moves, no motion, no
 * room in the recording, samples missing where the speed changes sharply, no segment that can be
 * evaluated. */
enum cut_lacks { CUT_NOTHING, CUT_TIME, CUT_MOTION, CUT_ROOM, CUT_TURNS, CUT_SEGMENTS };

struct motion_cut {
    enum cut_lacks lacks; /* CUT_NOTHING: the record was cut */
    double span_s, segment_s;  /* lengths of the record and of its segments */
    int all, turns; /* number of all segments, and of those in which samples are missing where the
                     * speed changes sharply */
};

/* Cuts a test into segments; each becomes a test of the recording and shares the samples. Segments
 * that are at rest or miss too many samples are excluded, and segments of a long record are spread
 * over all of it. Nothing is cut if the record lacks something (cut->lacks). Returns 0, or -3
 * without memory. */
int motion_cut(struct recording *r, int test, struct motion_cut *cut, struct error *error);

#endif
