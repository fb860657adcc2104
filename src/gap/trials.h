/* Selects the hypotheses that are tried beside the model, and their order. Worker threads; heap. */
#ifndef HEXID_TRIALS_H
#define HEXID_TRIALS_H

#include "trial.h"

/* Tries hypotheses beside the model, each on one thread. First it tries every effect with all legs
 * alike; then every effect in the single leg with the largest residuals, the best effects also in
 * the next leg and with a value for each leg, and the single leg that stands out among these
 * values. A value for each leg is also tried for effects that change the force alone, and for those
 * that the base has leg by leg. The best trials, and some that the held-out cycles contradict, are
 * polished; all are sorted, polished ones first, the best evidence first. Returns the number of
 * trials, for which `trial` needs room of HYPOTHESES_MAX. The trials point to the hypotheses in d,
 * which the next fit of the model lists anew. */
int trials_run(const struct diagnosis *d, struct trial *trial);

#endif
