#include "basis_sizes.h"

#include <math.h>
#include <string.h>

#include "dense.h"

enum { FUNCTIONS = UNKNOWNS - UNKNOWN_BASIS, ITERATIONS = 20 };
/* First value and bounds of a size, which is the prior standard deviation of a basis function's
 * coefficient as a multiple of the leg's dry friction. The upper bound exceeds 1, because
 * neighbouring basis functions may fit a curve by large coefficients of opposite sign. */
static const double SIZE_FIRST = 0.3, SIZE_LEAST = 1e-3, SIZE_MOST = 4.0;

/* Normal equations of the basis functions alone, with all other unknowns eliminated. */
struct reduced {
    double product[FUNCTIONS][FUNCTIONS], with[FUNCTIONS];
};

static bool reduce(const struct equations *e, double product[UNKNOWNS][UNKNOWNS], struct reduced *r) {
    double factor[UNKNOWN_BASIS][UNKNOWNS], solved[UNKNOWN_BASIS];
    memcpy(factor, product, sizeof factor);
    if (!dense_factor(UNKNOWN_BASIS, UNKNOWNS, factor[0])) return false;
    for (int i = 0; i < FUNCTIONS; i++) {
        memcpy(solved, e->product[UNKNOWN_BASIS + i], sizeof solved);
        dense_solve(UNKNOWN_BASIS, UNKNOWNS, factor[0], solved);
        r->with[i] = e->with[UNKNOWN_BASIS + i];
        for (int c = 0; c < UNKNOWN_BASIS; c++) r->with[i] -= solved[c] * e->with[c];
        for (int j = i; j < FUNCTIONS; j++) {
            r->product[j][i] = e->product[UNKNOWN_BASIS + j][UNKNOWN_BASIS + i];
            for (int c = 0; c < UNKNOWN_BASIS; c++) r->product[j][i] -= solved[c] * e->product[UNKNOWN_BASIS + j][c];
        }
    }
    return true;
}

static bool step(const struct reduced *r, const struct equations *e, double size[BASIS_SIZE]) {
    double factor[FUNCTIONS][FUNCTIONS], x[FUNCTIONS], variance[FUNCTIONS], work[FUNCTIONS];
    double found[BASIS_SIZE] = {0}, determined[BASIS_SIZE] = {0};
    memcpy(factor, r->product, sizeof factor);
    memcpy(x, r->with, sizeof x);
    for (int i = 0; i < FUNCTIONS; i++) factor[i][i] += 1.0 / equations_basis_variance(e, i, size);
    if (!dense_factor(FUNCTIONS, FUNCTIONS, factor[0])) return false;
    dense_solve(FUNCTIONS, FUNCTIONS, factor[0], x);
    dense_inverse_diagonal(FUNCTIONS, FUNCTIONS, factor[0], variance, work);
    for (int i = 0; i < FUNCTIONS; i++) {
        double prior = equations_basis_variance(e, i, size);
        found[i % BASIS_SIZE] += x[i] * x[i] / prior;
        determined[i % BASIS_SIZE] += fmax(1.0 - variance[i] / prior, 0.0);
    }
    for (int i = 0; i < BASIS_SIZE; i++)
        if (determined[i] > 0.0) size[i] = fmin(fmax(size[i] * sqrt(found[i] / determined[i]), SIZE_LEAST), SIZE_MOST);
    return true;
}

bool basis_sizes_find(const struct equations *e, double product[UNKNOWNS][UNKNOWNS], double size[BASIS_SIZE]) {
    struct reduced r;
    for (int i = 0; i < BASIS_SIZE; i++) size[i] = SIZE_FIRST;
    if (!reduce(e, product, &r)) return false;
    for (int i = 0; i < ITERATIONS; i++)
        if (!step(&r, e, size)) return false;
    return true;
}
