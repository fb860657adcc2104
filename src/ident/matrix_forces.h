/* Leg forces that an inertia matrix at neutral needs, entry by entry: the columns that method C
 * fits, and the forces subtracted from a measured one to show friction. Pure. */
#ifndef HEXID_MATRIX_FORCES_H
#define HEXID_MATRIX_FORCES_H

#include "equations.h"
#include "inverse_dynamics.h"

/* Takes friction and effects out of a configuration, so that its bodies are left. The log of a
 * simulated machine carries its effects in the configuration, but they are to be found. */
void matrix_bare_machine(struct params *params);

/* Finds the forces along the legs for one unit of each matrix entry (equations_entry), at a pose
 * and an acceleration (inverse_dynamics_move): inertia, and the weight of the payload that the
 * entry implies. Returns false if the Jacobian is singular. */
bool matrix_forces(const struct rigid_legs *legs, double j[LEGS][DOFS], const double acceleration[DOFS], double gravity_mps2,
                   double force_n[][LEGS]);

/* Finds the force along the legs for a whole matrix, given by its entries. */
bool matrix_force(const struct rigid_legs *legs, double j[LEGS][DOFS], const double acceleration[DOFS], double gravity_mps2,
                  const double entry[MATRIX_ENTRIES], double force_n[LEGS]);

#endif
