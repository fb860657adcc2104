/* Sizes of the basis functions of dry friction (equations.h), one for each kind and
 * common to all six legs. With them a function that no leg has costs next to no accuracy, and one
 * that the machine has is hardly held back by its prior.
 *
 * The coefficients of a kind are draws of mean 0 whose standard deviation is its size times the
 * leg's dry friction. The sizes maximise the likelihood of all logs' data, with all fitted values
 * integrated out (restricted maximum likelihood, Patterson and Thompson 1971; evidence, MacKay
 * 1992, whose fixed-point steps are used): size^2 = sum (x / dry)^2 over the number of coefficients
 * that the data determine, sum (1 - variance / prior variance). Pure, no heap. */
#ifndef HEXID_BASIS_SIZES_H
#define HEXID_BASIS_SIZES_H

#include "equations.h"

/* Finds the sizes. product: that of the equations, with the priors of all unknowns before
 * UNKNOWN_BASIS added; lower triangle. Returns false if one of these unknowns occurs in no row. */
bool basis_sizes_find(const struct equations *e, double product[UNKNOWNS][UNKNOWNS], double size[BASIS_SIZE]);

#endif
