/* The result of an identification as a table for people, like Tian 2015's Table 3. */
#ifndef HEXID_IDENTIFICATION_TABLE_H
#define HEXID_IDENTIFICATION_TABLE_H

#include <stdio.h>

#include "ident.h"

/* Returns the number of decimals for a matrix: three, or more if its smallest diagonal entry is
 * below one, so that this entry has three significant figures. */
int identification_decimals(const double mt[DOFS][DOFS]);
int identification_decimals_of(double value);

/* Prints methods A and B, or one line if they were not evaluated, then method C, or why it was not
 * evaluated. If the motion does not suit methods A and B (not `sinusoids`), they are left out. */
void identification_table_print(FILE *out, const struct identification *id, bool sinusoids);

/* Prints the first results of the table in some five lines: method C's diagonal with errors and
 * intervals, and the entries that were not evaluated or not determined. */
void identification_brief_print(FILE *out, const struct identification *id, bool sinusoids);

/* Prints how much the data determine: how many of the 21 entries and how well, the condition
 * number, and the missing entries with the motion that they need. */
void identification_determined_print(FILE *out, const struct method_c *c, const double nominal_mt[DOFS][DOFS]);

/* Prints that the gain common to all pressures rests on its prior; nothing if a weight was read. */
void identification_common_gain_print(FILE *out, const struct common_gain *gain);

/* Prints the matrix at the pose that was asked for, or nothing if none was. */
void identification_at_pose_print(FILE *out, const struct matrix_at_pose *at);

#endif
