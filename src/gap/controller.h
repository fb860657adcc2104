/* Did the configured controller give the recorded commands? It is run again on the recorded
 * lengths, pressures and references: what differs is a controller that differs, never an effect of
 * the machine. Pure. */
#ifndef HEXID_CONTROLLER_H
#define HEXID_CONTROLLER_H

#include "recording.h"

/* Rms over all tests of the difference of the commands, its constant taken off per leg and test,
 * or stretch of it between holes (the integrator's start is not known), as a share of the rms of
 * the recorded commands' variation. NaN on one axis, where references, commands or pressures are
 * missing, and where the log has another rate than the controller. */
double controller_difference(const struct params *params, const struct recording *recording);

/* The time between samples of commands, where that is not the controller's cycle; else 0. */
double controller_other_rate(const struct params *params, const struct recording *recording);

#endif
