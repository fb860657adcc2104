#include "equations.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "basis_sizes.h"
#include "dense.h"
#include "numeric.h"
#include "skews.h"

static const double LEAST_N = 1e-3;  /* least prior standard deviation of a basis function's
                                      * coefficient */
static const double HELD = 1e6;        /* weight of the condition that a scale is zero, as a
                                        * multiple of the weight of its prior */
static const double RIGID = 1e-3;         /* least prior standard deviation of the compliance, as a
                                           * share of the stated one */
static const double UNTOLD = 1e-6;        /* the data tell nothing of the compliance if they reduce
                                           * its variance by less than this share */
static const double OF_NO_WEIGHT = 1e-12; /* weight of a prior without influence, as a share of the
                                           * data's weight */

void equations_entry(int unknown, int *row, int *column) {
    int i = 0;
    while (unknown >= DOFS - i) unknown -= DOFS - i, i++;
    *row = i, *column = i + unknown;
}

void equations_name(int unknown, char name[EQUATIONS_NAME]) {
    static const char *const way[] = {"extending", "retracting"};
    int row, column, dry = unknown - UNKNOWN_DRY;
    if (unknown >= UNKNOWN_SYSTEMATIC) {
        systematic_name(unknown - UNKNOWN_SYSTEMATIC, name);
    } else if (unknown >= UNKNOWN_SPRING) {
        snprintf(name, EQUATIONS_NAME, "spring %s", dof_names[unknown - UNKNOWN_SPRING]);
    } else if (dry >= 0) {
        snprintf(name, EQUATIONS_NAME, "dry leg %d %s", dry / 2 + 1, way[dry % 2]);
    } else if (unknown >= UNKNOWN_VISCOUS) {
        snprintf(name, EQUATIONS_NAME, "viscous leg %d", unknown - UNKNOWN_VISCOUS + 1);
    } else {
        equations_entry(unknown, &row, &column);
        snprintf(name, EQUATIONS_NAME, "Mt%d%d", row + 1, column + 1);
    }
}

double equations_scatter(const struct equations *e) { return e->free > 0 ? sqrt(fmax(e->rest, 0.0) / e->free) : (double)NAN; }

void equations_add(struct equations *sum, const struct equations *e) {
    for (int c = 0; c < UNKNOWNS; c++) {
        sum->with[c] += e->with[c];
        for (int d = 0; d <= c; d++) sum->product[c][d] += e->product[c][d];
        sum->attenuation[c] += e->attenuation[c];
    }
    skews_join(sum, e);
    sum->cycles = sum->free ? fmin(sum->cycles, e->cycles) : e->cycles;
    sum->rest += e->rest;
    sum->free += e->free;
    sum->repeating += e->repeating;
    for (int k = 0; k < LEGS; k++) sum->dry_n[k] = fmax(sum->dry_n[k], e->dry_n[k]);
    for (int i = 0; i < DOFS; i++) sum->spring[i] = fmax(sum->spring[i], e->spring[i]);
    for (int i = 0; i < SYSTEMATICS; i++) sum->systematic[i] = fmax(sum->systematic[i], e->systematic[i]);
    sum->force_n = fmax(sum->force_n, e->force_n);
    sum->rate_mps = fmax(sum->rate_mps, e->rate_mps);
}

double equations_basis_variance(const struct equations *e, int i, const double size[BASIS_SIZE]) {
    return square(fmax(e->dry_n[i / BASIS_SIZE] * size[i % BASIS_SIZE], LEAST_N));
}

/* Inverse variance of a prior; 1 for an unknown that does not exist, whose equations are zero. */
static double inverse_variance(double std) { return std > 0.0 ? 1.0 / square(std) : 1.0; }

/* Finds a scale: the direction in which attenuation biases the gains of pressures (scale 0) or of
 * lengths (1), for one standard deviation of their priors. It is mostly the gain that all sensors
 * have in common. Least squares would make the gains too large in this direction, because that
 * makes the noise smaller, and no motion distinguishes a common gain from a mass and a friction.
 * Therefore the scale is held at zero, and its prior is an error that all logs share. Returns false
 * if there is no such bias. */
