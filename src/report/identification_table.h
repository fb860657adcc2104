/* The result as a table for people, like Tian 2015's Table 3. */
#ifndef HEXID_IDENTIFICATION_TABLE_H
#define HEXID_IDENTIFICATION_TABLE_H

#include <stdio.h>

#include "ident.h"

/* Methods A and B, or a line where they were not evaluated, unless the motion was none for them (not `sinusoids`); then method C, or why not. */
void identification_table_print(FILE *out, const struct identification *id, bool sinusoids);

/* What the data determine, before what they say: how many of the 21 entries and how well, the condition number; which not, and the motion that
 * they need. */
void identification_determined_print(FILE *out, const struct method_c *c, const double nominal_mt[DOFS][DOFS]);

#endif
