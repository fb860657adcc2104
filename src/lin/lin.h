/* Dense linear algebra by Eigen for at most LIN_MAX rows and columns, behind extern "C". No
 * exception escapes, and no heap is used (an allocation by Eigen would fail an assertion). Matrices
 * are row-major; a result must not overlap an input. Callers must check rank and condition. Any
 * thread. */
#ifndef HEXID_LIN_H
#define HEXID_LIN_H

#ifdef __cplusplus
#define LIN_NOEXCEPT noexcept
extern "C" {
#else
#define LIN_NOEXCEPT
#endif

enum { LIN_MAX = 40, LIN_COMPLEX_MAX = 6 }; /* largest number of rows or columns */

struct lin_report {
    int rank;  /* rank of the matrix; 0, with a result that is all NaN, if an input is not finite or
                * the decomposition does not converge */
    double condition; /* largest over smallest singular value; infinity if the matrix is singular */
};

/* Solves X A = B for X by singular value decomposition, which yields rank and condition at once. A
 * is n x n, B and X are m x n. If A is rank-deficient (a singular value is below n epsilon times
 * the largest), X is the least-squares solution of least norm; the report has the rank. */
struct lin_report lin_solve_right(int n, int m, const double *a, const double *b, double *x) LIN_NOEXCEPT;

/* Solves the symmetric positive definite system A X = B (LDLT); reads only the lower triangle of
 * A. A is n x n, B and X are n x m. Rank is the number of eigenvalues above n epsilon times the
 * largest magnitude; X is all NaN unless the rank is n. */
struct lin_report lin_solve_spd(int n, int m, const double *a, const double *b, double *x) LIN_NOEXCEPT;

/* Computes the inverse of a general n x n matrix; the pseudo-inverse when it is singular. */
struct lin_report lin_inverse(int n, const double *a, double *inverse) LIN_NOEXCEPT;

/* Computes the eigenvalues of a symmetric n x n matrix, ascending; reads only the lower triangle.
 * Returns 0, or -1 if the iteration does not converge or the lower triangle is not finite. */
int lin_eigenvalues(int n, const double *a, double *eigenvalues) LIN_NOEXCEPT;

/* Computes eigenvalues, ascending, and eigenvectors of A x = value B x. A is symmetric, B symmetric
 * positive definite, both n x n; only their lower triangles count. Row i of `vectors` is the i-th
 * eigenvector, scaled so that x' B x = 1. Returns 0, or -1 if B is not positive definite, if the
 * iteration does not converge, or if any element of A or B, in either triangle, is not finite. */
int lin_eigenvectors(int n, const double *a, const double *b, double *eigenvalues, double *vectors) LIN_NOEXCEPT;

/* Computes the eigenvalues of a general n x n matrix, in no order. Returns 0, or -1 if the
 * iteration does not converge or A is not finite. */
int lin_poles(int n, const double *a, double *real, double *imaginary) LIN_NOEXCEPT;

/* Computes the eigenvalues of a general complex n x n matrix, n at most LIN_COMPLEX_MAX, in no
 * order. Real and imaginary parts alternate, as in an array of double complex. Returns 0, or -1 as
 * lin_poles() does. */
int lin_complex_eigenvalues(int n, const double *a, double *eigenvalues) LIN_NOEXCEPT;

/* Computes the min(m, n) singular values of an m x n matrix, descending. Returns 0, or -1 as
 * lin_poles() does. */
int lin_singular_values(int m, int n, const double *a, double *values) LIN_NOEXCEPT;

#ifdef __cplusplus
}
#endif
#endif
