#include "dense.h"

#include <math.h>
#include <string.h>

enum { TOGETHER = 8 };
static const double SINGULAR = 1e-14; /* least pivot over its diagonal element; below, only
                                       * rounding is left */

/* Computes element j of several rows of L at once: their sums do not wait for each other. */
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

static void forward(int n, int row, const double *l, double *b) {
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) b[i] -= l[i * row + k] * b[k];
        b[i] /= l[i * row + i];
    }
}

void dense_solve(int n, int row, const double *l, double *b) {
    forward(n, row, l, b);
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++) b[i] -= l[k * row + i] * b[k];
        b[i] /= l[i * row + i];
    }
}

void dense_inverse_diagonal(int n, int row, const double *l, double *diagonal, double *work) {
    for (int j = 0; j < n; j++) {
        memset(work, 0, (size_t)n * sizeof *work);
        work[j] = 1.0;
        forward(n, row, l, work);
        diagonal[j] = 0.0;
        for (int i = j; i < n; i++) diagonal[j] += work[i] * work[i];
    }
}
