/* Symmetric positive definite systems of any size, row-major with the caller's row
 * length. Pure, no heap. */
#ifndef HEXID_DENSE_H
#define HEXID_DENSE_H

#include <stdbool.h>

/* In place, from the lower triangle: A = L L'. False where A is not positive
 * definite to rounding. */
bool dense_factor(int n, int row, double *a);

/* b := (L L')^-1 b. */
void dense_solve(int n, int row, const double *factor, double *b);

/* Diagonal of (L L')^-1. */
void dense_inverse_diagonal(int n, int row, const double *factor, double *diagonal, double *work);

#endif
