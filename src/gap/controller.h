/* Did the configured controller give the recorded commands? It is run again on the recorded lengths, pressures and references: what differs
 * is a controller that differs, never an effect of the machine. Pure. */
#ifndef HEXID_CONTROLLER_H
#define HEXID_CONTROLLER_H

#include "recording.h"

/* Rms over all tests of the difference of the commands, its constant per test and leg taken off (the integrator's start is not known), as a
 * share of the rms of the recorded commands' variation. NaN where there is no reference. */
double controller_difference(const struct params *params, const struct recording *recording);

#endif
