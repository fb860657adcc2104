/* Method C's verdict: can a machine have this result, within its covariance?
 *
 * Each check is a statistical test, whose statistic has a known distribution for a true result:
 *
 *   fit        sum of squared residuals of the rows, whose noise is estimated from the cycles, so
 *              that each residual is distributed as Student's t: one-sided normal test
 *   systematic no systematic error of sensors or joints is further from zero than its prior
 *              allows: two-sided normal tests
 *   areas      the gains of all P2 do not differ from those of all P1, as wrong diameters would
 *              make them: two-sided normal test
 *   all systematic the systematic errors that the data determine (at most LIN_MAX) are together
 *              likely: chi-square of the number of combinations that the data determine
 *              independently; not checked if one error fails by itself
 *   calibration a known weight and legs on their stops have the readings predicted from motion and
 *              priors: two-sided normal tests
 *   body       squared distance of the payload from the nearest body of positive density, which is
 *              no farther than the true body: at most a chi-square of ten degrees of freedom
 *   one body   the matrix less the legs' part is that of one rigid body: chi-square, 21 - 10
 *   definite   v' Mt v > 0 for every v: the square of a negative v' Mt v over its variance is at
 *              most a chi-square of 21 (Scheffe), however v was chosen
 *   friction   no leg's viscous or mean dry friction is negative: one-sided normal tests
 *
 * All checks together fail at most METHOD_C_FALSE_ALARMS of true results. Each check has an equal
 * share of this probability (Bonferroni), and a check of several values divides its share among
 * them. A new check is a new row of the table in the .c file, which also sets the shares. Pure, no
 * heap. */
#ifndef HEXID_METHOD_C_VERDICT_H
#define HEXID_METHOD_C_VERDICT_H

#include "verdict.h"

#define METHOD_C_FALSE_ALARMS 0.005

/* Result of method C with the equations and estimate that it comes from. */
struct method_c_findings {
    const struct method_c *result;
    const struct equations *equations;
    const struct estimate *estimate;
    const double (*nominal)[DOFS]; /* configured inertia matrix at neutral */
};

/* Judges a result of method_c_solve(). Undetermined values are judged, too, each with its large
 * variance; only the check `one body` needs a matrix whose entries are all determined. */
struct verdict method_c_verdict(const struct method_c_findings *f);

/* Returns the verdict of method C if it has no result: VERDICT_NOT_EVALUATED. reason: why there is
 * none; NULL: method C was not asked for. */
struct verdict method_c_no_verdict(const char *reason);

#endif
