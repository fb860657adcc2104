/* Base variables: the parameters of the base model that may be wrong, and by how much at most. They
 * are the parameters with a tolerance in model.tolerance, and others whose exact values no
 * configuration can state. A deviation within these tolerances is never a finding. */
#ifndef HEXID_BASE_H
#define HEXID_BASE_H

#include "fit.h"

/* Lists the base variables on which the evaluated residuals depend. Variables of the oil are left
 * out if the chambers are not evaluated. Returns the number of variables. */
int base_variables(const struct params *model, enum residual_equations evaluated, struct variable v[FIT_VARIABLES]);

#endif
