#include "prior.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "variance_components.h"

static const double OF_NO_WEIGHT = 1e-12; /* of an unknown's own product */
static const double LEAST_N = 1e-3;       /* of dry friction: none */
static const double FIRST_SIZE = 0.3, NO_DEVIATION = 1e-9;
static const double TOLD_APART = 3.0;

int prior_component(int unknown) {
    return unknown < UNKNOWN_SHAPE ? COMPONENT_STIFFNESS : COMPONENT_SHAPE + (unknown - UNKNOWN_SHAPE) % UNKNOWN_SHAPES;
}

double prior_weight(const struct prior *p, int unknown) {
    if (unknown < UNKNOWN_SIZED) return p->weight[unknown];
    double deviation = fmax(p->unit[unknown - UNKNOWN_SIZED] * p->size[prior_component(unknown)], NO_DEVIATION);
    return 1.0 / (deviation * deviation);
}

static void fill(const struct equations *e, double nominal[DOFS][DOFS], struct prior *p) {
    for (int c = 0; c < UNKNOWN_SIZED; c++) p->weight[c] = OF_NO_WEIGHT * e->product[c][c];
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int row, column;
        equations_entry(c, &row, &column);
        double product = nominal[row][row] * nominal[column][column];
        p->weight[c] = 1.0 / product;
        p->unit[UNKNOWN_STIFFNESS - UNKNOWN_SIZED + c] = sqrt(product) * e->turns_radps * e->turns_radps;
    }
    for (int c = UNKNOWN_SHAPE; c < UNKNOWNS; c++) p->unit[c - UNKNOWN_SIZED] = fmax(e->dry_n[(c - UNKNOWN_SHAPE) / UNKNOWN_SHAPES], LEAST_N);
    for (int i = 0; i < COMPONENTS; i++) p->size[i] = FIRST_SIZE;
}

static bool diagonal_variances(const struct equations *e, const struct prior *p, double variance[DOFS]) {
    double factor[UNKNOWNS][UNKNOWNS];
    memcpy(factor, e->product, sizeof factor);
    for (int c = 0; c < UNKNOWNS; c++) factor[c][c] += prior_weight(p, c);
    if (!dense_factor(UNKNOWNS, UNKNOWNS, factor[0])) return false;
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        double unit[UNKNOWNS] = {0};
        int row, column;
        equations_entry(c, &row, &column);
        if (row != column) continue;
        unit[c] = 1.0;
        dense_solve(UNKNOWNS, UNKNOWNS, factor[0], unit);
        variance[row] = unit[c];
    }
    return true;
}

/* `p` has the sizes of the shapes without stiffness. */
static bool tell_stiffness(const struct equations *e, const struct prior *p, bool *told) {
    struct prior free = *p;
    double without[DOFS], with[DOFS];
    free.size[COMPONENT_STIFFNESS] = 1.0;
    if (!diagonal_variances(e, p, without) || !diagonal_variances(e, &free, with)) return false;
    *told = e->logs > 1;
    for (int i = 0; i < DOFS; i++) *told = *told && with[i] <= TOLD_APART * TOLD_APART * without[i];
    return true;
}

bool prior_find(const struct equations *e, double nominal[DOFS][DOFS], struct prior *p) {
    bool told;
    fill(e, nominal, p);
    p->size[COMPONENT_STIFFNESS] = 0.0;
    if (!variance_components_find(e, p) || !tell_stiffness(e, p, &told)) return false;
    p->size[COMPONENT_STIFFNESS] = told ? FIRST_SIZE : 0.0;
    return !told || variance_components_find(e, p);
}
