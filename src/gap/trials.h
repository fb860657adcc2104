/* Selects the hypotheses that are tried beside the model, and their order. Worker threads; heap. */
#ifndef HEXID_TRIALS_H
#define HEXID_TRIALS_H

#include "trial.h"

/* Tries hypotheses beside the model, a thread each: first every effect with all legs alike; then
 * the closest ones for single legs with the largest residuals and for legs that the trial with a
 * value for each leg singles out. The best trials, and those that the held-out cycles
 * contradict, are polished and sorted first, by their evidence. Returns the number of trials, at
 * most HYPOTHESES_MAX, for which there must be room. They point to the hypotheses in d, which
 * the next fit of the model lists anew. */
int trials_run(const struct diagnosis *d, struct trial *trial);

#endif
