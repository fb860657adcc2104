/* The result of an identification as a table for people, like Tian 2015's Table 3. */
#ifndef HEXID_IDENTIFICATION_TABLE_H
#define HEXID_IDENTIFICATION_TABLE_H

#include <stdio.h>

#include "ident.h"

/* Return the number of decimals to print: three, or, for a magnitude below one, as many as show
 * four significant figures, at most six. For a matrix the smallest diagonal entry decides. */
int identification_decimals(const double mt[DOFS][DOFS]);
int identification_decimals_of(double value);

/* Prints method C, then methods A and B; if method C was not evaluated, the reason for that is
 * printed last. Methods A and B are one line if they were not evaluated, and are left out if the
 * motion does not suit them (not `sinusoids`). */
void identification_table_print(FILE *out, const struct identification *id, bool sinusoids);

/* Prints the main results in about five lines: method C's diagonal with errors and intervals, the
 * entries that are not determined, and the methods that were not evaluated. */
void identification_brief_print(FILE *out, const struct identification *id, bool sinusoids);

/* Prints how much the data determine: how many of the 21 entries and how well, the condition
 * number, and the missing entries with the motion that they need. */
void identification_determined_print(FILE *out, const struct method_c *c, const double nominal_mt[DOFS][DOFS]);

/* Prints that the gain common to all pressure (or force) sensors is known from its prior alone;
 * nothing if a known weight was read or no gain has a prior. */
void identification_common_gain_print(FILE *out, const struct common_gain *gain);

/* Prints the matrix at the pose that was asked for, or nothing if none was. */
void identification_at_pose_print(FILE *out, const struct matrix_at_pose *at);

#endif
