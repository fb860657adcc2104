/* Tables of an identification report: the results, log beside log. */
#ifndef HEXID_IDENTIFICATION_TABLES_H
#define HEXID_IDENTIFICATION_TABLES_H

#include "identification_report.h"

/* Nominal, method A and method C of ident_entries. */
void table_entries(FILE *out, const struct identification_report *report);

/* The payload's ten parameters. Returns false, with nothing written, if no log has them. */
bool table_payload(FILE *out, const struct identification_report *report);

/* Viscous and dry friction of each leg, and springs. Both return false if no log has them. */
bool table_friction(FILE *out, const struct identification_report *report);
bool table_springs(FILE *out, const struct identification_report *report);

/* All 36 entries of each method with their 95 % intervals. */
void table_matrices(FILE *out, const struct identification *id);

/* Writes "272.36 ± 0.74": two digits of the deviation; a dash if the value is not known. */
void table_estimate(FILE *out, double value, double deviation);

#endif
