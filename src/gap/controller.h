/* Checks whether the configured controller gives the recorded commands, by running it again on the
 * recorded lengths, pressures and references. A difference means that the controller was another
 * one; it is never an effect of the machine. Pure. */
#ifndef HEXID_CONTROLLER_H
#define HEXID_CONTROLLER_H

#include "recording.h"

/* Rms difference between recorded and recomputed commands, divided by the rms variation of the
 * recorded ones, over all tests with a steady sinusoid. A constant is removed for each leg and each
 * stretch without a long loss of samples, because the integrator's initial value is unknown. The
 * control law `model` looks ahead in the reference, which is computed from the test's parameters.
 * With this law, samples whose recorded reference differs from the computed one (in a stopped test)
 * are not compared. NaN for a mechanism that hexid does not drive, if references, commands or
 * pressures are missing, if samples do not come at the controller's rate, or if nothing can be
 * compared. */
double controller_difference(const struct params *params, const struct recording *recording);

/* Time between the samples of the log, s, if it differs from the controller's cycle by more than a
 * hundredth; otherwise 0. Also 0 without commands, or for a mechanism that hexid does not drive. */
double controller_other_rate(const struct params *params, const struct recording *recording);

#endif
