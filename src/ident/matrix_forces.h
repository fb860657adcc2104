/* Leg forces that an inertia matrix at neutral needs, entry by entry. Method C fits them as
 * columns; leg_friction.h subtracts them from the measured force to show friction. Pure. */
#ifndef HEXID_MATRIX_FORCES_H
#define HEXID_MATRIX_FORCES_H

#include "equations.h"
#include "inverse_dynamics.h"

/* Removes friction and effects from a configuration; its bodies remain. The log of a simulated
 * machine has the simulated effects in its configuration, but the identification must find them. */
void matrix_bare_machine(struct params *params);

/* Adds the wrench that a symmetric correction `mt` of the configured matrix needs at an
 * acceleration (inverse_dynamics_move): inertia, and the weight of the payload that the correction
 * implies. */
void matrix_wrench(const struct rigid_legs *legs, const double acceleration[DOFS], double gravity_mps2, const double mt[DOFS][DOFS],
                   double wrench[DOFS]);

/* Finds the forces along the legs for one unit of each matrix entry (equations_entry). Returns
 * false if the Jacobian is singular. */
bool matrix_forces(const struct rigid_legs *legs, double j[LEGS][DOFS], const double acceleration[DOFS], double gravity_mps2,
                   double force_n[][LEGS]);

#endif
