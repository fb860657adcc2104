#include "equations.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "dense.h"
#include "numeric.h"
#include "shape_sizes.h"

static const double LEAST_N = 1e-3;  /* least prior standard deviation of a basis function's
                                      * coefficient */
static const double OF_NO_WEIGHT = 1e-12; /* weight of a prior that has no influence, as a share of
                                           * the data's */

void equations_entry(int unknown, int *row, int *column) {
    int i = 0;
    while (unknown >= DOFS - i) unknown -= DOFS - i, i++;
    *row = i, *column = i + unknown;
}

void equations_name(int unknown, char name[EQUATIONS_NAME]) {
    static const char *const way[] = {"extending", "retracting"};
    int row, column, dry = unknown - UNKNOWN_DRY;
    if (unknown >= UNKNOWN_SPRING) {
        snprintf(name, EQUATIONS_NAME, "spring %s", dof_names[unknown - UNKNOWN_SPRING]);
    } else if (dry >= 0) {
        snprintf(name, EQUATIONS_NAME, "dry leg %d %s", dry / 2 + 1, way[dry % 2]);
    } else if (unknown >= UNKNOWN_VISCOUS) {
        snprintf(name, EQUATIONS_NAME, "viscous leg %d", unknown - UNKNOWN_VISCOUS + 1);
    } else {
        equations_entry(unknown, &row, &column);
        snprintf(name, EQUATIONS_NAME, "Mt%d%d", row + 1, column + 1);
    }
}

double equations_scatter(const struct equations *e) { return e->free > 0 ? sqrt(fmax(e->rest, 0.0) / e->free) : (double)NAN; }

void equations_add(struct equations *sum, const struct equations *e) {
    for (int c = 0; c < UNKNOWNS; c++) {
        sum->with[c] += e->with[c];
        for (int d = 0; d <= c; d++) sum->product[c][d] += e->product[c][d];
        for (int j = 0; j < COMMON; j++) sum->common[j][c] += e->common[j][c];
    }
    sum->rest += e->rest;
    sum->free += e->free;
    for (int k = 0; k < LEGS; k++) sum->dry_n[k] = fmax(sum->dry_n[k], e->dry_n[k]);
    for (int i = 0; i < DOFS; i++) sum->spring[i] = fmax(sum->spring[i], e->spring[i]);
    sum->force_n = fmax(sum->force_n, e->force_n);
    sum->rate_mps = fmax(sum->rate_mps, e->rate_mps);
}

double equations_shape_variance(const struct equations *e, int i, const double size[UNKNOWN_SHAPES]) {
    return square(fmax(e->dry_n[i / UNKNOWN_SHAPES] * size[i % UNKNOWN_SHAPES], LEAST_N));
}

static bool factor_with_prior(const struct equations *e, double nominal[DOFS][DOFS], double factor[UNKNOWNS][UNKNOWNS]) {
    double prior[UNKNOWN_SHAPE], size[UNKNOWN_SHAPES];
    for (int c = 0; c < UNKNOWN_SHAPE; c++) {
        int row, column;
        prior[c] = OF_NO_WEIGHT * e->product[c][c];
        if (c < MATRIX_ENTRIES) equations_entry(c, &row, &column), prior[c] = 1.0 / (nominal[row][row] * nominal[column][column]);
        if (c >= UNKNOWN_SPRING) prior[c] = e->spring[c - UNKNOWN_SPRING] > 0.0 ? 1.0 / square(e->spring[c - UNKNOWN_SPRING]) : 1.0;
    }
    if (!shape_sizes_find(e, prior, size)) return false;
    memcpy(factor, e->product, sizeof e->product);
    for (int c = 0; c < UNKNOWNS; c++)
        factor[c][c] += c < UNKNOWN_SHAPE ? prior[c] : 1.0 / equations_shape_variance(e, c - UNKNOWN_SHAPE, size);
    return dense_factor(UNKNOWNS, UNKNOWNS, factor[0]);
}

static bool values(const struct equations *e, double factor[UNKNOWNS][UNKNOWNS], double value[UNKNOWNS]) {
    bool finite = true;
    memcpy(value, e->with, sizeof e->with);
    dense_solve(UNKNOWNS, UNKNOWNS, factor[0], value);
    for (int c = 0; c < UNKNOWNS; c++) finite = finite && isfinite(value[c]);
    return finite;
}

bool equations_values(const struct equations *e, double nominal[DOFS][DOFS], double value[UNKNOWNS]) {
    double factor[UNKNOWNS][UNKNOWNS];
    return factor_with_prior(e, nominal, factor) && values(e, factor, value);
}

bool equations_solve(const struct equations *e, double nominal[DOFS][DOFS], struct estimate *estimate) {
    double factor[UNKNOWNS][UNKNOWNS];
    if (!factor_with_prior(e, nominal, factor) || !values(e, factor, estimate->value)) return false;
    for (int c = 0; c < UNKNOWNS; c++) {
        memset(estimate->noise[c], 0, sizeof estimate->noise[c]);
        estimate->noise[c][c] = 1.0;
        dense_solve(UNKNOWNS, UNKNOWNS, factor[0], estimate->noise[c]);
    }
    memcpy(estimate->common, e->common, sizeof e->common);
    for (int j = 0; j < COMMON; j++) dense_solve(UNKNOWNS, UNKNOWNS, factor[0], estimate->common[j]);
    return true;
}

double estimate_covariance(const struct estimate *e, int a, int b) {
    double sum = e->noise[a][b];
    for (int j = 0; j < COMMON; j++) sum += e->common[j][a] * e->common[j][b];
    return sum;
}
