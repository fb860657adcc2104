/* Uncertainty of the base model: which of its parameters may be off, and by how much at most.
 * Besides the tolerances of model.tolerance, the list holds parameters that no configuration
 * states exactly. A deviation inside this box is never a finding. */
#ifndef HEXID_BASE_H
#define HEXID_BASE_H

#include "fit.h"

/* Lists the base variables on which the evaluated residuals depend; without chamber residuals
 * the oil's parameters are left out. Returns their number. */
int base_variables(const struct params *model, enum residual_part evaluated, struct variable v[FIT_VARIABLES]);

#endif
