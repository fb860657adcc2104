#include "matrix_forces.h"

#include <string.h>

void matrix_bare_machine(struct params *p) {
    for (int k = 0; k < LEGS; k++) p->hydraulics.viscous_n_s_per_m[k] = 0.0;
    for (int e = 0; e < EFFECTS_MAX; e++) p->effects[e].on = false;
}

/* The payload's mass is the mean of three entries of Mt, each of its moments m c that of two. Adds the wrench that holds the weight of what one unit
 * of an entry stands for. */
static void add_weight(int row, int column, const double rotation[3][3], double gravity_mps2, double wrench[DOFS]) {
    static const struct {
        int row, column, axis; /* of the moment */
        double share;
    } moment[] = {{0, 4, 2, 0.5}, {1, 3, 2, -0.5}, {2, 3, 1, 0.5}, {0, 5, 1, -0.5}, {1, 5, 0, 0.5}, {2, 4, 0, -0.5}};
    if (row == column && row < 3) wrench[2] -= gravity_mps2 / 3.0;
    for (int i = 0; i < 6; i++) {
        if (moment[i].row != row || moment[i].column != column) continue;
        wrench[3] -= moment[i].share * gravity_mps2 * rotation[1][moment[i].axis];
        wrench[4] += moment[i].share * gravity_mps2 * rotation[0][moment[i].axis];
    }
}

/* Of a symmetric matrix with one entry that is 1, times a motion. */
static void entry_wrench(int row, int column, const double motion[DOFS], double wrench[DOFS]) {
    memset(wrench, 0, DOFS * sizeof wrench[0]);
    wrench[row] += motion[column];
    if (row != column) wrench[column] += motion[row];
}

/* Legs of a unit wrench. */
static bool unit_wrenches(double j[LEGS][DOFS], double along[DOFS][LEGS]) {
    for (int i = 0; i < DOFS; i++) {
        memset(along[i], 0, sizeof along[i]);
        along[i][i] = 1.0;
        if (!inverse_dynamics_along_legs(j, along[i])) return false;
    }
    return true;
}

static void along_legs(double along[DOFS][LEGS], const double wrench[DOFS], double force_n[LEGS]) {
    memset(force_n, 0, LEGS * sizeof force_n[0]);
    for (int i = 0; i < DOFS; i++)
        for (int k = 0; k < LEGS && wrench[i] != 0.0; k++) force_n[k] += wrench[i] * along[i][k];
}

bool matrix_forces(const struct rigid_legs *legs, double j[LEGS][DOFS], const double acceleration[DOFS], double gravity_mps2,
                   double force_n[][LEGS]) {
    double along[DOFS][LEGS], wrench[DOFS];
    if (!unit_wrenches(j, along)) return false;
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int row, column;
        equations_entry(c, &row, &column);
        entry_wrench(row, column, acceleration, wrench);
        add_weight(row, column, legs->rotation, gravity_mps2, wrench);
        along_legs(along, wrench, force_n[c]);
    }
    return true;
}

bool matrix_stiffness_forces(double j[LEGS][DOFS], const double pose[DOFS], double force_n[][LEGS]) {
    double along[DOFS][LEGS], wrench[DOFS];
    if (!unit_wrenches(j, along)) return false;
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int row, column;
        equations_entry(c, &row, &column);
        entry_wrench(row, column, pose, wrench);
        along_legs(along, wrench, force_n[c]);
    }
    return true;
}
