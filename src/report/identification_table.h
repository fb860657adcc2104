/* The result as a table for people, like Tian 2015's Table 3. */
#ifndef HEXID_IDENTIFICATION_TABLE_H
#define HEXID_IDENTIFICATION_TABLE_H

#include <stdio.h>

#include "ident.h"

/* Decimals for a matrix: three, and more where its smallest entry on the diagonal is below one, so
 * that it has three figures and its deviation some. */
int identification_decimals(const double mt[DOFS][DOFS]);
int identification_decimals_of(double value);

/* Methods A and B, or a line where they were not evaluated; nothing of them where the motion was
 * none for them (not `sinusoids`). Then method C, or why not. */
void identification_table_print(FILE *out, const struct identification *id, bool sinusoids);

/* What the data determine, ahead of the values: how many of the 21 entries and how well, the
 * condition number; which entries not, and the motion that they need. */
void identification_determined_print(FILE *out, const struct method_c *c, const double nominal_mt[DOFS][DOFS]);

/* The matrix at the pose that was asked for, if one was. */
void identification_at_pose_print(FILE *out, const struct matrix_at_pose *at);

#endif
