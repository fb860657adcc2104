/* What an inertia matrix at neutral asks of the legs, entry by entry: the columns that method C
 * fits, and what is taken off a measured force to show the friction. Pure. */
#ifndef HEXID_MATRIX_FORCES_H
#define HEXID_MATRIX_FORCES_H

#include "equations.h"
#include "inverse_dynamics.h"

/* The configured bodies, without friction, and without effects: a simulated machine's are in the
 * log's configuration, and are to be found. */
void matrix_bare_machine(struct params *params);

/* Forces along the legs for one unit of each entry (equations_entry), at a pose and an acceleration
 * (inverse_dynamics_move): inertia, and the weight of the payload that the entry stands for. False
 * where the legs cannot. */
bool matrix_forces(const struct rigid_legs *legs, double j[LEGS][DOFS], const double acceleration[DOFS], double gravity_mps2,
                   double force_n[][LEGS]);

#endif
