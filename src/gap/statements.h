/* Statements: which effects, or families of effects, the machine has, each with its probability.
 * This is the sum over the sets (sets.h) in which the statement is true. Ordinary threads; heap. */
#ifndef HEXID_STATEMENTS_H
#define HEXID_STATEMENTS_H

#include "sets.h"

/* Compares sets of effects by their evidence and fills r->statement. If statements are sure and the
 * held-out cycles confirm them, puts their effects into r and the diagnosis, and returns true.
 * Otherwise returns false; r's effects and the model of d must then not be used any more. */
bool statements_find(struct diagnosis *d, struct gap_result *r);

/* Finds the probability that the machine has the effects of a result, and of those that it cannot
 * tell apart exactly one; NaN if the set that was found cannot be compared. Compared are this set,
 * those that lack one of its effects, the base without any, and the sets that were tried. The
 * priors are those of the search. The diagnosis is unusable afterwards. */
struct gap_certainty statements_certainty(struct diagnosis *d, const struct gap_result *r, const struct set *found, int sets,
                                          const struct set *tried);

#endif
