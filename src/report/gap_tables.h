/* Sections of a gap report below its first screen: the figures, as tables. */
#ifndef HEXID_GAP_TABLES_H
#define HEXID_GAP_TABLES_H

#include "gap_html.h"

void table_hypotheses(FILE *out, const struct gap_result *r);
/* each channel, SI and normalised */
void table_numbers(FILE *out, const struct gap_report *report);
void table_base(FILE *out, const struct gap_result *r);
/* writes nothing if no matrix was identified */
void table_matrix(FILE *out, const struct gap_result *r);

/* Keys, values and uncertainties of an effect found. If each leg has its own values, their spread;
 * table_legs() lists them all. */
void table_parameters(FILE *out, const struct gap_effect *e);
void table_legs(FILE *out, const struct gap_result *r); /* writes nothing if all legs are alike */

#endif
