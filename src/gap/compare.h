/* How large the gap is, before and after: in simulation where the loop can be closed again, else
 * under the measured motion. Ordinary threads; heap. */
#ifndef HEXID_COMPARE_H
#define HEXID_COMPARE_H

#include "diagnose.h"
#include "replay.h"

/* Can its loop be closed again in simulation? -2 with what the log lacks. */
int compare_check(const struct params *params, const struct recording *measured, struct error *error);

/* Of a diagnosis and its result with its models: fills sizes, faults of the replay and matrices.
 * runs: of the tests measured, in closed loop; zeroed before, and the caller's to free. validate
 * may be NULL. 0, or a negative status. */
int compare_models(const struct diagnosis *d, const struct recording *measured, const struct recording *validate,
                   const struct gap_options *options, struct gap_result *result, struct replay runs[2], struct error *error);

/* Every test is one that its run's configuration asks for, and of its axis the only one, since it
 * can state one amplitude: else no run of the model is like it. */
bool compare_can_be_driven(const struct recording *recording);

#endif
