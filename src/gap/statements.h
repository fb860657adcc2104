/* Statements: which effects, or families of effects, the machine has, each with its probability.
 * This is the sum over the sets (sets.h) in which the statement is true. Ordinary threads; heap. */
#ifndef HEXID_STATEMENTS_H
#define HEXID_STATEMENTS_H

#include "sets.h"

/* Compares sets of effects by their evidence and fills r->statement. If statements are sure and the
 * held-out cycles confirm them, puts their effects into r and the diagnosis, and returns true.
 * Otherwise returns false; r's effects and the model of d must then not be used any more. */
bool statements_find(struct diagnosis *d, struct gap_result *r);

/* True if no effect of a result has an exact law, which a large remainder refutes; always true for
 * a machine of one leg. */
bool statements_empirical(const struct gap_result *r);

/* Compares the set that a search found with those that lack one of its effects, with those in which
 * limiting cases replace effects of these, with those in which two bodies replace one that they
 * look like together, with the base without any, and with the sets that were tried. If a limiting
 * case explains about as much, or the law that it replaces is at the end of its range, or fewer of
 * the effects are likelier, puts the simpler effects into r, the diagnosis and `found`, and returns
 * true; otherwise the diagnosis is unusable afterwards. certainty: probability that the machine has
 * the effects of the result, and of those that it cannot tell apart exactly one; NaN if its set
 * cannot be compared. The priors are those of the search. */
bool statements_weigh(struct diagnosis *d, struct gap_result *r, struct set *found, int sets, const struct set *tried,
                      struct gap_certainty *certainty);

#endif
