/* Checks whether the configured controller gives the recorded commands: it is run again on the
 * recorded lengths, pressures and references. A difference is a difference of controllers, never
 * an effect of the machine. Pure. */
#ifndef HEXID_CONTROLLER_H
#define HEXID_CONTROLLER_H

#include "recording.h"

/* Rms difference between recorded and recomputed commands over all tests, as a share of the rms
 * variation of the recorded ones. A constant is removed for each leg and gapless stretch,
 * because the integrator's initial value is unknown. NaN on a single axis, if references,
 * commands or pressures are missing, and if the log's rate is not the controller's. */
double controller_difference(const struct params *params, const struct recording *recording);

/* Time between samples if it differs from the controller's cycle; else 0. */
double controller_other_rate(const struct params *params, const struct recording *recording);

#endif
