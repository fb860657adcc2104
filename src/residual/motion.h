/* Any motion: is a test a steady sinusoid, and where it is not, in which band it moves and which
 * pieces of it are evaluated. From the measured lengths alone: what a file says of its motion is a
 * hint. No real time; heap. */
#ifndef HEXID_MOTION_H
#define HEXID_MOTION_H

#include "recording.h"

/* Nearly all of the legs' motion in the evaluated part is of this one frequency: less than nearly
 * where it is as stated, for then a test that is distorted is likelier than another motion. */
bool motion_steady(const struct recording_test *test, int legs, double frequency_hz);

/* Cuts a test into pieces, each a test of the recording from then on, that share its samples. Those
 * at rest, or with samples missing, are left out; of a long record pieces all over it are taken.
 * -2: too short, too little motion, or no room. */
int motion_cut(struct recording *r, int test, struct error *error);

#endif
