/* Uncertainty of the base model: which of its parameters may be wrong, and by how much at most.
 * Besides those with a tolerance in model.tolerance, the list holds parameters that no
 * configuration states exactly. A deviation within these limits is never a finding. */
#ifndef HEXID_BASE_H
#define HEXID_BASE_H

#include "fit.h"

/* Lists the base variables on which the evaluated residuals depend; the oil's are left out if the
 * chambers are not evaluated. Returns their number. */
int base_variables(const struct params *model, enum residual_equations evaluated, struct variable v[FIT_VARIABLES]);

#endif
