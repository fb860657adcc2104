#include "matrix_forces.h"

#include <string.h>

#include "params.h"

void matrix_bare_machine(struct params *p) {
    for (int k = 0; k < LEGS; k++) p->hydraulics.viscous_n_s_per_m[k] = 0.0;
    for (int e = 0; e < EFFECTS_MAX; e++) p->effects[e].on = false;
}

/* Adds the wrench that carries the weight of the body that a matrix implies. The body's mass is the
 * mean of three entries of Mt; each component of its moment m c is the mean of two entries. */
static void add_weight(const double mt[DOFS][DOFS], const double rotation[3][3], double gravity_mps2, double wrench[DOFS]) {
    static const struct {
        int row, column, axis; /* axis: component of the moment m c, 0..2 */
        double share;
    } moment[] = {{0, 4, 2, 0.5}, {1, 3, 2, -0.5}, {2, 3, 1, 0.5}, {0, 5, 1, -0.5}, {1, 5, 0, 0.5}, {2, 4, 0, -0.5}};
    wrench[2] -= gravity_mps2 * (mt[0][0] + mt[1][1] + mt[2][2]) / 3.0;
    for (int i = 0; i < 6; i++) {
        double size = moment[i].share * gravity_mps2 * mt[moment[i].row][moment[i].column];
        wrench[3] -= size * rotation[1][moment[i].axis];
        wrench[4] += size * rotation[0][moment[i].axis];
    }
}

void matrix_wrench(const struct rigid_legs *legs, const double acceleration[DOFS], double gravity_mps2, const double mt[DOFS][DOFS],
                   double wrench[DOFS]) {
    for (int i = 0; i < DOFS; i++)
        for (int c = 0; c < DOFS; c++) wrench[i] += mt[i][c] * acceleration[c];
    add_weight(mt, legs->rotation, gravity_mps2, wrench);
}

bool matrix_forces(const struct rigid_legs *legs, double j[LEGS][DOFS], const double acceleration[DOFS], double gravity_mps2,
                   double force_n[][LEGS]) {
    double along[DOFS][LEGS];
    if (!inverse_dynamics_unit_wrenches(j, along)) return false;
    for (int e = 0; e < MATRIX_ENTRIES; e++) {
        double mt[DOFS][DOFS] = {{0}}, wrench[DOFS] = {0};
        int row, column;
        equations_entry(e, &row, &column);
        mt[row][column] = mt[column][row] = 1.0;
        matrix_wrench(legs, acceleration, gravity_mps2, (const double (*)[DOFS])mt, wrench);
        memset(force_n[e], 0, sizeof force_n[e]);
        for (int i = 0; i < DOFS; i++)
            for (int k = 0; k < LEGS && wrench[i] != 0.0; k++) force_n[e][k] += wrench[i] * along[i][k];
    }
    return true;
}
