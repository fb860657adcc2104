/* Several logs of one machine: the result of each log beside that of all logs together
 * (equations.h), and whether they agree (agreement.h). */
#ifndef HEXID_COMBINATION_H
#define HEXID_COMBINATION_H

#include <stdio.h>

#include "agreement.h"
#include "identification_json.h"

struct combination_log {
    const char *path;
    const struct identification *id;  /* result of the log, which has a matrix by method C */
    const struct verdicts *verdicts;
    struct loop_statistics loop;
};

struct combination {
    int logs;                         /* number of logs, 2 to AGREEMENT_LOGS */
    struct combination_log log[AGREEMENT_LOGS];
    struct method_c all;
    struct common_gain common_gain;   /* of the sensors of all logs */
    struct verdict method_c;          /* method C's verdict on `all` */
    struct agreement agreement;
    struct verdict verdict;
};

/* Judges several logs. The verdict fails if the logs disagree, and names the values that are
 * apart; it also fails if a log's own verdict fails, or method C's on all of them. It is not
 * evaluated if entries remain undetermined. */
struct verdict combination_verdict(const struct combination *c);

/* Prints one column for each log, then one for all logs together and one for its standard
 * deviation, with a star at values that are apart; then the verdict. */
void combination_table_print(FILE *out, const struct combination *c);

/* Returns the result as JSON, schema hexid.identifications/1: "logs", each a hexid.identification/1
 * with its path as "log"; "combined"; "agreement"; "verdict". The caller frees the text. NULL
 * without memory. */
char *combination_json(const struct combination *c);

#endif
