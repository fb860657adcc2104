/* The checks of a run that a real machine can fail, against params.checks. Neither the error
 * against the nominal matrix nor a condition number is a check; both are only reported. Pure, no
 * heap. */
#ifndef HEXID_VERDICT_H
#define HEXID_VERDICT_H

#include <stdio.h>

#include "ident.h"

enum verdict_status { VERDICT_PASS, VERDICT_FAIL, VERDICT_NOT_EVALUATED };
enum { VERDICT_REASONS = 24, VERDICT_TEXT = 160 };

struct verdict {
    enum verdict_status status;
    const char *scope; /* names the checks that the verdict covers, and those that it does not */
    int reasons;
    /* Checks that failed or could not be done, each with value and limit. */
    char reason[VERDICT_REASONS][VERDICT_TEXT];
};

extern const char *const verdict_names[]; /* "pass", "fail", "not_evaluated" */

/* Judges a run. sinusoids: each test moves one axis; any other motion need not yield a matrix.
 * cycles, overruns: totals of the run. A failed check outweighs a check that could not be done. */
struct verdict ident_verdict(const struct params *params, const struct identification *id, bool sinusoids, int64_t cycles,
                             int64_t overruns);

/* Adds a reason to a verdict. NOT_EVALUATED replaces a pass; FAIL outweighs both. */
__attribute__((format(printf, 3, 4))) void verdict_add(struct verdict *v, enum verdict_status status, const char *format, ...);

void verdict_print(const struct verdict *v, FILE *out);

#endif
