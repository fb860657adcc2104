/* The frequency at which the legs move in a test, independent of the stated one. On a sinusoid its
 * relative error is below 1e-5. Pure. */
#ifndef HEXID_FREQUENCY_H
#define HEXID_FREQUENCY_H

#include "recording.h"

/* Finds the frequency of the test's evaluated part. The search starts at near_hz, and tries other
 * frequencies only if most of the motion is not at near_hz. reference: the log has a reference; if
 * the legs follow it, its frequency is returned, which is exact even while the amplitude settles.
 * NaN if the evaluated part has fewer than two periods of the motion. */
double frequency_fit(const struct recording_test *t, int legs, bool reference, double near_hz);

#endif
