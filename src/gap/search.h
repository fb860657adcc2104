/* The search: effects are added to the model, the most likely first, as long as the gain exceeds
 * the parameters' penalty; effects that are no longer needed are removed. Ordinary threads;
 * heap. */
#ifndef HEXID_SEARCH_H
#define HEXID_SEARCH_H

#include "sets.h"

struct gap_options;

/* The set that the search found, and the sets whose evidence came near to that of the best one in a
 * round of the search. */
enum { TRIED_MAX = 40 };
struct tried {
    struct set found;
    int sets;
    struct set set[TRIED_MAX];
};

/* Searches the effects of the machine. Fills the result's effects, candidates, rivals and base
 * values. tried: zeroed by the caller. */
void search_effects(struct diagnosis *d, const struct recording *measured, const struct gap_options *options, struct gap_result *result,
                    struct tried *tried);

/* Fills the result's base values from the diagnosis' last fit. */
void search_read_base(const struct diagnosis *d, struct gap_result *result);

#endif
