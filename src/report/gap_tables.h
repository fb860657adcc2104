/* Tables of a gap report. The table of parameters (table_parameters()) stands on the report's first
 * screen, the other tables below it. */
#ifndef HEXID_GAP_TABLES_H
#define HEXID_GAP_TABLES_H

#include "gap_html.h"

/* Writes the statements about effects with their probabilities (struct gap_statement); nothing if
 * there are none. */
void table_statements(FILE *out, const struct gap_result *r);
void table_hypotheses(FILE *out, const struct gap_result *r);
/* Writes the gap in each channel, in display units (picture_units) and normalised by the measured
 * variation. */
void table_numbers(FILE *out, const struct gap_report *report);
void table_base(FILE *out, const struct gap_result *r);
/* Writes the inertia matrices by method A, as measured and as simulated; nothing if none was
 * identified. */
void table_matrix(FILE *out, const struct gap_result *r);

/* Writes keys, values and 95 % intervals of an effect. If each leg has its own value, writes only
 * the least and the largest; table_legs() lists them all. */
void table_parameters(FILE *out, const struct gap_effect *e);
void table_legs(FILE *out, const struct gap_result *r); /* writes nothing if no effect has a value
                                                         * for each leg */

#endif
