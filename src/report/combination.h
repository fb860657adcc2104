/* Several logs of one machine: each log's result beside that of all of them together (equations.h),
 * and whether they agree (agreement.h). */
#ifndef HEXID_COMBINATION_H
#define HEXID_COMBINATION_H

#include <stdio.h>

#include "agreement.h"
#include "identification_json.h"

struct combination_log {
    const char *path;
    const struct identification *id;  /* method C is evaluated */
    const struct verdict *verdict;
    struct loop_statistics loop;
};

struct combination {
    int logs;                         /* 2 to AGREEMENT_LOGS */
    struct combination_log log[AGREEMENT_LOGS];
    struct method_c all;
    struct agreement agreement;
    struct verdict verdict;
};

/* Fails where the logs do not agree, with the values that are apart, and where a log's own verdict
 * fails; not evaluated where entries remain undetermined. */
struct verdict combination_verdict(const struct combination *c);

/* One column a log, then one of all logs together and its standard deviation; a star marks what is
 * apart. Then the verdict. */
void combination_table_print(FILE *out, const struct combination *c);

/* Schema hexid.identifications/1: "logs", each hexid.identification/1 with its path as "log";
 * "combined"; "agreement"; "verdict". To be freed by the caller; NULL without memory. */
char *combination_json(const struct combination *c);

/* Unit of an entry, a friction or a spring by its place in the equations. */
const char *combination_unit(int value);

#endif
