/* Sets of effects under a remainder: on a real machine no law is exact, so every model leaves
 * something unexplained. Each set of at most four effects has one number, its evidence, under a
 * covariance that includes the remainder. The probability of a statement is the sum over the sets
 * in which the statement is true. Ordinary threads; heap. */
#ifndef HEXID_SETS_H
#define HEXID_SETS_H

#include "diagnose.h"

/* Compares sets of effects by their evidence and fills r->statement. If statements are sure and the
 * held-out cycles confirm them, puts their effects into r and the diagnosis, and returns true.
 * Otherwise returns false; r's effects and the model of d must then not be used any more. */
bool sets_compare(struct diagnosis *d, struct gap_result *r);

#endif
