/* Tables of an identification report: results of all logs, side by side. */
#ifndef HEXID_IDENTIFICATION_TABLES_H
#define HEXID_IDENTIFICATION_TABLES_H

#include "identification_report.h"

/* Writes the entries of ident_entries: nominal values, and those of methods A and C. */
void table_entries(FILE *out, const struct identification_report *report);

/* Writes the payload's ten parameters. Returns false, with nothing written, if no log has them. */
bool table_payload(FILE *out, const struct identification_report *report);

/* Write viscous and dry friction of each leg, and the springs. Each returns false, with nothing
 * written, if no log has them. */
bool table_friction(FILE *out, const struct identification_report *report);
bool table_springs(FILE *out, const struct identification_report *report);

/* Writes all 36 entries of the matrix, nominal and by each evaluated method with their 95 %
 * intervals. */
void table_matrices(FILE *out, const struct identification *id);

#endif
