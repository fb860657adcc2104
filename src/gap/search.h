/* The search: effects are added to the model, the most likely first, as long as the gain exceeds
 * the parameters' penalty; effects that are no longer needed are removed. Ordinary threads;
 * heap. */
#ifndef HEXID_SEARCH_H
#define HEXID_SEARCH_H

#include "diagnose.h"

struct gap_options;

/* Searches the effects of the machine and fills the result's effects, candidates, rivals and base
 * values. */
void search_effects(struct diagnosis *d, const struct recording *measured, const struct gap_options *options, struct gap_result *result);

/* Fills the result's base values from the diagnosis' last fit. */
void search_read_base(const struct diagnosis *d, struct gap_result *result);

#endif
