#include "shape_sizes.h"

#include <math.h>
#include <string.h>

#include "dense.h"

enum { SHAPES = UNKNOWNS - UNKNOWN_SHAPE, STEPS = 20 };
/* First, least and largest size, in units of dry friction. The largest exceeds 1, because
 * neighbouring basis functions may fit a value by opposite signs. */
static const double FIRST = 0.3, LEAST = 1e-3, MOST = 4.0;

/* Normal equations of the basis functions alone, with all other unknowns eliminated. */
struct reduced {
    double product[SHAPES][SHAPES], with[SHAPES];
};

static bool reduce(const struct equations *e, double product[UNKNOWNS][UNKNOWNS], struct reduced *r) {
    double factor[UNKNOWN_SHAPE][UNKNOWNS], solved[UNKNOWN_SHAPE];
    memcpy(factor, product, sizeof factor);
    if (!dense_factor(UNKNOWN_SHAPE, UNKNOWNS, factor[0])) return false;
    for (int i = 0; i < SHAPES; i++) {
        memcpy(solved, e->product[UNKNOWN_SHAPE + i], sizeof solved);
        dense_solve(UNKNOWN_SHAPE, UNKNOWNS, factor[0], solved);
        r->with[i] = e->with[UNKNOWN_SHAPE + i];
        for (int c = 0; c < UNKNOWN_SHAPE; c++) r->with[i] -= solved[c] * e->with[c];
        for (int j = i; j < SHAPES; j++) {
            r->product[j][i] = e->product[UNKNOWN_SHAPE + j][UNKNOWN_SHAPE + i];
            for (int c = 0; c < UNKNOWN_SHAPE; c++) r->product[j][i] -= solved[c] * e->product[UNKNOWN_SHAPE + j][c];
        }
    }
    return true;
}

static bool step(const struct reduced *r, const struct equations *e, double size[UNKNOWN_SHAPES]) {
    double factor[SHAPES][SHAPES], x[SHAPES], variance[SHAPES], work[SHAPES];
    double found[UNKNOWN_SHAPES] = {0}, determined[UNKNOWN_SHAPES] = {0};
    memcpy(factor, r->product, sizeof factor);
    memcpy(x, r->with, sizeof x);
    for (int i = 0; i < SHAPES; i++) factor[i][i] += 1.0 / equations_shape_variance(e, i, size);
    if (!dense_factor(SHAPES, SHAPES, factor[0])) return false;
    dense_solve(SHAPES, SHAPES, factor[0], x);
    dense_inverse_diagonal(SHAPES, SHAPES, factor[0], variance, work);
    for (int i = 0; i < SHAPES; i++) {
        double prior = equations_shape_variance(e, i, size);
        found[i % UNKNOWN_SHAPES] += x[i] * x[i] / prior;
        determined[i % UNKNOWN_SHAPES] += fmax(1.0 - variance[i] / prior, 0.0);
    }
    for (int i = 0; i < UNKNOWN_SHAPES; i++)
        if (determined[i] > 0.0) size[i] = fmin(fmax(size[i] * sqrt(found[i] / determined[i]), LEAST), MOST);
    return true;
}

bool shape_sizes_find(const struct equations *e, double product[UNKNOWNS][UNKNOWNS], double size[UNKNOWN_SHAPES]) {
    struct reduced r;
    for (int i = 0; i < UNKNOWN_SHAPES; i++) size[i] = FIRST;
    if (!reduce(e, product, &r)) return false;
    for (int i = 0; i < STEPS; i++)
        if (!step(&r, e, size)) return false;
    return true;
}
