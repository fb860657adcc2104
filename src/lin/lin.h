/* Dense linear algebra of small fixed sizes by Eigen, behind extern "C": no exception leaves, no heap after return for the fixed sizes.
 * Matrices are row-major. Callers look at rank and condition. Any thread. */
#ifndef HEXID_LIN_H
#define HEXID_LIN_H

#ifdef __cplusplus
extern "C" {
#endif

struct lin_report {
    int rank;
    double condition; /* largest over smallest singular value; infinity when singular */
};

/* Solves X A = B for X by column-pivoted Householder QR of A'. A n x n, B and X m x n, n <= 16, m <= 16.
 * On rank deficiency X is the least-squares solution of least norm and the report says so; if A is not finite rank is 0, X all NaN. */
struct lin_report lin_solve_right(int n, int m, const double *a, const double *b, double *x);

/* Solves the symmetric positive definite system A X = B (Cholesky, LDLT). A n x n, B and X n x m, n <= 16, m <= 16. */
struct lin_report lin_solve_spd(int n, int m, const double *a, const double *b, double *x);

/* inverse of a general n x n matrix, n <= 16. */
struct lin_report lin_inverse(int n, const double *a, double *inverse);

/* Eigenvalues of a symmetric n x n matrix, ascending, n <= 16. Returns 0, or -1 if they do not converge or A is not finite. */
int lin_eigenvalues(int n, const double *a, double *eigenvalues);

/* Singular values of an m x n matrix, descending; m, n <= 16. Returns 0 or -1 as above. */
int lin_singular_values(int m, int n, const double *a, double *values);

#ifdef __cplusplus
}
#endif
#endif
