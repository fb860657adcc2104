/* Sections of a gap report below its first screen: figures in tables. */
#ifndef HEXID_GAP_TABLES_H
#define HEXID_GAP_TABLES_H

#include "gap_html.h"

/* Writes the probable statements about effects, if a part of the gap remains unexplained; nothing
 * if there are none. */
void table_statements(FILE *out, const struct gap_result *r);
void table_hypotheses(FILE *out, const struct gap_result *r);
/* Writes the gap in each channel, in SI units and normalised by the measured variation. */
void table_numbers(FILE *out, const struct gap_report *report);
void table_base(FILE *out, const struct gap_result *r);
/* Writes nothing if no matrix was identified. */
void table_matrix(FILE *out, const struct gap_result *r);

/* Writes keys, values and uncertainties of an effect found; the spread of the values if each leg
 * has its own. table_legs() lists these. */
void table_parameters(FILE *out, const struct gap_effect *e);
void table_legs(FILE *out, const struct gap_result *r); /* writes nothing if no effect has a value
                                                         * for each leg */

#endif
