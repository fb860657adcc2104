/* Selects the hypotheses that are tried beside the model, and their order. Worker threads; heap. */
#ifndef HEXID_TRIALS_H
#define HEXID_TRIALS_H

#include "trial.h"

/* Tries hypotheses beside the model, each on one thread. First it tries every effect with all legs
 * alike; then, for the best effects, the single legs with the largest residuals, a value for each
 * leg, and the single leg that stands out among these values. The best trials, and those that the
 * held-out cycles contradict, are polished and sorted by their evidence, best first. Returns the
 * number of trials, for which `trial` needs room of HYPOTHESES_MAX. The trials point to the
 * hypotheses in d, which the next fit of the model lists anew. */
int trials_run(const struct diagnosis *d, struct trial *trial);

#endif
