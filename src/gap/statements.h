/* Statements: which effects, or families of effects, the machine has, each with its probability.
 * This is the sum over the sets (sets.h) in which the statement is true. Ordinary threads; heap. */
#ifndef HEXID_STATEMENTS_H
#define HEXID_STATEMENTS_H

#include "diagnose.h"

/* Compares sets of effects by their evidence and fills r->statement. If statements are sure and the
 * held-out cycles confirm them, puts their effects into r and the diagnosis, and returns true.
 * Otherwise returns false; r's effects and the model of d must then not be used any more. */
bool statements_find(struct diagnosis *d, struct gap_result *r);

#endif
