/* Refuses lengths that the configured machine cannot have. Pure; any thread. */
#ifndef HEXID_LENGTH_CHECK_H
#define HEXID_LENGTH_CHECK_H

#include "kinematics.h"
#include "recording.h"

/* Checks the lengths of a test. k: NULL for a single axis. any: the motion is no steady sinusoid,
 * so it may be far from neutral. Returns 0, or -2 with the reason and, if known, the leg and the
 * order in which the joints are listed. */
int length_check(const struct params *p, const struct recording_test *t, const struct kinematics *k, bool any, struct error *error);

#endif
