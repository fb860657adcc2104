#include "method_c_verdict.h"

#include <math.h>

#include "lin.h"
#include "numeric.h"

static const double KNOWN = 0.25; /* an error is judged only if the data reduce its variance by more
                                   * than this share of the prior variance */
static const double FIT_Z = 3.3;  /* quantile of the normal distribution at the level of one check,
                                   * used in the message */

/* Type of a check. level: probability with which the check may fail a true result. */
typedef void check(const struct method_c_findings *f, double level, struct verdict *v);

static const char scope[] =
    "method C: the forces fit the model within their noise, no systematic error is beyond its tolerance, all together and P2 against P1 "
    "are likely within them, the payload is a body that can exist, the matrix is that of one rigid body on the legs and is positive "
    "definite, no leg's friction drives; all at 0.5 % of false alarms together; not the error against the nominal matrix";

static void check_body(const struct method_c_findings *f, double level, struct verdict *v) {
    const struct payload *p = &f->result->payload;
    if (!p->evaluated || agreement_chi_square_above(p->impossible, PAYLOAD_VALUES) >= level) return;
    if (!(p->value[PAYLOAD_MASS] > 0.0))
        verdict_add(v, VERDICT_FAIL, "the payload's mass is %.2f +- %.2f kg: no body has that", p->value[PAYLOAD_MASS],
                    NUMERIC_95 * p->std[PAYLOAD_MASS]);
    else
        verdict_add(v, VERDICT_FAIL,
                    "no body has the payload's mass, centre and inertia: the nearest that can exist is %.1f standard deviations away",
                    sqrt(p->impossible));
}

static bool all_known(const struct method_c *m) {
    bool known = true;
    for (int i = 0; i < DOFS * DOFS; i++) known = known && !isnan(m->matrix.mt[i / DOFS][i % DOFS]);
    return known;
}

/* Fails a matrix that is not that of one rigid body. A matrix with an undetermined entry is not
 * judged, because this entry's noise is also in the others. */
