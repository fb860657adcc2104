/* Uncertainty of the base model: which of its parameters may be wrong, and by how much at most. The
 * list contains parameters with a tolerance in model.tolerance, and others that no configuration
 * states exactly. A deviation within these limits is never a finding. */
#ifndef HEXID_BASE_H
#define HEXID_BASE_H

#include "fit.h"

/* Lists the base variables on which the evaluated residuals depend. Variables of the oil are left
 * out if the chambers are not evaluated. Returns the number of variables. */
int base_variables(const struct params *model, enum residual_equations evaluated, struct variable v[FIT_VARIABLES]);

#endif
