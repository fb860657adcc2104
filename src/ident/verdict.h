/* The checks of a run: those that a real machine can fail, against params.checks. The error against
 * the nominal matrix is reported, never a check, and no condition number is one. Pure, no heap. */
#ifndef HEXID_VERDICT_H
#define HEXID_VERDICT_H

#include <stdio.h>

#include "ident.h"

enum verdict_status { VERDICT_PASS, VERDICT_FAIL, VERDICT_NOT_EVALUATED };
enum { VERDICT_REASONS = 24, VERDICT_TEXT = 120 };

struct verdict {
    enum verdict_status status;
    const char *scope; /* what it is about, and what it is not */
    int reasons;
    char reason[VERDICT_REASONS][VERDICT_TEXT]; /* what failed or could not be evaluated,
                                                 * with value and limit */
};

extern const char *const verdict_names[]; /* pass, fail, not_evaluated */

/* sinusoids: the tests are of one axis after another; any other motion need not give a matrix.
 * Cycles and overruns are of the whole run. A failed check outweighs one that could not be
 * evaluated. */
struct verdict ident_verdict(const struct params *params, const struct identification *id, bool sinusoids, int64_t cycles,
                             int64_t overruns);

/* Adds a reason. NOT_EVALUATED turns a pass into that; FAIL outweighs both. */
__attribute__((format(printf, 3, 4))) void verdict_add(struct verdict *v, enum verdict_status status, const char *format, ...);

void verdict_print(const struct verdict *v, FILE *out);

#endif
