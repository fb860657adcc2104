/* Any motion: is a test a steady sinusoid, and where it is not, in which band it moves and which
 * pieces of it are evaluated. From the measured lengths alone: what a file says of its motion is a
 * hint. No real time; heap. */
#ifndef HEXID_MOTION_H
#define HEXID_MOTION_H

#include "recording.h"

/* Is the legs' motion in the evaluated part of this one frequency? To 99.5 % of its mean square;
 * where the frequency is the stated one and every cycle repeats, half is enough, for a distorted
 * test is then likelier than another motion. */
bool motion_steady(const struct recording_test *test, int legs, double frequency_hz);

/* Cuts a test into pieces, each of them then a test of the recording, which share its samples.
 * Pieces at rest or with missing samples are left out; from a long record pieces all over it are
 * taken. -2: too short, too little motion, samples missing where it turns, no room; -3: memory. */
int motion_cut(struct recording *r, int test, struct error *error);

#endif
