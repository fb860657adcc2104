/* Checks whether the substeps resolve the machine. If oil springs, dampers or leakage have rates
 * that are too fast for a substep, both engines diverge. Pure. */
#ifndef HEXID_RESOLUTION_H
#define HEXID_RESOLUTION_H

#include "cylinder.h"
#include "rigid.h"

/* Checks that substeps of dt_s resolve the machine in this pose. Returns 0, or -2 with the keys to
 * change if they do not. */
int resolution_check(const struct cylinder_model *cylinder, const struct rigid_model *rigid, const double pose[DOFS], double dt_s,
                     struct error *error);

#endif
