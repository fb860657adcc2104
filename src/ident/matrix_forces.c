#include "matrix_forces.h"

#include <string.h>

#include "params.h"

void matrix_bare_machine(struct params *p) {
    for (int k = 0; k < LEGS; k++) p->hydraulics.viscous_n_s_per_m[k] = 0.0;
    for (int e = 0; e < EFFECTS_MAX; e++) p->effects[e].on = false;
}

/* Adds the wrench that holds the weight which one unit of a matrix entry implies. The payload's
 * mass is the mean of three entries of Mt, each of its moments m c the mean of two. */
static void add_weight(int row, int column, const double rotation[3][3], double gravity_mps2, double wrench[DOFS]) {
    static const struct {
        int row, column, axis; /* axis: of the moment m c, 0..2 */
        double share;
    } moment[] = {{0, 4, 2, 0.5}, {1, 3, 2, -0.5}, {2, 3, 1, 0.5}, {0, 5, 1, -0.5}, {1, 5, 0, 0.5}, {2, 4, 0, -0.5}};
    if (row == column && row < 3) wrench[2] -= gravity_mps2 / 3.0;
    for (int i = 0; i < 6; i++) {
        if (moment[i].row != row || moment[i].column != column) continue;
        wrench[3] -= moment[i].share * gravity_mps2 * rotation[1][moment[i].axis];
        wrench[4] += moment[i].share * gravity_mps2 * rotation[0][moment[i].axis];
    }
}

/* Adds the wrench that a matrix entry of this size needs: inertia and weight. */
static void add_entry(int entry, double size, const struct rigid_legs *legs, const double acceleration[DOFS], double gravity_mps2,
                      double wrench[DOFS]) {
    int row, column;
    double unit[DOFS] = {0};
    equations_entry(entry, &row, &column);
    unit[row] += acceleration[column];
    if (row != column) unit[column] += acceleration[row];
    add_weight(row, column, legs->rotation, gravity_mps2, unit);
    for (int i = 0; i < DOFS; i++) wrench[i] += size * unit[i];
}

bool matrix_forces(const struct rigid_legs *legs, double j[LEGS][DOFS], const double acceleration[DOFS], double gravity_mps2,
                   double force_n[][LEGS]) {
    double along[DOFS][LEGS];
    if (!inverse_dynamics_unit_wrenches(j, along)) return false;
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        double wrench[DOFS] = {0};
        add_entry(c, 1.0, legs, acceleration, gravity_mps2, wrench);
        memset(force_n[c], 0, sizeof force_n[c]);
        for (int i = 0; i < DOFS; i++)
            for (int k = 0; k < LEGS && wrench[i] != 0.0; k++) force_n[c][k] += wrench[i] * along[i][k];
    }
    return true;
}

bool matrix_force(const struct rigid_legs *legs, double j[LEGS][DOFS], const double acceleration[DOFS], double gravity_mps2,
                  const double entry[MATRIX_ENTRIES], double force_n[LEGS]) {
    memset(force_n, 0, LEGS * sizeof *force_n);
    for (int c = 0; c < MATRIX_ENTRIES; c++) add_entry(c, entry[c], legs, acceleration, gravity_mps2, force_n);
    return inverse_dynamics_along_legs(j, force_n);
}