static bool scale_of(const struct equations *e, int scale, double direction[UNKNOWN_BASIS]) {
    int first = scale ? SYSTEMATIC_LENGTH_GAIN : SYSTEMATIC_P1_GAIN, end = scale ? SYSTEMATIC_LENGTH_ZERO : SYSTEMATIC_LENGTH_GAIN;
    double sum = 0.0;
    memset(direction, 0, UNKNOWN_BASIS * sizeof *direction);
    for (int s = first; s < end; s++) sum += square(e->attenuation[UNKNOWN_SYSTEMATIC + s] * e->systematic[s]);
    for (int s = first; s < end && sum > 0.0; s++)
        direction[UNKNOWN_SYSTEMATIC + s] = e->attenuation[UNKNOWN_SYSTEMATIC + s] * square(e->systematic[s]) / sqrt(sum);
    return sum > 0.0;
}

/* Holds the scales at zero. */
static void hold_scales(const struct equations *e, double factor[UNKNOWNS][UNKNOWNS]) {
    double direction[UNKNOWN_BASIS];
    for (int scale = 0; scale < GAIN_SCALES; scale++) {
        if (!scale_of(e, scale, direction)) continue;
        for (int a = 0; a < SYSTEMATIC_LENGTH_ZERO; a++)
            for (int b = 0; b <= a; b++) {
                double prior = e->systematic[a] * e->systematic[b];
                int c = UNKNOWN_SYSTEMATIC + a, d = UNKNOWN_SYSTEMATIC + b;
                if (prior > 0.0) factor[c][d] += HELD * direction[c] * direction[d] / square(prior);
            }
    }
}

/* Sets `sum` to X' W X plus the priors of all unknowns but the basis functions. */
static void add_priors(const struct equations *e, double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES], double sum[UNKNOWNS][UNKNOWNS]) {
    memcpy(sum, e->product, sizeof e->product);
    for (int c = 0; c < MATRIX_ENTRIES; c++)
        for (int d = 0; d <= c; d++) sum[c][d] += matrix[c][d];
    for (int c = MATRIX_ENTRIES; c < UNKNOWN_SPRING; c++) sum[c][c] *= 1.0 + OF_NO_WEIGHT;
    for (int i = 0; i < DOFS; i++) sum[UNKNOWN_SPRING + i][UNKNOWN_SPRING + i] += inverse_variance(e->spring[i]);
    for (int i = 0; i < SYSTEMATICS; i++) sum[UNKNOWN_SYSTEMATIC + i][UNKNOWN_SYSTEMATIC + i] += inverse_variance(e->systematic[i]);
    hold_scales(e, sum);
}

/* Adds the basis functions' prior to `factor`, and replaces the sum by its Cholesky factor. */
static bool factor_basis(const struct equations *e, const double size[BASIS_SIZE], double factor[UNKNOWNS][UNKNOWNS]) {
    for (int c = UNKNOWN_BASIS; c < UNKNOWNS; c++) factor[c][c] += 1.0 / equations_basis_variance(e, c - UNKNOWN_BASIS, size);
    return dense_factor(UNKNOWNS, UNKNOWNS, factor[0]);
}

/* Finds the size of the departures of the tests' skews; 0 if there are none. size: sizes of the
 * basis functions. */
static bool find_skew_size(const struct equations *e, double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES], const double size[BASIS_SIZE],
                           double factor[UNKNOWNS][UNKNOWNS], double *skew_size_s) {
    add_priors(e, matrix, factor);
    if (!factor_basis(e, size, factor)) return false;
    *skew_size_s = skews_size(e, factor);
    return true;
}

/* Sizes of priors that are found from the data, and the standard deviation of the compliance, with
 * the meanings that struct estimate gives them. */
struct sizes {
    double skew_test_s, compliance_prior, compliance_std;
};

/* Narrows the prior of the compliance to what the data show of it. Without a prior the data give
 * the compliance the value c with the variance v. The prior variance of greatest likelihood is c^2
 * - v, or 0 if that is negative. The variance is also 0 if c is negative, because no leg has a
 * negative compliance. The prior's standard deviation is set accordingly, but at least to RIGID
 * times the stated one and at most to the stated one. A stiff machine's intervals then stay as
 * narrow as without this unknown. own: the equations without the departures of skews. */
