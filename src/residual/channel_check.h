/* Refuses a test in which a channel cannot be a sensor's reading: absurd, constant or clipped.
 * Pure; any thread. */
#ifndef HEXID_CHANNEL_CHECK_H
#define HEXID_CHANNEL_CHECK_H

#include "recording.h"

/* Checks the lengths, the pressures or forces, and the valve commands if the recording has them.
 * Returns 0, or -2 with the leg and the reason. */
int channel_check(const struct recording *r, const struct recording_test *t, struct error *error);

#endif
