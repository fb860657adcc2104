/* Vectors of three and six, and the Cholesky factor of a 6x6 matrix, inline for speed. */
#ifndef HEXID_VEC_H
#define HEXID_VEC_H

#include <math.h>

static inline double dot3(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void cross3(const double a[3], const double b[3], double c[3]) {
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    c[0] = x, c[1] = y, c[2] = z;
}

static inline double dot6(const double a[6], const double b[6]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
}

/* Computes y += a x. */
static inline void add6(double a, const double x[6], double y[6]) {
    for (int i = 0; i < 6; i++) y[i] += a * x[i];
}

/* Cholesky factor C of a positive definite 6x6 matrix, M = C C', in the lower triangle; the
 * diagonal has 1/C_ii. */
struct factor6 {
    double c[6][6];
};

/* Computes the Cholesky factor in place, from the lower triangle of M. */
static inline void factor6(struct factor6 *f) {
    for (int j = 0; j < 6; j++) {
        double d = f->c[j][j];
        for (int k = 0; k < j; k++) d -= f->c[j][k] * f->c[j][k];
        f->c[j][j] = 1.0 / sqrt(d);
        for (int i = j + 1; i < 6; i++) {
            double s = f->c[i][j];
            for (int k = 0; k < j; k++) s -= f->c[i][k] * f->c[j][k];
            f->c[i][j] = s * f->c[j][j];
        }
    }
}

/* Replaces x, a row of J or a force, by C^-1 x. (An acceleration a is whitened as C' a instead; its
 * square is a' M a.) */
static inline void whiten6(const struct factor6 *f, double x[6]) {
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < i; k++) x[i] -= f->c[i][k] * x[k];
        x[i] *= f->c[i][i];
    }
}

/* Replaces x by C'^-1 x: a whitened acceleration C' a becomes a. */
static inline void unwhiten6(const struct factor6 *f, double x[6]) {
    for (int i = 5; i >= 0; i--) {
        for (int k = i + 1; k < 6; k++) x[i] -= f->c[k][i] * x[k];
        x[i] *= f->c[i][i];
    }
}

#endif
