/* Verdicts on a run and on the result of each method. Every check is one that a real machine can
 * fail. The error against the nominal matrix and a condition number are not checked, only reported.
 * Pure, no heap. */
#ifndef HEXID_VERDICT_H
#define HEXID_VERDICT_H

#include <stdio.h>

#include "ident.h"

enum verdict_status { VERDICT_PASS, VERDICT_FAIL, VERDICT_NOT_EVALUATED };
enum { VERDICT_REASONS = 24, VERDICT_NOTES = 8, VERDICT_TEXT = 360 };

struct verdict {
    enum verdict_status status;
    const char *scope; /* names the checks that the verdict covers, and those that it does not */
    int reasons;
    /* Checks that failed or could not be done, each with value and limit. */
    char reason[VERDICT_REASONS][VERDICT_TEXT];
    int notes;
    /* Remarks that do not change the status: checks that do not apply to this recording, and
     * findings that are no failure, such as friction that changes as seals warm up. */
    char note[VERDICT_NOTES][VERDICT_TEXT];
};

/* The run's verdict, which decides the exit status, and the verdict of each method on its own
 * result. The run's verdict joins the verdict on its data and the verdict of one method: method C
 * if it was evaluated, otherwise method A. The scope names this method. A method without a result
 * is not evaluated. */
struct verdicts {
    struct verdict run, method_a, modified_a, method_b, method_c;
};

extern const char *const verdict_names[]; /* "pass", "fail", "not_evaluated" */

/* Facts about a run that are in no method's result. */
struct run_facts {
    bool sinusoids; /* each test moves one axis; any other motion need not yield a matrix */
    int64_t cycles, overruns; /* totals of the run */
};

/* Judges the run's data, which every method uses: complete tests, the cycle's length, excluded
 * samples, readings that change and repeat as they must, overruns. */
struct verdict verdict_of_data(const struct params *params, const struct identification *id, const struct run_facts *facts);

/* Judges one of the methods A, modified A and B: the tests' motion, and the matrix m of that
 * method, which `name` names. */
struct verdict verdict_of_matrix(const struct params *params, const struct identification *id, const struct method_result *m,
                                 const char *name);

/* Judges the run from its data's verdict, which v->run holds before the call, and from the methods'
 * verdicts in `v`; and judges methods A, modified A and B by method C if method C's result passes
 * (checks.symmetry_pct). A motion that method C refused is not evaluated, unless its tests are
 * complete but shorter than method C needs (RECORDING_CYCLES): then a note says so. If the
 * recording contradicts the configured machine, neither a method nor the run is evaluated. */
void verdict_of_run(struct verdicts *v, const struct params *params, const struct identification *id, const struct run_facts *facts);

/* Adds a reason to a verdict. NOT_EVALUATED replaces a pass; FAIL outweighs both. */
__attribute__((format(printf, 3, 4))) void verdict_add(struct verdict *v, enum verdict_status status, const char *format, ...);

/* Adds a note to a verdict, once. */
__attribute__((format(printf, 2, 3))) void verdict_note(struct verdict *v, const char *format, ...);

/* Adds another verdict's status, reasons and notes. */
void verdict_join(struct verdict *v, const struct verdict *other);

void verdict_print(const struct verdict *v, FILE *out);

#endif
