/* Dry friction at rest: which coordinates stay, which slip, and how the rest of the machine
 * accelerates. Pure, RT.
 *
 * All vectors are whitened: with the mass matrix M = C C', x = C' acceleration. A coordinate with
 * row r has the whitened row y = C^-1 r and the acceleration y.x + bias; a force s along it adds
 * s y to x. Rows may be linearly dependent (30 coordinates, 6 degrees of freedom). */
#ifndef HEXID_STICK_H
#define HEXID_STICK_H

#include "types.h"

/* Orthonormal basis of the rows of the coordinates that are held; linearly dependent rows are
 * dropped. */
struct stick_basis {
    int rank;
    double row[DOFS][DOFS], bias[DOFS];
};

void stick_basis_add(struct stick_basis *basis, const double row[DOFS], double bias);

/* Removes the motion of the held coordinates from x. bias_scale: 1 if x is an acceleration, 0 if it
 * is a velocity. */
void stick_hold(const struct stick_basis *basis, double bias_scale, double x[DOFS]);

/* A coordinate at rest. `force` and `slip` are results. */
struct stick_coordinate {
    double row[DOFS], bias;
    double extend_limit, retract_limit; /* largest friction forces against extending and against
                                         * retracting, >= 0 */
    double force;                       /* result: friction force, -extend_limit .. retract_limit */
    int slip;       /* result: direction in which the friction gives way, +1 or -1; 0 if it holds */
};

/* Finds, by Gauss' principle, the friction forces within their limits that leave the least
 * acceleration. count: 0 to STICK_MAX; x: acceleration without these forces. The solver is a
 * primal-dual interior point method. It takes about 15 factorisations of a 6x6 matrix, however many
 * coordinates there are and however they depend on each other; projected Gauss-Seidel would need
 * thousands of sweeps. */
enum { STICK_MAX = 32 };
void stick_resolve(struct stick_coordinate *coordinates, int count, const double x[DOFS]);

#endif
