/* The search: effects join the model, the likeliest first, while the gain outweighs the
 * parameters; those that are no longer needed leave. Ordinary threads; heap. */
#ifndef HEXID_SEARCH_H
#define HEXID_SEARCH_H

#include "diagnose.h"

/* Fills the result's effects, candidates, rivals and base. */
void search_effects(struct diagnosis *d, const struct recording *measured, const struct gap_options *options, struct gap_result *result);

#endif
