/* Finds the frequency at which the legs move in a test, which need not be the stated one. For a
 * sinusoid the relative error is below 1e-5. Pure. */
#ifndef HEXID_FREQUENCY_H
#define HEXID_FREQUENCY_H

#include "recording.h"

/* Finds the frequency of the test's evaluated part, Hz. The search starts at near_hz, and tries
 * other frequencies only if most of the motion is not at near_hz. reference: the log has a
 * reference. If the legs follow the reference, its frequency is returned, because that is exact
 * even while the amplitude settles. Returns NaN if the evaluated part has fewer than two periods of
 * the motion. */
double frequency_fit(const struct recording_test *t, int legs, bool reference, double near_hz);

#endif
