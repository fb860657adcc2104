/* Selects the hypotheses that are tried beside the model, and their order. Worker threads; heap. */
#ifndef HEXID_TRIALS_H
#define HEXID_TRIALS_H

#include "trial.h"

/* Tries hypotheses beside the model, each on one thread, in three rounds.
 *   1. Every effect is tried with one value for all legs.
 *   2. Every effect is tried in the single leg with the largest residuals, and the best effects of
 *      round 1 also in the leg with the next largest. The very best are also tried with a value for
 *      each leg, and so are effects that change only the force, and effects of which the base model
 *      has a value for each leg.
 *   3. Effects that gained enough with a value for each leg are tried in one leg alone: the leg
 *      whose value differs most certainly from the given one.
 * Then the best trials are polished, and some that the held-out cycles contradict. All trials are
 * sorted: polished ones come first, and among them those with the best evidence. Returns the number
 * of trials; `trial` needs room for HYPOTHESES_MAX. The trials point to the hypotheses in d, which
 * the next fit of the model, or a change that is undone, lists anew. */
int trials_run(const struct diagnosis *d, struct trial *trial);

#endif
