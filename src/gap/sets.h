/* Sets of effects under a remainder: on a real machine no law is exact, so something is always
 * left. Each set of at most four effects has one number, its evidence, under a covariance that
 * includes the remainder; the probability of a statement is that of the sets in which it is
 * true. Ordinary threads; heap. */
#ifndef HEXID_SETS_H
#define HEXID_SETS_H

#include "diagnose.h"

/* Compares sets of effects by their evidence and fills r->statement. If statements are sure and the
 * held-out cycles confirm them, their effects become those of r and of the diagnosis, and true is
 * returned; otherwise r's effects, and the model of d, are not to be used any more. */
bool sets_compare(struct diagnosis *d, struct gap_result *r);

#endif
