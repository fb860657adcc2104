/* Common parts of the tables of the control laws: the sines, the frictions, and the cells. A cell
 * is the worst of six tests: amplitude error, % / phase, deg / unwanted motion, % / rms distance of
 * the true pose, mm. */
#ifndef HEXID_TESTS_CONTROL_TABLE_H
#define HEXID_TESTS_CONTROL_TABLE_H

#include <math.h>
#include <stdio.h>

#include "../control_rig.h"
#include "machines.h"

static const double DRY_N[] = {0.0, 100.0}, HZ[] = {2.0, 4.0, 8.0, 12.0};
static const double AMPLITUDE_M[] = {4e-3, 4e-3, 1.5e-3, 0.7e-3}, AMPLITUDE_RAD[] = {6e-3, 6e-3, 2e-3, 1e-3};
enum { FRICTIONS = 2, RATES = 4 };

/* Sets the sines of a column. */
static inline void table_tests(struct test_params *t, int rate) {
    for (int i = 0; i < DOFS; i++) t->hz[i] = HZ[rate], t->amplitude[i] = i < 3 ? AMPLITUDE_M[rate] : AMPLITUDE_RAD[rate];
}

enum { FIGURES = 4 };
struct table_cell {
    double figure[FIGURES];
};

static inline struct table_cell table_worst(const struct control_figures *f) {
    struct table_cell c = {{0.0, 0.0, 0.0, 1e3 * f->rms_m}};
    for (int i = 0; i < DOFS; i++) {
        c.figure[0] = fmax(c.figure[0], fabs(f->amplitude_pct[i])), c.figure[1] = fmax(c.figure[1], fabs(f->phase_deg[i]));
        c.figure[2] = fmax(c.figure[2], f->unwanted_pct[i]);
    }
    return c;
}

static inline void table_print(struct table_cell c) {
    printf(" %.2g / %.2g / %.2g / %.3f |", c.figure[0], c.figure[1], c.figure[2], c.figure[3]);
}

#endif