static bool narrow_compliance(struct equations *own, double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES], const double size[BASIS_SIZE],
                              double factor[UNKNOWNS][UNKNOWNS], struct sizes *sizes) {
    enum { COMPLIANCE = UNKNOWN_SYSTEMATIC + SYSTEMATIC_COMPLIANCE };
    double *prior = &own->systematic[SYSTEMATIC_COMPLIANCE], column[UNKNOWNS] = {0};
    if (!(*prior > 0.0)) return true;
    add_priors(own, matrix, factor);
    if (!factor_basis(own, size, factor)) return false;
    column[COMPLIANCE] = 1.0;
    dense_solve(UNKNOWNS, UNKNOWNS, factor[0], column);
    double value = dense_dot(UNKNOWNS, column, own->with), learned = 1.0 - column[COMPLIANCE] / square(*prior);
    sizes->compliance_std = sqrt(column[COMPLIANCE]);
    if (!(learned > UNTOLD)) return true;
    double size2 = value > 0.0 ? square(value / learned) - column[COMPLIANCE] / learned : 0.0;
    *prior = fmin(sqrt(fmax(size2, square(RIGID * *prior))), *prior);
    return true;
}

/* Finds the sizes of the priors that are not stated (basis functions, departures of the skews,
 * compliance), eliminates the departures of the tests' skews, and factors the remaining equations
 * with all priors. own: the equations without the departures, and with the priors as found. */
static bool factor_with_prior(const struct equations *e, double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES], struct equations *own,
                              double factor[UNKNOWNS][UNKNOWNS], struct sizes *sizes) {
    double size[BASIS_SIZE];
    *own = *e;
    *sizes = (struct sizes){0};
    skews_eliminate(own, e->skew_test_s);
    add_priors(own, matrix, factor);
    if (!basis_sizes_find(own, factor, size) || !find_skew_size(e, matrix, size, factor, &sizes->skew_test_s)) return false;
    *own = *e;
    skews_eliminate(own, sizes->skew_test_s);
    if (!narrow_compliance(own, matrix, size, factor, sizes)) return false;
    sizes->compliance_prior = own->systematic[SYSTEMATIC_COMPLIANCE];
    add_priors(own, matrix, factor);
    return basis_sizes_find(own, factor, size) && factor_basis(own, size, factor);
}

static bool values(const struct equations *e, double factor[UNKNOWNS][UNKNOWNS], double value[UNKNOWNS]) {
    bool finite = true;
    memcpy(value, e->with, sizeof e->with);
    dense_solve(UNKNOWNS, UNKNOWNS, factor[0], value);
    for (int c = 0; c < UNKNOWNS; c++) finite = finite && isfinite(value[c]);
    return finite;
}

bool equations_values(const struct equations *e, double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES], double value[UNKNOWNS],
                      double departure[SKEW_TESTS]) {
    double (*factor)[UNKNOWNS] = malloc(sizeof e->product);
    struct equations *own = malloc(sizeof *own);
    struct sizes sizes;
    bool ok = factor && own && factor_with_prior(e, matrix, own, factor, &sizes) && values(own, factor, value);
    if (ok) skews_departures(e, sizes.skew_test_s, value, departure);
    free(factor);
    free(own);
    return ok;
}

/* Adds the effect of a held scale to the effects of the gains that make it up. The scale's error is
 * still in the estimate, because the scale was held at zero. */
static void add_scale(const struct equations *e, int scale, double factor[UNKNOWNS][UNKNOWNS], struct estimate *estimate) {
    double direction[UNKNOWN_BASIS], solved[UNKNOWNS] = {0};
    if (!scale_of(e, scale, direction)) return;
    for (int c = 0; c < UNKNOWNS; c++)
        for (int d = UNKNOWN_SYSTEMATIC; d < UNKNOWN_SYSTEMATIC + SYSTEMATIC_LENGTH_ZERO; d++)
            solved[c] += (c >= d ? e->product[c][d] : e->product[d][c]) * direction[d];
    dense_solve(UNKNOWNS, UNKNOWNS, factor[0], solved);
    for (int s = 0; s < SYSTEMATIC_LENGTH_ZERO; s++)
        for (int c = 0; c < UNKNOWN_BASIS && e->systematic[s] > 0.0; c++)
            estimate->common[s][c] += (solved[c] - direction[c]) * direction[UNKNOWN_SYSTEMATIC + s] / e->systematic[s];
}

