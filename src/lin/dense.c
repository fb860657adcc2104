#include "dense.h"

#include <math.h>
#include <string.h>

enum { TOGETHER = 8 };
static const double SINGULAR = 1e-14; /* least pivot, as a share of the diagonal element before
                                       * elimination; a smaller pivot may be rounding error alone */

/* Computes element j of several rows of L at once. The sums of different rows are independent, so
 * the processor overlaps them. */
static inline void column(int j, int row, int rows, double *a, const double *aj) {
    double s[TOGETHER];
    for (int i = 0; i < rows; i++) s[i] = a[i * row + j];
    for (int k = 0; k < j; k++)
        for (int i = 0; i < rows; i++) s[i] -= a[i * row + k] * aj[k];
    for (int i = 0; i < rows; i++) a[i * row + j] = s[i] / aj[j];
}

bool dense_factor(int n, int row, double *a) {
    for (int j = 0; j < n; j++) {
        double *aj = a + j * row, whole = aj[j], d = whole;
        for (int k = 0; k < j; k++) d -= aj[k] * aj[k];
        if (!(d > SINGULAR * whole)) return false;
        aj[j] = sqrt(d);
        int i = j + 1;
        for (; i + TOGETHER <= n; i += TOGETHER) column(j, row, TOGETHER, a + i * row, aj);
        for (; i < n; i++) column(j, row, 1, a + i * row, aj);
    }
    return true;
}

double dense_dot(int n, const double *a, const double *b) {
    double part[TOGETHER] = {0}, sum = 0.0;
    int i = 0;
    for (; i + TOGETHER <= n; i += TOGETHER)
        for (int j = 0; j < TOGETHER; j++) part[j] += a[i + j] * b[i + j];
    for (int j = 0; i < n; i++, j++) part[j] += a[i] * b[i];
    for (int j = 0; j < TOGETHER; j++) sum += part[j];
    return sum;
}

/* Solves L y = b in place. The elements of b before `first` are zero. */
static void forward(int n, int row, const double *l, int first, double *b) {
    for (int i = first; i < n; i++) b[i] = (b[i] - dense_dot(i - first, l + i * row + first, b + first)) / l[i * row + i];
}

void dense_solve(int n, int row, const double *l, double *b) {
    forward(n, row, l, 0, b);
    /* Column i of L' is row i of L, which is contiguous in memory. */
    for (int i = n - 1; i >= 0; i--) {
        double x = b[i] /= l[i * row + i];
        for (int k = 0; k < i; k++) b[k] -= l[i * row + k] * x;
    }
}

void dense_inverse_diagonal(int n, int row, const double *l, double *diagonal, double *work) {
    for (int j = 0; j < n; j++) {
        memset(work, 0, (size_t)n * sizeof *work);
        work[j] = 1.0;
        forward(n, row, l, j, work);
        diagonal[j] = dense_dot(n - j, work + j, work + j);
    }
}
