/* Method C's verdict on results whose errors have the stated covariance: right results pass, except
 * for the stated share of false alarms, and impossible ones fail by name. */
#include "support.h"

#include "method_c_verdict.h"
#include "nominal.h"
#include "numeric.h"

static const double SHARE = 2e-3;          /* standard deviation of an entry, in sqrt(M_ii M_jj) */
static const double VISCOUS_STD = 30.0, DRY_STD = 3.0;

struct result {
    struct params params;
    struct kinematics kinematics;
    double nominal[DOFS][DOFS];
    struct method_c found;
    struct equations equations;
    struct estimate estimate;
};

/* Returns the result of a machine whose payload has these values, as method C would find it without
 * error. */
static struct result *result_of(const double payload[PAYLOAD_VALUES]) {
    static struct result result;
    static const double neutral[DOFS] = {0};
    struct result *r = &result;
    struct error error;
    struct params truth;
    double mt[DOFS][DOFS];
    memset(r, 0, sizeof *r);
    config_default(&r->params);
    assert_int_equal(kinematics_init(&r->kinematics, &r->params, &error), 0);
    nominal_matrix(&r->params, &r->kinematics, neutral, r->nominal);
    truth = r->params;
    truth.payload = (struct payload_params){
        .mass_kg = payload[0], .inertia_xx_kg_m2 = payload[4], .inertia_yy_kg_m2 = payload[5], .inertia_zz_kg_m2 = payload[6]};
    nominal_matrix(&truth, &r->kinematics, neutral, mt);
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int i, j;
        equations_entry(c, &i, &j);
        r->estimate.value[c] = mt[i][j] - r->nominal[i][j];
        r->estimate.noise[c][c] = pow(SHARE, 2.0) * r->nominal[i][i] * r->nominal[j][j];
    }
    for (int c = UNKNOWN_VISCOUS; c < UNKNOWN_SPRING; c++) {
        r->estimate.value[c] = c < UNKNOWN_DRY ? 2000.0 : 50.0;
        r->estimate.noise[c][c] = pow(c < UNKNOWN_DRY ? VISCOUS_STD : DRY_STD, 2.0);
    }
    return r;
}

static struct verdict judge(struct result *r) {
    double entry[MATRIX_ENTRIES], covariance[MATRIX_ENTRIES][MATRIX_ENTRIES];
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        int i, j;
        equations_entry(c, &i, &j);
        entry[c] = r->nominal[i][j] + r->estimate.value[c];
        for (int d = 0; d < MATRIX_ENTRIES; d++) covariance[c][d] = estimate_covariance(&r->estimate, c, d);
    }
    r->found.matrix.evaluated = true;
    r->found.payload = payload_find(&r->params, &r->kinematics, entry, covariance);
    return method_c_verdict(&(struct method_c_findings){
        .result = &r->found, .equations = &r->equations, .estimate = &r->estimate, .nominal = (const double (*)[DOFS])r->nominal});
}

/* Returns a nearly normal number of variance 1: a sum of twelve uniform ones. */
static double normal(uint64_t *seed) {
    double sum = 0.0;
    for (int i = 0; i < 12; i++) sum += 0.5 * random_unit(seed);
    return sum;
}

static void draw(struct result *r, uint64_t *seed) {
    for (int c = 0; c < UNKNOWN_SPRING; c++) r->estimate.value[c] += sqrt(r->estimate.noise[c][c]) * normal(seed);
}

static const double body[PAYLOAD_VALUES] = {180, 0, 0, 0, 13, 13, 24};
/* A plate without thickness is the limit of what a body can be. */
static const double plate[PAYLOAD_VALUES] = {180, 0, 0, 0, 12, 12, 24};

static void expect(struct result *r, const char *words) {
    struct verdict v = judge(r);
    if (v.status != VERDICT_FAIL || !v.reasons) fail_msg("%s, not fail: %s", verdict_names[v.status], words);
    if (!strstr(v.reason[0], words)) fail_msg("\"%s\" does not say \"%s\"", v.reason[0], words);
}

