/* How large the shapes of dry friction are (equations.h), each kind's in all six legs together: a
 * shape that is in no leg then costs nothing, and one that is in the machine is held back by no
 * more than what it is not.
 *
 * The coefficients of a kind are draws of mean 0 and deviation size times the leg's dry friction.
 * The sizes are those that make the data, joint over all logs, most likely with all that is fitted
 * integrated out (restricted maximum likelihood, Patterson and Thompson 1971; evidence, MacKay
 * 1992, of whose fixed point these are steps): size^2 = sum (x / dry)^2 over the number of
 * coefficients that the data determine, sum (1 - variance / prior variance). Pure, no heap. */
#ifndef HEXID_SHAPE_SIZES_H
#define HEXID_SHAPE_SIZES_H

#include "equations.h"

/* prior: one over the variance of each unknown before UNKNOWN_SHAPE. False: some of
 * those is in no row. */
bool shape_sizes_find(const struct equations *e, const double prior[UNKNOWN_SHAPE], double size[UNKNOWN_SHAPES]);

#endif