/* Splits the covariance C, which is in estimate->noise, into noise and shared errors. matrix: the
 * Cholesky factor of the inverse covariance of the matrix's prior. */
static void split(const struct equations *e, double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES], double factor[UNKNOWNS][UNKNOWNS],
                  struct estimate *estimate) {
    double solved[UNKNOWNS];
    memset(estimate->common, 0, sizeof estimate->common);
    for (int s = 0; s < SYSTEMATICS; s++)
        for (int c = 0; c < UNKNOWN_BASIS && e->systematic[s] > 0.0; c++)
            estimate->common[s][c] = -estimate->noise[UNKNOWN_SYSTEMATIC + s][c] / e->systematic[s];
    for (int m = 0; m < MATRIX_ENTRIES; m++)
        for (int c = 0; c < UNKNOWN_BASIS; c++)
            for (int i = m; i < MATRIX_ENTRIES; i++) estimate->common[COMMON_MATRIX + m][c] -= matrix[i][m] * estimate->noise[i][c];
    for (int j = 0; j < COMMON_ATTENUATION; j++)
        for (int a = 0; a < UNKNOWN_BASIS; a++)
            for (int b = 0; b < UNKNOWN_BASIS; b++) estimate->noise[a][b] -= estimate->common[j][a] * estimate->common[j][b];
    for (int scale = 0; scale < GAIN_SCALES; scale++) add_scale(e, scale, factor, estimate);
    memcpy(solved, e->attenuation, sizeof solved);
    for (int s = 0; s < SYSTEMATIC_LENGTH_ZERO; s++) solved[UNKNOWN_SYSTEMATIC + s] = 0.0;
    dense_solve(UNKNOWNS, UNKNOWNS, factor[0], solved);
    memcpy(estimate->common[COMMON_ATTENUATION], solved, sizeof estimate->common[0]);
}

/* Clears the covariance of errors that do not exist. inverse_variance() gave each of them the
 * variance 1 to keep the equations solvable. */
static void clear_absent(const struct equations *e, struct estimate *estimate) {
    for (int s = 0; s < SYSTEMATICS; s++)
        for (int c = 0; c < UNKNOWN_BASIS && !(e->systematic[s] > 0.0); c++)
            estimate->noise[UNKNOWN_SYSTEMATIC + s][c] = estimate->noise[c][UNKNOWN_SYSTEMATIC + s] = 0.0;
}

bool equations_solve(const struct equations *e, double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES], struct estimate *estimate) {
    double (*factor)[UNKNOWNS] = malloc(sizeof e->product), root[MATRIX_ENTRIES][MATRIX_ENTRIES], solved[UNKNOWNS];
    memcpy(root, matrix, sizeof root);
    struct equations *own = malloc(sizeof *own);
    struct sizes sizes = {0};
    bool ok = factor && own && dense_factor(MATRIX_ENTRIES, MATRIX_ENTRIES, root[0]) && factor_with_prior(e, matrix, own, factor, &sizes) &&
              values(own, factor, estimate->value);
    estimate->skew_test_s = sizes.skew_test_s;
    estimate->compliance_prior = sizes.compliance_prior, estimate->compliance_std = sizes.compliance_std;
    for (int c = 0; c < UNKNOWN_BASIS && ok; c++) {
        memset(solved, 0, sizeof solved);
        solved[c] = 1.0;
        dense_solve(UNKNOWNS, UNKNOWNS, factor[0], solved);
        memcpy(estimate->noise[c], solved, sizeof estimate->noise[c]);
    }
    if (ok) {
        clear_absent(own, estimate);
        split(own, root, factor, estimate);
    }
    free(factor);
    free(own);
    return ok;
}

double estimate_common(const struct estimate *e, int error, int unknown, double compliance) {
    bool scaled = error == SYSTEMATIC_COMPLIANCE && e->compliance_prior > 0.0;
    return e->common[error][unknown] * (scaled ? compliance / e->compliance_prior : 1.0);
}

double estimate_covariance(const struct estimate *e, int a, int b) {
    double sum = e->noise[a][b];
    for (int j = 0; j < COMMON; j++) sum += e->common[j][a] * e->common[j][b];
    return sum;
}