static void check_one_body(const struct method_c_findings *f, double level, struct verdict *v) {
    enum { FREE = MATRIX_ENTRIES - PAYLOAD_VALUES };
    const struct payload *p = &f->result->payload;
    double chi_square = FREE * square(p->misfit);
    if (!p->evaluated || !all_known(f->result) || agreement_chi_square_above(chi_square, FREE) >= level) return;
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

/* Fails friction that is too negative to be chance: true friction of zero or more would be measured
 * this low with a probability below `level`. */
static void check_dissipates(double value, double variance, double level, const char *what, int leg, struct verdict *v) {
    double std = sqrt(variance);
    if (0.5 * erfc(-value / std / sqrt(2.0)) >= level) return;
    verdict_add(v, VERDICT_FAIL, "%s friction of leg %d is negative, %.1f standard deviations below 0: it would drive the leg", what,
                leg + 1, -value / std);
}

/* Checks viscous friction, and the mean dry friction of both directions: a constant error of the
 * force enters the two directions with opposite signs, so their mean is free of the error. */
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

/* Upper tail of the standard normal distribution. */
static double above(double z) { return 0.5 * erfc(z / sqrt(2.0)); }

/* Checks that the rows' residuals are noise. Each residual is divided by a deviation that is itself
 * estimated from the differences of the cycles, so it is distributed as Student's t with n degrees
 * of freedom, one less than the cycles. The sum of the squared residuals is nearly normal; rounding
 * errors add to its variance. */
static void check_fit(const struct method_c_findings *f, double level, struct verdict *v) {
    double n = f->equations->cycles - 1.0, free = f->equations->free;
    if (!(n > 4.0) || !(free > 0.0)) return;
    double mean = isfinite(n) ? n / (n - 2.0) : 1.0;
    double variance = isfinite(n) ? 3.0 * square(n) / ((n - 2.0) * (n - 4.0)) - square(mean) : 2.0;
    double std = sqrt(variance * free + f->equations->repeating);
    double z = (f->equations->rest - mean * free) / std, most = sqrt(mean + FIT_Z * std / free);
    if (above(z) >= level) return;
    verdict_add(v, VERDICT_FAIL,
                "the forces do not fit the model: residuals are %.2f times their noise, at most about %.2f is chance: a base or payload "
                "that bends, another force on the platform, or friction of another kind; ask `hexid gap`",
                f->result->scatter, most);
}

/* Systematic errors and their covariance; the priors of those that are `freed` are removed. */
struct errors {
    double value[SYSTEMATICS], covariance[SYSTEMATICS][SYSTEMATICS];
    bool freed[SYSTEMATICS];
};

static void take_errors(const struct method_c_findings *f, struct errors *e) {
    for (int i = 0; i < SYSTEMATICS; i++) {
        e->freed[i] = false, e->value[i] = f->result->systematic[i].value;
        for (int j = 0; j < SYSTEMATICS; j++)
            e->covariance[i][j] = estimate_covariance(f->estimate, UNKNOWN_SYSTEMATIC + i, UNKNOWN_SYSTEMATIC + j);
    }
}

/* Prior standard deviation with which an error was estimated. */
static double prior_of(const struct method_c_findings *f, int i) {
    return i == SYSTEMATIC_COMPLIANCE ? f->estimate->compliance_prior : f->result->systematic[i].prior;
}

/* Prior variance of an error less its posterior one: the variance of its estimate if the priors are
 * right. */
static double learned(const struct method_c_findings *f, const struct errors *e, int i) {
    return square(prior_of(f, i)) - e->covariance[i][i];
}

/* True if the data tell enough of an error to judge it. A compliance whose prior was narrowed to
 * nothing is not judged. */
static bool is_known(const struct method_c_findings *f, const struct errors *e, int i) {
    return learned(f, e, i) > KNOWN * square(prior_of(f, i));
}

/* Index of the error that is furthest from zero for its prior; -1: none is too far. */
static int find_furthest(const struct method_c_findings *f, const struct errors *e, double level) {
    int furthest = -1;
    double most = 0.0;
    for (int i = 0; i < SYSTEMATICS; i++) {
        double z = fabs(e->value[i]) / sqrt(learned(f, e, i));
        if (e->freed[i] || !is_known(f, e, i) || 2.0 * above(z) * SYSTEMATICS >= level || z <= most) continue;
        furthest = i, most = z;
    }
    return furthest;
}

/* Takes the prior off an error, so that the data alone tell its size, and no other error has to
 * explain what this one does. */
static void free_error(struct errors *e, int error, double prior) {
    double row[SYSTEMATICS], variance = square(prior) - e->covariance[error][error], value = e->value[error];
    for (int i = 0; i < SYSTEMATICS; i++) row[i] = e->covariance[error][i];
    for (int i = 0; i < SYSTEMATICS; i++) {
        e->value[i] += row[i] * value / variance;
        for (int j = 0; j < SYSTEMATICS; j++) e->covariance[i][j] += row[i] * row[j] / variance;
    }
    e->freed[error] = true;
}

/* Fails systematic errors that are further from zero than their priors allow, the furthest first,
 * each with the size that it has without its prior. */
static void check_systematic(const struct method_c_findings *f, double level, struct verdict *v) {
    struct errors errors;
    int found[SYSTEMATICS], count = 0;
    take_errors(f, &errors);
    for (int i; (i = find_furthest(f, &errors, level)) >= 0; found[count++] = i) free_error(&errors, i, prior_of(f, i));
    for (int n = 0; n < count; n++) {
        int i = found[n];
        const struct systematic_words *words = &systematic_families[systematic_family(i)];
        double prior = prior_of(f, i);
        char name[SYSTEMATIC_NAME];
        systematic_name(i, name);
        verdict_add(v, VERDICT_FAIL,
                    "%s: %+.3g %s +- %.2g, where model.tolerance.%s expects %.2g %s (standard deviation): correct sensor or configuration",
                    name, words->scale * errors.value[i], words->unit, NUMERIC_95 * words->scale * sqrt(errors.covariance[i][i]),
                    words->key, words->scale * prior, words->unit);
    }
}

/* Fails a difference between the gains of all P2 and of all P1. Areas that are wrong alike in all
 * legs act as a gain of all P1 and another of all P2. The common part of the two scales all forces,
 * and no motion shows it, but their difference is determined well. With P the prior covariance of
 * the gains, C the posterior one and d a unit of the difference, the estimate g has the covariance
 * P - C, and a difference s shifts it by s (P - C) P^-1 d; the best estimate of s is d' P^-1 g,
 * divided by the variance of d' P^-1 g, d' P^-1 (P - C) P^-1 d. */
static void check_areas(const struct method_c_findings *f, double level, struct verdict *v) {
    double weight[2 * LEGS], score = 0.0, prior = 0.0;
    for (int i = 0; i < 2 * LEGS; i++) {
        double variance = square(f->result->systematic[SYSTEMATIC_P1_GAIN + i].prior);
        if (!(variance > 0.0)) return;
        weight[i] = (i < LEGS ? -0.5 : 0.5) / variance;
        score += weight[i] * f->result->systematic[SYSTEMATIC_P1_GAIN + i].value;
        prior += square(weight[i]) * variance;
    }
    double information = prior;
    for (int i = 0; i < 2 * LEGS; i++)
        for (int j = 0; j < 2 * LEGS; j++)
            information -= weight[i] * weight[j] *
                           estimate_covariance(f->estimate, UNKNOWN_SYSTEMATIC + SYSTEMATIC_P1_GAIN + i,
                                               UNKNOWN_SYSTEMATIC + SYSTEMATIC_P1_GAIN + j);
    if (!(information > KNOWN * prior) || 2.0 * above(fabs(score) / sqrt(information)) >= level) return;
    verdict_add(v, VERDICT_FAIL,
                "the pressures P2 of all legs read %+.2f %% +- %.2f too much against P1, where model.tolerance.pressure_gain expects "
                "%.2f %% (standard deviation): compare the diameters of pistons and rods with actuator, then the sensors' range",
                100.0 * score / information, 100.0 * NUMERIC_95 / sqrt(information), 100.0 / sqrt(prior));
}

/* Fails systematic errors of which each alone is likely, but not all together: an error that is not
 * among the unknowns, such as wrong diameters or a sensor that is not linear, is explained by many
 * of them at once. If the priors are right, the estimates have the prior covariance less the
 * posterior one; its eigenvectors against the prior are the combinations that the data tell
 * independently. */
static void check_all_systematic(const struct method_c_findings *f, double level, struct verdict *v) {
    struct errors e;
    int judged[LIN_MAX], n = 0, degrees = 0;
    double expected[LIN_MAX * LIN_MAX], prior[LIN_MAX * LIN_MAX], share[LIN_MAX], vector[LIN_MAX * LIN_MAX], chi_square = 0.0;
    take_errors(f, &e);
    for (int i = 0; i < SYSTEMATICS && n < LIN_MAX; i++)
        if (is_known(f, &e, i)) judged[n++] = i;
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) {
            prior[a * n + b] = a == b ? square(prior_of(f, judged[a])) : 0.0;
            expected[a * n + b] = prior[a * n + b] - e.covariance[judged[a]][judged[b]];
        }
    if (!n || find_furthest(f, &e, level) >= 0 || lin_eigenvectors(n, expected, prior, share, vector)) return;
    for (int k = 0; k < n; k++) {
        double along = 0.0;
        if (!(share[k] > KNOWN)) continue;
        for (int a = 0; a < n; a++) along += vector[k * n + a] * e.value[judged[a]];
        chi_square += square(along) / share[k], degrees++;
    }
    if (agreement_chi_square_above(chi_square, degrees) >= level) return;
    verdict_add(
        v, VERDICT_FAIL,
        "the errors of the sensors and the drawing are together further from zero than model.tolerance allows: chi-square %.0f of %d "
        "degrees of freedom, though none by itself: compare diameters, masses of the legs and data sheets with the configuration",
        chi_square, degrees);
}

/* Fails a calibration whose reading is too far from the one predicted from motion and priors. */
static void check_calibration(const struct method_c_findings *f, double level, struct verdict *v) {
    for (int i = 0; i < CALIBRATIONS; i++) {
        double z = f->estimate->surprise[i];
        if (2.0 * above(fabs(z)) * CALIBRATIONS >= level) continue;
        if (i == CALIBRATION_WEIGHT)
            verdict_add(v, VERDICT_FAIL,
                        "the known weight reads %.1f standard deviations too %s for model.tolerance.pressure_gain: check the weight, "
                        "payload.gravity_mps2 and actuator's diameters, then the gains that all pressures have in common",
                        fabs(z), z > 0.0 ? "much" : "little");
        else
            verdict_add(v, VERDICT_FAIL,
                        "leg %d at rest reads %.1f standard deviations too %s for actuator.retracted_m and model.tolerance.length_zero_m: "
                        "is it on its lower stop then? If it is, correct its zero",
                        i - CALIBRATION_STOP + 1, fabs(z), z > 0.0 ? "much" : "little");
    }
}

static check *const checks[] = {check_calibration, check_systematic, check_areas,    check_all_systematic, check_fit,
                                check_body,        check_one_body,   check_definite, check_friction};
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
