/* The frequency at which the legs move in a test, whatever was stated: on a sine to 1e-5 of it.
 * Pure. */
#ifndef HEXID_FREQUENCY_H
#define HEXID_FREQUENCY_H

#include "recording.h"

/* Of the evaluated part. near_hz: looked for there first; elsewhere only where most of the motion
 * is not of that frequency. reference: the log has one, and legs that follow it move at its
 * frequency to the last digit, also while their amplitude still settles. NaN: of none that is seen
 * twice. */
double frequency_fit(const struct recording_test *t, int legs, bool reference, double near_hz);

#endif
