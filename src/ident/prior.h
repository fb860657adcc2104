/* What is known of method C's unknowns before any data (equations.h). Pure, no heap. */
#ifndef HEXID_PRIOR_H
#define HEXID_PRIOR_H

#include "equations.h"

enum { PRIOR_SIZED = UNKNOWNS - UNKNOWN_SIZED };

/* Kinds of unknowns that a machine may have or not; shapes by their place in a leg from COMPONENT_SHAPE on. */
enum { COMPONENT_STIFFNESS, COMPONENT_SHAPE, COMPONENTS = COMPONENT_SHAPE + UNKNOWN_SHAPES };

struct prior {
    double weight[UNKNOWN_SIZED];   /* one over the variance of the unknowns whose prior is known: of an entry (sqrt(M_ii M_jj))^2 of the configured
                                     * machine, so that what the data leave open stays finite; of friction what only rounding sees */
    double unit[PRIOR_SIZED];       /* of the others the deviation for a size of 1: of a shape the leg's dry friction, of a stiffness one that makes
                                     * the forces that the inertia makes */
    double size[COMPONENTS];        /* 0: there is none of this kind */
};

/* By all data that there are of a machine. The sizes are those that the data say (variance_components.h).
 *
 * External stiffness is estimated of several logs together, where inertia and stiffness are told apart: where a stiffness that may be anything makes none of Mt's diagonal
 * entries more than three times as uncertain as none does. Tests at two frequencies, one 1.6 times the other, make it 2.2 to 2.6 times, the
 * harmonics of tests at one frequency five to sixty times; one multisine is between, and is not asked. Else there is none, and
 * -K / w^2 is taken for inertia. False: some unknown is in no row. */
bool prior_find(const struct equations *e, double nominal[DOFS][DOFS], struct prior *p);

int prior_component(int unknown);

/* One over the variance. */
double prior_weight(const struct prior *p, int unknown);

#endif