static void true_results_fail_in_less_than_the_stated_share(void **unused) {
    (void)unused;
    slow_case();
    const int trials = more_cases() ? 4000 : random_cases(2000);
    const double *const truth[] = {body, plate};
    for (int i = 0; i < 2; i++) {
        uint64_t seed = 7;
        int failed = 0;
        for (int trial = 0; trial < trials; trial++) {
            struct result *r = result_of(truth[i]);
            draw(r, &seed);
            failed += judge(r).status != VERDICT_PASS;
        }
        /* limit: three standard deviations above the mean number of false alarms */
        double most = trials * METHOD_C_FALSE_ALARMS;
        assert_below(failed, most + 3.0 * sqrt(most));
    }
}

static void a_negative_mass_fails(void **unused) {
    (void)unused;
    static const double negative[PAYLOAD_VALUES] = {-20, 0, 0, 0, 13, 13, 24};
    expect(result_of(negative), "the payload's mass is -20.00");
}

static void a_body_beyond_its_covariance_fails_and_one_within_passes(void **unused) {
    (void)unused;
    static const double within[PAYLOAD_VALUES] = {180, 0, 0, 0, 12, 12, 24.1}, beyond[PAYLOAD_VALUES] = {180, 0, 0, 0, 5, 5, 24};
    struct result *r = result_of(within);
    assert_int_equal(judge(r).status, VERDICT_PASS);
    assert_false(r->found.payload.possible);
    expect(result_of(beyond), "no body has the payload's mass, centre and inertia");
}

/* A coupling that no rigid body has: Mt16 beside Mt34, of the opposite sign. */
static void a_matrix_that_is_not_of_one_body_fails(void **unused) {
    (void)unused;
    struct result *r = result_of(body);
    r->estimate.value[1] += 20 * sqrt(r->estimate.noise[1][1]);
    expect(r, "not that of one rigid body");
}

static void friction_that_drives_fails_from_its_share_of_the_level_on(void **unused) {
    (void)unused;
    /* Nine checks share the level of 0.005, and the twelve frictions share one check's part: the
     * one-sided normal quantile is 3.91. */
    for (int leg = 0; leg < LEGS; leg++) {
        struct result *r = result_of(body);
        char words[80];
        r->estimate.value[UNKNOWN_VISCOUS + leg] = -3.8 * VISCOUS_STD;
        assert_int_equal(judge(r).status, VERDICT_PASS);
        r->estimate.value[UNKNOWN_VISCOUS + leg] = -4.0 * VISCOUS_STD;
        snprintf(words, sizeof words, "viscous friction of leg %d is negative", leg + 1);
        expect(r, words);
        r = result_of(body);
        /* a constant error of the force is not friction */
        r->estimate.value[UNKNOWN_DRY + 2 * leg] = -500, r->estimate.value[UNKNOWN_DRY + 2 * leg + 1] = 501;
        assert_int_equal(judge(r).status, VERDICT_PASS);
        r->estimate.value[UNKNOWN_DRY + 2 * leg] = -500 - 8 * DRY_STD;
        snprintf(words, sizeof words, "dry friction of leg %d is negative", leg + 1);
        expect(r, words);
    }
}

/* The squares of Student's t with 19 degrees of freedom have mean 1.118 and variance 3.00. The
 * normal quantile of a sixth of 0.005 is 3.14. */
static void rows_that_scatter_by_more_than_their_noise_fail(void **unused) {
    (void)unused;
    for (int beyond = 0; beyond < 2; beyond++) {
        struct result *r = result_of(body);
        r->equations.free = 600, r->equations.cycles = 20.0;
        r->equations.rest = 600 * 1.118 + (beyond ? 3.3 : 3.0) * sqrt(600 * 3.0);
        if (beyond) expect(r, "the forces do not fit the model");
        else assert_int_equal(judge(r).status, VERDICT_PASS);
    }
    struct result *r = result_of(body);
    r->equations.free = 600, r->equations.cycles = HUGE_VAL, r->equations.rest = 600 + 3.3 * sqrt(1200.0);
    expect(r, "the forces do not fit the model");
    /* rounding errors that repeat in six tests of 100 rows each, with half of the variance */
    r->equations.repeating = 6 * 2.0 * 50 * 50;
    assert_int_equal(judge(r).status, VERDICT_PASS);
    r->equations.rest = 600 + 3.3 * sqrt(1200.0 + r->equations.repeating);
    expect(r, "the forces do not fit the model");
}

static void set_error(struct result *r, int error, double value, double std, double prior) {
    r->found.systematic[error] = (struct systematic_found){value, std, prior};
    r->estimate.noise[UNKNOWN_SYSTEMATIC + error][UNKNOWN_SYSTEMATIC + error] = square(std);
}

