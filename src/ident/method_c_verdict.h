/* Method C's verdict: is its result one that a machine can have, as far as its covariance tells?
 *
 * Each check is a statistical test, whose statistic has a known distribution for a true result:
 *
 *   fit        residuals of the rows, whose noise is estimated from the cycles: Student's t
 *   systematic no systematic error of sensors and drawing is further from zero than its prior
 *              allows: two-sided normal tests
 *   calibration a known weight and legs on their stops read what motion and priors let expect:
 *              two-sided normal tests
 *   body       the squared distance of the payload from the nearest body of positive density is at
 *              most that from the true one, a chi-square of ten degrees of freedom
 *   one body   the matrix without its legs is that of one rigid body: chi-square, 21 - 10
 *   definite   v' Mt v > 0 for every v: the square of a negative one over its variance is at most a
 *              chi-square of 21 (Scheffe), whatever made us choose v
 *   friction   no leg's viscous or mean dry friction is negative: one-sided normal tests
 *
 * All checks together fail at most METHOD_C_FALSE_ALARMS of true results: each has an equal share
 * of that (Bonferroni), and a check of several values divides its share among them. A further check
 * is a further row of the table in the .c file; the shares follow. Pure, no heap. */
#ifndef HEXID_METHOD_C_VERDICT_H
#define HEXID_METHOD_C_VERDICT_H

#include "verdict.h"

#define METHOD_C_FALSE_ALARMS 0.005

/* All that method C found. */
struct method_c_findings {
    const struct method_c *result;
    const struct equations *equations;
    const struct estimate *estimate;
    const double (*nominal)[DOFS]; /* configured inertia matrix at neutral */
};

/* Judges a result of method_c_solve(). Undetermined values are judged too, by the wide covariance
 * that they have. */
struct verdict method_c_verdict(const struct method_c_findings *f);

/* The verdict where there is no result: not evaluated. reason: why; NULL: it has not been asked. */
struct verdict method_c_no_verdict(const char *reason);

#endif
