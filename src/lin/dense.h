/* Symmetric positive definite systems of any size n. Matrices are row-major; `row` is the number of
 * elements from one row to the next. The functions are pure and use no heap. */
#ifndef HEXID_DENSE_H
#define HEXID_DENSE_H

#include <stdbool.h>

/* Computes a' b, n values each, in independent partial sums, which the processor overlaps. */
double dense_dot(int n, const double *a, const double *b);

/* Factors A = L L' in place: L replaces the lower triangle of A, and the upper one is not used.
 * Returns false if A is not positive definite to within rounding error, or has a NaN. */
bool dense_factor(int n, int row, double *a);

/* Solves L L' x = b in place: b becomes x. factor: L, as dense_factor() leaves it. */
void dense_solve(int n, int row, const double *factor, double *b);

/* Computes the diagonal of (L L')^-1. `work` has room for n values. */
void dense_inverse_diagonal(int n, int row, const double *factor, double *diagonal, double *work);

#endif
