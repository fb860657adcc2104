/* Several logs of one machine: each log's result beside that of all logs together (equations.h),
 * and whether they agree (agreement.h). */
#ifndef HEXID_COMBINATION_H
#define HEXID_COMBINATION_H

#include <stdio.h>

#include "agreement.h"
#include "identification_json.h"

struct combination_log {
    const char *path;
    const struct identification *id;  /* its method C is evaluated */
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

/* Fails if the logs disagree, naming the values that are apart, or if a log's own verdict fails; is
 * not evaluated if entries remain undetermined. */
struct verdict combination_verdict(const struct combination *c);

/* Prints one column a log, then one for all logs together and one for its standard deviation, with
 * a star at values that are apart; then the verdict. */
void combination_table_print(FILE *out, const struct combination *c);

/* Schema hexid.identifications/1: "logs", each a hexid.identification/1 with its path as "log";
 * "combined"; "agreement"; "verdict". The caller frees it. NULL without memory. */
char *combination_json(const struct combination *c);

/* Unit of an entry, a friction or a spring, by its place in the equations. */
const char *combination_unit(int value);

#endif
