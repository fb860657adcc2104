/* Dry friction at rest: which coordinates stay, which slip, and how the rest of the machine
 * accelerates meanwhile. Pure, RT.
 *
 * Everything in whitened coordinates: with the mass matrix M = C C', x = C' acceleration, a
 * coordinate whose row is r accelerates with y.x + bias, y = C^-1 r, and a force s along it adds s
 * y to x. Rows may depend on each other (30 axes, 6 degrees of freedom). */
#ifndef HEXID_STICK_H
#define HEXID_STICK_H

#include "types.h"

/* An orthonormal basis of the rows held: what depends on rows already in it is dropped. */
struct stick_basis {
    int rank;
    double row[DOFS][DOFS], bias[DOFS];
};

void stick_basis_add(struct stick_basis *basis, const double row[DOFS], double bias);

/* Takes from x what would move a held coordinate. With bias_scale 0: the same for a velocity. */
void stick_hold(const struct stick_basis *basis, double bias_scale, double x[DOFS]);

/* One coordinate at rest. */
struct stick_coordinate {
    double row[DOFS], bias;
    double extend_limit, retract_limit; /* force that resists motion one way or the other, >= 0 */
    double force;                       /* out: -extend_limit .. retract_limit */
    int slip;                           /* out: +1 or -1 when the friction is at its limit
                                         * and gives way, else 0 */
};

/* Gauss' principle: of all friction forces within their limits, those that leave the least motion.
 * x: the acceleration without them. Primal-dual interior point: some 15 iterations of a 6x6
 * factorisation whatever the number of coordinates and however they depend on each other (projected
 * Gauss-Seidel stalls there: thousands of sweeps). */
enum { STICK_MAX = 32 };
void stick_resolve(struct stick_coordinate *coordinates, int count, const double x[DOFS]);

#endif
