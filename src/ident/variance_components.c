#include "variance_components.h"

#include <math.h>
#include <string.h>

#include "dense.h"

enum { SIZED = PRIOR_SIZED, STEPS = 20 };
static const double LEAST = 1e-4, MOST = 4.0; /* above 1: neighbours with opposite signs, fitted to what lies between them */

/* The normal equations of the sized unknowns alone, all that is before them eliminated. */
struct reduced {
    double product[SIZED][SIZED], with[SIZED];
};

static bool reduce(const struct equations *e, const struct prior *p, struct reduced *r) {
    double factor[UNKNOWN_SIZED][UNKNOWNS], solved[UNKNOWN_SIZED];
    memcpy(factor, e->product, sizeof factor);
    for (int c = 0; c < UNKNOWN_SIZED; c++) factor[c][c] += p->weight[c];
    if (!dense_factor(UNKNOWN_SIZED, UNKNOWNS, factor[0])) return false;
    for (int i = 0; i < SIZED; i++) {
        memcpy(solved, e->product[UNKNOWN_SIZED + i], sizeof solved);
        dense_solve(UNKNOWN_SIZED, UNKNOWNS, factor[0], solved);
        r->with[i] = e->with[UNKNOWN_SIZED + i];
        for (int c = 0; c < UNKNOWN_SIZED; c++) r->with[i] -= solved[c] * e->with[c];
        for (int j = i; j < SIZED; j++) {
            r->product[j][i] = e->product[UNKNOWN_SIZED + j][UNKNOWN_SIZED + i];
            for (int c = 0; c < UNKNOWN_SIZED; c++) r->product[j][i] -= solved[c] * e->product[UNKNOWN_SIZED + j][c];
        }
    }
    return true;
}

static bool step(const struct reduced *r, struct prior *p) {
    double factor[SIZED][SIZED], x[SIZED], variance[SIZED], work[SIZED], found[COMPONENTS] = {0}, determined[COMPONENTS] = {0};
    memcpy(factor, r->product, sizeof factor);
    memcpy(x, r->with, sizeof x);
    for (int i = 0; i < SIZED; i++) factor[i][i] += prior_weight(p, UNKNOWN_SIZED + i);
    if (!dense_factor(SIZED, SIZED, factor[0])) return false;
    dense_solve(SIZED, SIZED, factor[0], x);
    dense_inverse_diagonal(SIZED, SIZED, factor[0], variance, work);
    for (int i = 0; i < SIZED; i++) {
        double weight = prior_weight(p, UNKNOWN_SIZED + i);
        int kind = prior_component(UNKNOWN_SIZED + i);
        found[kind] += x[i] * x[i] * weight;
        determined[kind] += fmax(1.0 - variance[i] * weight, 0.0);
    }
    for (int i = 0; i < COMPONENTS; i++)
        if (p->size[i] > 0.0 && determined[i] > 0.0) p->size[i] = fmin(fmax(p->size[i] * sqrt(found[i] / determined[i]), LEAST), MOST);
    return true;
}

bool variance_components_find(const struct equations *e, struct prior *p) {
    struct reduced r;
    if (!reduce(e, p, &r)) return false;
    for (int i = 0; i < STEPS; i++)
        if (!step(&r, p)) return false;
    return true;
}
