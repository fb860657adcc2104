#include "method_c.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calibration.h"
#include "kinematics.h"
#include "lin.h"
#include "nominal.h"
#include "numeric.h"
#include "params.h"

static const double UNDETERMINED = 0.2;          /* an entry is determined if its standard deviation
                                                  * is less than this share of sqrt(M_ii M_jj) */
static const double UNDETERMINED_FRICTION = 0.1; /* friction is determined if its standard deviation
                                                  * (for viscous friction times the legs' rms speed)
                                                  * is less than this share of the varying force */
static const double FREE = 10.0;                 /* rigidity so large that the prior of one rigid
                                                  * body has no effect on the entries */
static const double UNDETERMINED_SPRING = 0.5;   /* a spring is determined if its standard deviation
                                                  * is less than this share of its prior's */

/* Condition number of the entries' normal matrix, the inverse of their noise covariance, in units
 * of sqrt(M_ii M_jj), with friction eliminated. */
static double condition_of(const struct estimate *e, double nominal[DOFS][DOFS]) {
    double scaled[MATRIX_ENTRIES][MATRIX_ENTRIES], scale[MATRIX_ENTRIES], eigenvalue[MATRIX_ENTRIES];
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int i, j;
        equations_entry(c, &i, &j);
        scale[c] = sqrt(nominal[i][i] * nominal[j][j]);
        for (int d = 0; d <= c; d++) scaled[c][d] = e->noise[c][d] / (scale[c] * scale[d]);
    }
    if (lin_eigenvalues(MATRIX_ENTRIES, scaled[0], eigenvalue)) return (double)NAN;
    return eigenvalue[0] > 0.0 ? eigenvalue[MATRIX_ENTRIES - 1] / eigenvalue[0] : (double)INFINITY;
}

static double known(double value, bool determined) { return determined ? value : (double)NAN; }

static void report_matrix(const struct estimate *e, double nominal[DOFS][DOFS], struct method_result *m) {
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int i, j;
        equations_entry(c, &i, &j);
        double std = sqrt(estimate_covariance(e, c, c));
        bool determined = std < UNDETERMINED * sqrt(nominal[i][i] * nominal[j][j]);
        m->mt[i][j] = m->mt[j][i] = known(nominal[i][j] + e->value[c], determined);
        m->mt_std[i][j] = m->mt_std[j][i] = known(std, determined);
    }
    m->condition_number = condition_of(e, nominal);
    m->evaluated = true;
}

static bool any(const struct method_result *m) {
    bool known = false;
    for (int i = 0; i < DOFS * DOFS; i++) known = known || !isnan(m->mt[i / DOFS][i % DOFS]);
    return known;
}

/* Stores the friction of the legs. Values whose standard deviation is a large share of the force's
 * whole variation were not measured, and are left NaN. */
static void report_friction(const struct estimate *e, const struct equations *of, struct method_c *m) {
    for (int c = UNKNOWN_VISCOUS; c < UNKNOWN_SPRING; c++) {
        bool viscous = c < UNKNOWN_DRY;
        int leg = viscous ? c - UNKNOWN_VISCOUS : (c - UNKNOWN_DRY) / 2, direction = (c - UNKNOWN_DRY) % 2;
        double std = sqrt(estimate_covariance(e, c, c));
        bool determined = std * (viscous ? of->rate_mps : 1.0) < UNDETERMINED_FRICTION * of->force_n;
        *(viscous ? &m->viscous[leg] : &m->dry[leg][direction]) = known(e->value[c], determined);
        *(viscous ? &m->viscous_std[leg] : &m->dry_std[leg][direction]) = known(std, determined);
    }
}

static void report_springs(const struct estimate *e, const struct equations *of, struct method_c *m) {
    for (int i = 0; i < DOFS; i++) {
        double std = sqrt(estimate_covariance(e, UNKNOWN_SPRING + i, UNKNOWN_SPRING + i));
        bool determined = std < UNDETERMINED_SPRING * of->spring[i];
        m->springs = m->springs || of->spring[i] > 0.0;
        m->spring[i] = known(e->value[UNKNOWN_SPRING + i], determined), m->spring_std[i] = known(std, determined);
    }
}

const char *method_c_cause(int cause) {
    static const char *const other[] = {"masses of the legs", "attenuation", "noise"};
    return cause < FAMILIES ? systematic_families[cause].name : other[cause - FAMILIES];
}

bool method_c_found(const struct systematic_found *error) { return error->prior > 0.0 && fabs(error->value) > NUMERIC_95 * error->std; }

static int cause_of(int common) {
    if (common < SYSTEMATICS) return (int)systematic_family(common);
    if (common >= COMMON_CALIBRATION + CALIBRATION_STOP) return FAMILY_LENGTH_ZEROS;
    if (common == COMMON_CALIBRATION + CALIBRATION_WEIGHT) return FAMILY_PRESSURE_GAINS;
    return common < COMMON_ATTENUATION ? CAUSE_LEGS : CAUSE_ATTENUATION;
}

