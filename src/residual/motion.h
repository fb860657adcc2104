/* Decides whether a test is a steady sinusoid; if not, finds the band in which it moves and cuts it
 * into pieces: segments of the record that are evaluated like tests. Only the measured lengths
 * decide; the file's statement about its motion is a hint. No real time; heap. */
#ifndef HEXID_MOTION_H
#define HEXID_MOTION_H

#include "recording.h"

/* True if the legs move at this one frequency in the evaluated part: 99.5 % of the mean square. At
 * the stated frequency half is enough if every cycle repeats, for a distorted test is then likelier
 * than another motion. */
bool motion_steady(const struct recording_test *test, int legs, double frequency_hz);

/* Cuts a test into pieces; each becomes a test of the recording and shares its samples. Pieces at
 * rest or with missing samples are left out; from a long record pieces are taken all over it. -2:
 * too short, too little motion, samples missing where it turns, no room; -3: memory. */
int motion_cut(struct recording *r, int test, struct error *error);

#endif
