/* Several logs of one machine: the result of each log beside that of all logs together
 * (equations.h), and whether they agree (agreement.h). */
#ifndef HEXID_COMBINATION_H
#define HEXID_COMBINATION_H

#include <stdio.h>

#include "agreement.h"
#include "identification_json.h"

struct combination_log {
    const char *path;
    const struct identification *id;  /* result of the log; method C is evaluated */
    const struct verdicts *verdicts;
    struct loop_statistics loop;
};

struct combination {
    int logs;                         /* number of logs, 2 to AGREEMENT_LOGS */
    struct combination_log log[AGREEMENT_LOGS];
    struct method_c all;              /* method C's result from all logs together */
    struct common_gain common_gain;   /* gain error that the sensors share in all logs */
    struct verdict method_c;          /* method C's verdict on `all` */
    struct agreement agreement;
    struct verdict verdict;           /* result of combination_verdict() */
};

/* Computes the verdict on several logs from all other members of `c`. The verdict fails if the logs
 * disagree, and names the values that differ significantly between the logs (at most eight), or the
 * worst value if no single one does; it also fails if a log's own verdict fails, or c->method_c
 * does. Otherwise it is not evaluated if entries remain undetermined, the logs have no determined
 * value in common, or c->method_c is not evaluated. */
struct verdict combination_verdict(const struct combination *c);

/* Prints a table with one column for each log, one for the result of all logs together, and one for
 * the half width of the 95 % interval of that result, with a star at values that differ
 * significantly from the other logs; then agreement and verdict. */
void combination_table_print(FILE *out, const struct combination *c);

/* Returns the result as JSON, schema hexid.identifications/1: "logs", each a hexid.identification/1
 * with its path as "log"; "combined"; "agreement"; "verdict". The caller frees the text. Returns
 * NULL without memory. */
char *combination_json(const struct combination *c);

#endif