static void report_systematic(const struct estimate *e, const struct equations *of, struct method_c *m) {
    for (int s = 0; s < SYSTEMATICS; s++) {
        int unknown = UNKNOWN_SYSTEMATIC + s;
        m->systematic[s] = (struct systematic_found){e->value[unknown], sqrt(estimate_covariance(e, unknown, unknown)), of->systematic[s]};
    }
    m->systematic[SYSTEMATIC_COMPLIANCE].std = e->compliance_std;
    m->skew_test_s = e->skew_test_s;
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int i, j;
        double variance = estimate_covariance(e, c, c);
        equations_entry(c, &i, &j);
        m->share[CAUSE_NOISE][i][j] = e->noise[c][c] / variance;
        for (int k = 0; k < COMMON; k++) m->share[cause_of(k)][i][j] += e->common[k][c] * e->common[k][c] / variance;
        for (int k = 0; k < CAUSES; k++) m->share[k][j][i] = m->share[k][i][j];
    }
}

static struct payload payload_of(const struct estimate *e, double nominal[DOFS][DOFS], const struct params *configured,
                                 const struct kinematics *k) {
    double value[MATRIX_ENTRIES], covariance[MATRIX_ENTRIES][MATRIX_ENTRIES];
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int i, j;
        equations_entry(c, &i, &j);
        value[c] = nominal[i][j] + e->value[c];
        for (int d = 0; d < MATRIX_ENTRIES; d++) covariance[c][d] = estimate_covariance(e, c, d);
    }
    return payload_find(configured, k, value, covariance);
}

static bool solve(const struct equations *e, const struct params *configured, const struct kinematics *k, double rigidity,
                  struct estimate *estimate) {
    double prior[MATRIX_ENTRIES][MATRIX_ENTRIES];
    bool solved = payload_prior(configured, k, rigidity, prior) && equations_solve(e, prior, estimate);
    if (solved) calibration_apply(configured, k, estimate);
    return solved;
}

int method_c_solve(const struct equations *e, const struct params *configured, struct estimate *estimate, struct method_c *result,
                   struct error *error) {
    static const double neutral[DOFS] = {0};
    struct kinematics k;
    double nominal[DOFS][DOFS];
    *result = (struct method_c){0};
    int status = kinematics_init(&k, configured, error);
    if (status) return status;
    nominal_matrix(configured, &k, neutral, nominal);
    if (!solve(e, configured, &k, configured->model.tolerance.rigidity, estimate))
        return error_set(error, STATUS_USAGE, "method C: some leg does not move both ways");
    report_matrix(estimate, nominal, &result->matrix);
    if (!any(&result->matrix)) {
        result->matrix.evaluated = false;
        return error_set(error, STATUS_USAGE,
                         "method C: no entry of the matrix is determined: the motion is too small or too slow against the sensors' "
                         "noise; move farther, faster or for longer");
    }
    result->scatter = equations_scatter(e);
    report_friction(estimate, e, result);
    report_springs(estimate, e, result);
    report_systematic(estimate, e, result);
    /* The payload is fitted to a matrix that was estimated without the prior of one rigid body. */
    struct estimate *free_entries = malloc(sizeof *free_entries);
    if (free_entries && solve(e, configured, &k, FREE, free_entries)) result->payload = payload_of(free_entries, nominal, configured, &k);
    free(free_entries);
    return STATUS_OK;
}

double method_c_value(const struct method_c *m, int unknown, double *std) {
    int i, j, viscous = unknown - UNKNOWN_VISCOUS, dry = unknown - UNKNOWN_DRY, spring = unknown - UNKNOWN_SPRING;
    if (spring >= 0) {
        *std = m->spring_std[spring];
        return m->spring[spring];
    }
    if (dry >= 0) {
        *std = m->dry_std[dry / 2][dry % 2];
        return m->dry[dry / 2][dry % 2];
    }
    if (viscous >= 0) {
        *std = m->viscous_std[viscous];
        return m->viscous[viscous];
    }
    equations_entry(unknown, &i, &j);
    *std = m->matrix.mt_std[i][j];
    return m->matrix.mt[i][j];
}

int method_c(const struct recording *recording, struct method_c *result, struct error *error) {
    struct equations *equations = malloc(sizeof *equations);
    struct estimate *estimate = malloc(sizeof *estimate);
    int status = equations && estimate ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
    if (!status) status = method_c_equations(recording, equations, error);
    if (!status) status = method_c_solve(equations, recording->params, estimate, result, error);
    free(equations);
    free(estimate);
    return status;
}

int method_c_at_pose(struct method_c *m, const struct params *params, const double pose[DOFS], struct error *error) {
    struct kinematics k;
    double length_m[LEGS];
    int status = kinematics_init(&k, params, error);
    if (status) return status;
    ik_lengths(&k, pose, length_m);
    for (int i = 0; i < LEGS; i++) {
        struct stroke stroke = kinematics_stroke(&k, &params->actuator, i);
        if (!(length_m[i] >= stroke.least_m && length_m[i] <= stroke.most_m))
            return error_set(error, STATUS_USAGE,
                             "--pose: leg %d would be %.4g m long, and has %.4g to %.4g m; give a pose within the strokes", i + 1,
                             length_m[i], stroke.least_m, stroke.most_m);
    }
    m->at_pose = (struct matrix_at_pose){.asked = true, .determined = m->payload.evaluated && m->payload.whole};
    memcpy(m->at_pose.pose, pose, sizeof m->at_pose.pose);
    if (m->at_pose.determined) payload_matrix(&m->payload, params, &k, pose, m->at_pose.mt);
    return STATUS_OK;
}
