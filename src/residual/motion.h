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
 * test is then likelier than another motion. NaN: false. */
bool motion_sinusoid(const struct recording_test *test, int legs, double frequency_hz);

/* Cuts a test into segments; each becomes a test of the recording and shares the samples. Segments
 * at rest or with missing samples are excluded, and segments of a long record are spread over all
 * of it. -2: the record is too short for one segment, moves too little, lacks samples where the
 * speed changes sharply, or there are too many tests; -3: no memory. */
int motion_cut(struct recording *r, int test, struct error *error);

/* Refuses a recording (-2) that has no steady sinusoid and, in all its records together, too few
 * segments to fit and judge a model. */
int motion_enough(const struct recording *r, struct error *error);

#endif
