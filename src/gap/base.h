/* The base model's own uncertainty: which of its parameters may be off, and by how much at most.
 * Beyond what model.tolerance states, the list holds what no configuration has exactly. Nothing in
 * this list, within its box, is ever a finding. */
#ifndef HEXID_BASE_H
#define HEXID_BASE_H

#include "fit.h"

/* Variables of the base for this model that residuals of the evaluated parts depend on: the oil's
 * not where chambers are not evaluated. Returns their number. */
int base_variables(const struct params *model, enum residual_part evaluated, struct variable v[FIT_VARIABLES]);

#endif
