/* Which hypotheses are tried beside the model so far, and in what order. Worker threads; heap. */
#ifndef HEXID_TRIALS_H
#define HEXID_TRIALS_H

#include "trial.h"

/* Tries hypotheses beside the model so far, a thread each: every effect with all legs alike; then
 * those that came closest in their other shapes, for the legs with most to explain and those that
 * each leg's own values single out. The best ones, and what the cycles held out contradict, are
 * polished and come first, by their evidence. Returns the number of trials, at most HYPOTHESES_MAX,
 * for which there is room. They point to the hypotheses in d, which the next fit of the model lists
 * anew. */
int trials_run(const struct diagnosis *d, struct trial *trial);

#endif
