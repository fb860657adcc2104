/* Statements: which effects, or families of effects, the machine has, each with its probability. A
 * statement's probability is the sum of the probabilities of the sets (sets.h) in which it is true.
 * Ordinary threads; heap. */
#ifndef HEXID_STATEMENTS_H
#define HEXID_STATEMENTS_H

#include "sets.h"

/* Compares sets of effects by their evidence and fills r->statement. If statements are sure and the
 * held-out cycles confirm them, puts their effects into r and the diagnosis, and returns true.
 * Otherwise returns false; the effects in r and the model of d must then not be used any more. */
bool statements_find(struct diagnosis *d, struct gap_result *r);

/* True if no effect of a result has an exact law, which a large remainder refutes; always true for
 * a machine of one leg. */
bool statements_empirical(const struct gap_result *r);

/* Compares the set that a search found with these others:
 *   - sets that lack one of its effects;
 *   - sets in which limiting cases replace effects of any of these sets;
 *   - sets in which two effects of the bodies (masses, mass centres, inertias) replace an effect
 *     that both together look like;
 *   - the base without effects;
 *   - the sets that were tried.
 * Returns true if a simpler set explains about as much or is likelier, after putting its effects
 * into r, the diagnosis and `found`. A simpler set has limiting cases in place of effects, or fewer
 * of the effects. A set in which a parameter of a law's form is at the end of its range is not
 * compared. Otherwise returns false; the diagnosis is then unusable. certainty: probability that
 * the machine has the effects of the result, and exactly one of those that the result cannot tell
 * apart; NaN if the set of the result cannot be compared. The priors are those of the search; on a
 * single axis they are scaled to the gap. */
bool statements_weigh(struct diagnosis *d, struct gap_result *r, struct set *found, int sets, const struct set *tried,
                      struct gap_certainty *certainty);

#endif
