#include "method_c_verdict.h"

#include <math.h>

#include "lin.h"
#include "numeric.h"

/* level: probability by which the check may fail a true result. */
typedef void check(const struct method_c_findings *f, double level, struct verdict *v);

static const char scope[] =
    "method C: the payload is a body that can exist, the matrix is that of one rigid body on the legs and is positive definite, no leg's "
    "friction drives; all at 0.5 % of false alarms together; not the error against the nominal matrix";

static void check_body(const struct method_c_findings *f, double level, struct verdict *v) {
    const struct payload *p = &f->result->payload;
    if (!p->evaluated || agreement_chi_square_above(p->impossible, PAYLOAD_VALUES) >= level) return;
    if (!(p->value[PAYLOAD_MASS] > 0.0))
        verdict_add(v, VERDICT_FAIL, "the payload's mass is %.2f +- %.2f kg (std): no body has that", p->value[PAYLOAD_MASS],
                    p->std[PAYLOAD_MASS]);
    else
        verdict_add(v, VERDICT_FAIL,
                    "no body has the payload's mass, centre and inertia: the nearest that can exist is %.1f standard deviations away",
                    sqrt(p->impossible));
}

static void check_one_body(const struct method_c_findings *f, double level, struct verdict *v) {
    enum { FREE = MATRIX_ENTRIES - PAYLOAD_VALUES };
    const struct payload *p = &f->result->payload;
    double chi_square = FREE * square(p->misfit);
    if (!p->evaluated || agreement_chi_square_above(chi_square, FREE) >= level) return;
    verdict_add(
        v, VERDICT_FAIL,
        "the matrix is not that of one rigid body on these legs: chi-square %.0f of %d degrees of freedom; a sensor is wrong, or the "
        "geometry, or something bends",
        chi_square, FREE);
}

/* Variance of v' Mt v. */
static double variance_along(const struct estimate *e, const double direction[DOFS]) {
    double weight[MATRIX_ENTRIES], sum = 0.0;
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int i, j;
        equations_entry(c, &i, &j);
        weight[c] = (i == j ? 1.0 : 2.0) * direction[i] * direction[j];
        for (int d = 0; d <= c; d++) sum += (d < c ? 2.0 : 1.0) * weight[c] * weight[d] * estimate_covariance(e, c, d);
    }
    return sum;
}

static void check_definite(const struct method_c_findings *f, double level, struct verdict *v) {
    double mt[DOFS][DOFS], unit[DOFS][DOFS] = {{0}}, eigenvalue[DOFS], vector[DOFS][DOFS];
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int i, j;
        equations_entry(c, &i, &j);
        mt[i][j] = mt[j][i] = f->nominal[i][j] + f->estimate->value[c];
    }
    /* Eigenvalues relative to the configured diagonal have no unit. */
    for (int i = 0; i < DOFS; i++) unit[i][i] = f->nominal[i][i];
    bool found = !lin_eigenvectors(DOFS, mt[0], unit[0], eigenvalue, vector[0]);
    if (found && eigenvalue[0] > 0.0) return;
    double chi_square = found ? square(eigenvalue[0]) / variance_along(f->estimate, vector[0]) : HUGE_VAL;
    if (agreement_chi_square_above(chi_square, MATRIX_ENTRIES) < level)
        verdict_add(v, VERDICT_FAIL, "Mt is not positive definite, by %.1f standard deviations: no inertia matrix", sqrt(chi_square));
}

/* Fails friction that is negative with less than this probability. */
static void check_dissipates(double value, double variance, double level, const char *what, int leg, struct verdict *v) {
    double std = sqrt(variance);
    if (0.5 * erfc(-value / std / sqrt(2.0)) >= level) return;
    verdict_add(v, VERDICT_FAIL, "%s friction of leg %d is negative, %.1f standard deviations below 0: it would drive the leg", what,
                leg + 1, -value / std);
}

/* A constant error of the force enters both directions of dry friction with opposite signs, and
 * their mean not at all. */
static void check_friction(const struct method_c_findings *f, double level, struct verdict *v) {
    const struct estimate *e = f->estimate;
    for (int leg = 0; leg < LEGS; leg++) {
        int viscous = UNKNOWN_VISCOUS + leg, extend = UNKNOWN_DRY + 2 * leg, retract = extend + 1;
        double dry = 0.5 * (e->value[extend] + e->value[retract]);
        double variance = 0.25 * (estimate_covariance(e, extend, extend) + estimate_covariance(e, retract, retract) +
                                  2.0 * estimate_covariance(e, extend, retract));
        check_dissipates(e->value[viscous], estimate_covariance(e, viscous, viscous), level / (2 * LEGS), "viscous", leg, v);
        check_dissipates(dry, variance, level / (2 * LEGS), "dry", leg, v);
    }
}

static check *const checks[] = {check_body, check_one_body, check_definite, check_friction};
enum { CHECKS = sizeof checks / sizeof *checks };

struct verdict method_c_verdict(const struct method_c_findings *f) {
    struct verdict v = {.status = VERDICT_PASS, .scope = scope};
    for (int i = 0; i < CHECKS; i++) checks[i](f, METHOD_C_FALSE_ALARMS / CHECKS, &v);
    return v;
}

struct verdict method_c_no_verdict(const char *reason) {
    struct verdict v = {.status = VERDICT_NOT_EVALUATED, .scope = scope};
    if (reason) verdict_add(&v, VERDICT_NOT_EVALUATED, "%s", reason);
    return v;
}
