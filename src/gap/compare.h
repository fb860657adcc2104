/* Size of the gap before and after the effects: by simulation in closed loop if that is possible,
 * otherwise under the measured motion. Ordinary threads; heap. */
#ifndef HEXID_COMPARE_H
#define HEXID_COMPARE_H

#include "diagnose.h"
#include "replay.h"

struct gap_options;

/* Checks whether the recorded tests can be simulated in closed loop. Returns 0, or -2 with the
 * reason why not. */
int compare_check(const struct params *params, const struct recording *measured, struct error *error);

/* Compares two models, the base and the base with the result's effects, to the recordings. Fills
 * the result's sizes, unexplained_fraction, simulated, tone_simulated, replay_fault and matrices.
 * runs: simulations of the measured tests in closed loop, which the caller zeroes before and frees
 * after (replay_free). validate may be NULL. Returns 0 or a negative status. */
int compare_models(const struct diagnosis *d, const struct recording *measured, const struct recording *validate,
                   const struct gap_options *options, struct gap_result *result, struct replay runs[2], struct error *error);

/* True if a simulated run can repeat the recording's tests. For this, hexid must drive the
 * mechanism, and each test must move one axis at the frequency in the parameters of its run, where
 * measured_add() puts the measured one. No run may have two tests of an axis, because a
 * configuration states one amplitude for an axis. */
bool compare_can_be_driven(const struct recording *recording);

#endif
