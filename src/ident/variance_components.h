/* How large the unknowns are that a machine may have or not, by kind: shapes of dry friction, each in all six legs, and external stiffness
 * (prior.h). A kind that is not in the machine then costs nothing, and one that is, is held back by no more than what it is not.
 *
 * The unknowns of a kind are draws of mean 0 and deviation size times their unit. The sizes are those that make the data, of all logs together,
 * most likely with all that is fitted integrated out (restricted maximum likelihood, Patterson and Thompson 1971; evidence, MacKay 1992, of
 * whose fixed point these are steps): size^2 = sum (x / unit)^2 over the number of unknowns that the data determine, sum (1 - variance / prior
 * variance). Pure, no heap. */
#ifndef HEXID_VARIANCE_COMPONENTS_H
#define HEXID_VARIANCE_COMPONENTS_H

#include "prior.h"

/* From the sizes in `p`; what is 0 stays so. False: some unknown is in no row. */
bool variance_components_find(const struct equations *e, struct prior *p);

#endif
