/* How large the shapes of dry friction are (equations.h), of each kind one size for all six legs: a
 * shape that no leg has then costs next to no accuracy, and one that the machine has is held back
 * by little.
 *
 * The coefficients of a kind are draws of mean 0 and deviation size times the leg's dry friction.
 * The sizes are those that make the data of all logs together most likely, with all that is fitted
 * integrated out (restricted maximum likelihood, Patterson and Thompson 1971; evidence, MacKay
 * 1992, to whose fixed point these steps go): size^2 = sum (x / dry)^2 over the number of
 * coefficients that the data determine, sum (1 - variance / prior variance). Pure, no heap. */
#ifndef HEXID_SHAPE_SIZES_H
#define HEXID_SHAPE_SIZES_H

#include "equations.h"

/* prior: inverse variance of each unknown before UNKNOWN_SHAPE. False: one of these is in no
 * row. */
bool shape_sizes_find(const struct equations *e, const double prior[UNKNOWN_SHAPE], double size[UNKNOWN_SHAPES]);

#endif