static void set_gains(struct result *r, double value) {
    for (int i = 0; i < 2 * LEGS; i++) set_error(r, SYSTEMATIC_P1_GAIN + i, i % 2 ? value : -value, 0.0022, 0.005);
}

/* The estimates have a prior of 0.005 and a deviation of 0.0022, so they scatter by 0.0045. Without
 * its prior the size is 1 / (1 - 0.0022^2 / 0.005^2) = 1.24 times as large. */
static void a_systematic_error_beyond_its_tolerance_fails_by_its_name(void **unused) {
    (void)unused;
    struct result *r = result_of(body);
    set_gains(r, 0.0);
    set_error(r, SYSTEMATIC_P1_GAIN + 2, 0.018, 0.0022, 0.005);
    assert_int_equal(judge(r).status, VERDICT_PASS);
    set_error(r, SYSTEMATIC_P1_GAIN + 2, -0.023, 0.0022, 0.005);
    expect(r, "gain of P1, leg 3: -2.85 % +- 0.48");
    /* the data have almost no information about this error */
    set_error(r, SYSTEMATIC_P1_GAIN + 2, -0.02, 0.0049, 0.005);
    assert_int_equal(judge(r).status, VERDICT_PASS);
}

/* Twelve errors of 1.6 and of 1.8 of their deviations have a chi-square of 31 and 39; the
 * probability of the second is 1e-4. A thirteenth of which the data know little does not count. */
static void errors_that_are_likely_each_but_not_all_fail_together(void **unused) {
    (void)unused;
    struct result *r = result_of(body);
    set_error(r, SYSTEMATIC_SKEW, 4e-4, 4.9e-4, 5e-4);
    set_gains(r, 1.6 * 0.00449);
    assert_int_equal(judge(r).status, VERDICT_PASS);
    set_gains(r, 1.8 * 0.00449);
    expect(r, "together further from zero than model.tolerance allows: chi-square 39 of 12");
    /* the data leave open what all have in common, and tell their differences */
    for (int i = 0; i < 2 * LEGS; i++)
        for (int j = 0; j < i; j++) {
            int a = UNKNOWN_SYSTEMATIC + SYSTEMATIC_P1_GAIN + i, b = UNKNOWN_SYSTEMATIC + SYSTEMATIC_P1_GAIN + j;
            r->estimate.noise[a][b] = r->estimate.noise[b][a] = 0.3 * square(0.0022);
        }
    set_gains(r, 1.8 * 0.00449);
    expect(r, "together further from zero than model.tolerance allows: chi-square 36 of 11");
    for (int i = 0; i < 2 * LEGS; i++) r->found.systematic[SYSTEMATIC_P1_GAIN + i].value = 1.8 * 0.00449;
    assert_int_equal(judge(r).status, VERDICT_PASS);
}

/* A compliance is judged by the prior that it was estimated with. One whose prior was narrowed to
 * nothing has its stated deviation and is no degree of freedom. */
static void a_compliance_with_a_narrowed_prior_is_not_judged(void **unused) {
    (void)unused;
    enum { UNKNOWN = UNKNOWN_SYSTEMATIC + SYSTEMATIC_COMPLIANCE };
    struct result *r = result_of(body);
    set_gains(r, 1.8 * 0.00449);
    r->found.systematic[SYSTEMATIC_COMPLIANCE] = (struct systematic_found){0.0, 8e-9, 2e-8};
    r->estimate.compliance_prior = 2e-11, r->estimate.noise[UNKNOWN][UNKNOWN] = square(1.99e-11);
    expect(r, "together further from zero than model.tolerance allows: chi-square 39 of 12");
    set_gains(r, 0.0);
    r->found.systematic[SYSTEMATIC_COMPLIANCE].value = 1e-7;
    r->estimate.compliance_prior = 2e-8, r->estimate.noise[UNKNOWN][UNKNOWN] = square(8e-9);
    expect(r, "compliance of the legs: +119 um/kN +- 17");
}

/* A bore stated too large makes all pressures seem too high, those of the smaller area more. The
 * mean of six gains of 0.0045 scatters by 0.0018, the difference of two such means by 0.0026. */
