/* The result as a table for people, like Tian 2015's Table 3. */
#ifndef HEXID_IDENTIFICATION_TABLE_H
#define HEXID_IDENTIFICATION_TABLE_H

#include <stdio.h>

#include "ident.h"

/* Decimals for a matrix: three, or more if its smallest diagonal entry is below one, so that this
 * entry has three figures. */
int identification_decimals(const double mt[DOFS][DOFS]);
int identification_decimals_of(double value);

/* Prints methods A and B, or one line if they were not evaluated; neither if the motion does not
 * suit them (not `sinusoids`). Then method C, or why it is missing. */
void identification_table_print(FILE *out, const struct identification *id, bool sinusoids);

/* Prints method C's diagonal with errors and intervals, and what was not evaluated or not
 * determined: the first of the table's results, in some five lines. */
void identification_brief_print(FILE *out, const struct identification *id, bool sinusoids);

/* Prints what the data determine, ahead of the values: how many of the 21 entries and how well, the
 * condition number, the missing entries and the motion that they need. */
void identification_determined_print(FILE *out, const struct method_c *c, const double nominal_mt[DOFS][DOFS]);

/* Prints the matrix at the pose that was asked for, if any. */
void identification_at_pose_print(FILE *out, const struct matrix_at_pose *at);

#endif
