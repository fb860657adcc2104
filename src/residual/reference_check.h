/* Refuses a recording whose lengths do not follow its reference: a drawing that is turned or
 * mirrored, legs in another order, a wrong sign, wrong units. Pure; any thread. */
#ifndef HEXID_REFERENCE_CHECK_H
#define HEXID_REFERENCE_CHECK_H

#include "kinematics.h"
#include "recording.h"

/* Checks the last run. If there is no reference, a sinusoid of the tested axis that is fitted to
 * the legs takes its place. Returns 0, or -2 with the reason. */
int reference_check(const struct recording *r, const struct kinematics *k, struct error *error);

#endif
