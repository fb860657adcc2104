/* Sizes of the basis functions of dry friction (equations.h): one for each kind of function, common
 * to all six legs. A size is the width of the prior of its functions. It follows from the data, so
 * a function that no leg needs hardly costs accuracy, and a function that the machine has is hardly
 * restrained.
 *
 * The coefficients of a kind are draws of mean 0 whose standard deviation is the size times the
 * leg's dry friction. The sizes maximise the likelihood of all logs' data, with all fitted values
 * integrated out (restricted maximum likelihood, Patterson and Thompson 1971; evidence, MacKay
 * 1992, whose fixed-point steps are used). With x the coefficients and dry each leg's dry friction,
 * size^2 at the maximum is sum (x / dry)^2, divided by the number of coefficients that the data
 * determine, sum (1 - variance / prior variance). Pure, no heap. */
#ifndef HEXID_BASIS_SIZES_H
#define HEXID_BASIS_SIZES_H

#include "equations.h"

/* Finds the sizes. product: X' W X of the equations plus the inverse prior covariance of all
 * unknowns before UNKNOWN_BASIS; lower triangle. Returns false if one of these unknowns occurs in
 * no row. */
bool basis_sizes_find(const struct equations *e, double product[UNKNOWNS][UNKNOWNS], double size[BASIS_SIZE]);

#endif