static void diameters_that_are_not_those_stated_fail(void **unused) {
    (void)unused;
    struct result *r = result_of(body);
    set_gains(r, 0.0);
    for (int i = 0; i < 2 * LEGS; i++) r->found.systematic[SYSTEMATIC_P1_GAIN + i].value = i < LEGS ? -0.003 : 0.003;
    assert_int_equal(judge(r).status, VERDICT_PASS);
    for (int i = 0; i < 2 * LEGS; i++) r->found.systematic[SYSTEMATIC_P1_GAIN + i].value = i < LEGS ? -0.005 : 0.005;
    expect(r, "P2 of all legs read +1.24 % +- 0.63 too much against P1");
}

/* Sets two gains of which the data tell the sum much better than each alone: inverse variances 1e6
 * and each. Without priors the data say first and second. */
static void set_pair(struct result *r, double each, double first, double second) {
    int one = SYSTEMATIC_P1_GAIN + 2, other = SYSTEMATIC_P2_GAIN + 2;
    double prior = 0.005, both = 1e6;
    /* The inverse covariance with the prior is [[a, b], [b, a]]. */
    double a = both + each + 1.0 / square(prior), b = both, determinant = a * a - b * b;
    double p = (both + each) * first + both * second, q = both * first + (both + each) * second;
    set_error(r, one, (a * p - b * q) / determinant, sqrt(a / determinant), prior);
    set_error(r, other, (a * q - b * p) / determinant, sqrt(a / determinant), prior);
    r->estimate.noise[UNKNOWN_SYSTEMATIC + one][UNKNOWN_SYSTEMATIC + other] = -b / determinant;
    r->estimate.noise[UNKNOWN_SYSTEMATIC + other][UNKNOWN_SYSTEMATIC + one] = -b / determinant;
}

/* The prior of the wrong gain makes the other one look wrong, too, by 5 of its deviations. */
static void an_error_is_not_laid_at_another_sensors_door(void **unused) {
    (void)unused;
    struct result *r = result_of(body);
    set_pair(r, 1e4, 0.05, 0.0);
    const struct systematic_found *other = &r->found.systematic[SYSTEMATIC_P2_GAIN + 2];
    assert_true(fabs(other->value) > 4.5 * sqrt(square(other->prior) - square(other->std)));
    expect(r, "gain of P1, leg 3: +5 %");
    assert_int_equal(judge(r).reasons, 1);
    set_pair(r, 1.5e5, 0.05, -0.04);
    expect(r, "gain of P1, leg 3: +5 %");
    assert_non_null(strstr(judge(r).reason[1], "gain of P2, leg 3: -4 %"));
}

/* The matrix is negative in one direction, which makes that direction the worst of all. */
static void a_matrix_that_is_not_definite_fails(void **unused) {
    (void)unused;
    struct result *r = result_of(body);
    r->estimate.value[0] = -2.0 * r->nominal[0][0];
    struct verdict v = judge(r);
    bool said = false;
    for (int i = 0; i < v.reasons; i++) said = said || strstr(v.reason[i], "not positive definite");
    assert_true(v.status == VERDICT_FAIL && said);
}

static void without_a_result_it_is_not_evaluated(void **unused) {
    (void)unused;
    struct verdict v = method_c_no_verdict("too short");
    assert_true(v.status == VERDICT_NOT_EVALUATED && v.reasons == 1 && !strcmp(v.reason[0], "too short"));
    assert_int_equal(method_c_no_verdict(NULL).reasons, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(true_results_fail_in_less_than_the_stated_share),
        cmocka_unit_test(a_negative_mass_fails),
        cmocka_unit_test(a_body_beyond_its_covariance_fails_and_one_within_passes),
        cmocka_unit_test(a_matrix_that_is_not_of_one_body_fails),
        cmocka_unit_test(friction_that_drives_fails_from_its_share_of_the_level_on),
        cmocka_unit_test(rows_that_scatter_by_more_than_their_noise_fail),
        cmocka_unit_test(a_systematic_error_beyond_its_tolerance_fails_by_its_name),
        cmocka_unit_test(errors_that_are_likely_each_but_not_all_fail_together),
        cmocka_unit_test(a_compliance_with_a_narrowed_prior_is_not_judged),
        cmocka_unit_test(diameters_that_are_not_those_stated_fail),
        cmocka_unit_test(an_error_is_not_laid_at_another_sensors_door),
        cmocka_unit_test(a_matrix_that_is_not_definite_fails),
        cmocka_unit_test(without_a_result_it_is_not_evaluated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
