/* An estimate learns from measurements of systematic errors as least squares with one more row
 * would: the information, the inverse of the covariance, grows by h h' / std^2. */
#include "support.h"

#include "calibration.h"
#include "config.h"
#include "dense.h"

enum { SIZE = UNKNOWN_BASIS };

/* Makes an estimate of a random covariance: noise F F', and some shared errors. */
static struct estimate *drawn(uint64_t seed) {
    static struct estimate estimate;
    static double f[SIZE][SIZE];
    struct estimate *e = &estimate;
    memset(e, 0, sizeof *e);
    for (int c = 0; c < SIZE; c++) {
        e->value[c] = random_unit(&seed);
        for (int d = 0; d < SIZE; d++) f[c][d] = (c == d ? 1.0 : 0.1) * random_unit(&seed) + (c == d);
        for (int j = 0; j < COMMON_CALIBRATION; j++) e->common[j][c] = 0.1 * random_unit(&seed);
    }
    for (int c = 0; c < SIZE; c++)
        for (int d = 0; d < SIZE; d++)
            for (int i = 0; i < SIZE; i++) e->noise[c][d] += f[c][i] * f[d][i];
    return e;
}

static void covariance(const struct estimate *e, double c[SIZE][SIZE]) {
    for (int a = 0; a < SIZE; a++)
        for (int b = 0; b < SIZE; b++) c[a][b] = estimate_covariance(e, a, b);
}

/* Inverts in place. */
static void invert(double m[SIZE][SIZE]) {
    static double factor[SIZE][SIZE];
    memcpy(factor, m, sizeof factor);
    assert_true(dense_factor(SIZE, SIZE, factor[0]));
    for (int c = 0; c < SIZE; c++) {
        memset(m[c], 0, sizeof m[c]);
        m[c][c] = 1.0;
        dense_solve(SIZE, SIZE, factor[0], m[c]);
    }
}

static void it_learns_as_least_squares_with_one_more_row(void **unused) {
    (void)unused;
    static double before[SIZE][SIZE], after[SIZE][SIZE];
    double value[SIZE], right[SIZE], h[SIZE] = {0};
    struct calibration row = {.value = 0.7, .std = 0.3};
    struct estimate *e = drawn(1);
    uint64_t seed = 2;
    for (int s = 0; s < SYSTEMATICS; s++) row.of[s] = h[UNKNOWN_SYSTEMATIC + s] = random_unit(&seed);
    memcpy(value, e->value, sizeof value);
    covariance(e, before);
    calibration_learn(&row, CALIBRATION_WEIGHT, e);
    covariance(e, after);
    invert(before); /* now the information */
    for (int a = 0; a < SIZE; a++) {
        right[a] = h[a] * row.value / (row.std * row.std);
        for (int b = 0; b < SIZE; b++) right[a] += before[a][b] * value[b];
    }
    for (int a = 0; a < SIZE; a++)
        for (int b = 0; b < SIZE; b++) before[a][b] += h[a] * h[b] / (row.std * row.std);
    invert(before);
    for (int a = 0; a < SIZE; a++) {
        double expected = 0.0;
        for (int b = 0; b < SIZE; b++) {
            expected += before[a][b] * right[b];
            assert_close(after[a][b], before[a][b], 1e-6);
        }
        assert_close(e->value[a], expected, 1e-6);
    }
}

/* The surprise of a reading is its distance from the expected value, in standard deviations of both
 * together. */
static void a_reading_surprises_by_its_distance(void **unused) {
    (void)unused;
    struct calibration row = {.std = 0.3};
    struct estimate *e = drawn(3);
    double variance = estimate_covariance(e, UNKNOWN_SYSTEMATIC, UNKNOWN_SYSTEMATIC);
    row.of[0] = 1.0, row.value = e->value[UNKNOWN_SYSTEMATIC] + 4.0 * sqrt(variance + 0.09);
    calibration_learn(&row, CALIBRATION_STOP, e);
    assert_close(e->surprise[CALIBRATION_STOP], 4.0, 1e-9);
    assert_close(estimate_covariance(e, UNKNOWN_SYSTEMATIC, UNKNOWN_SYSTEMATIC), variance * 0.09 / (variance + 0.09), 1e-9);
}

static void errors_that_do_not_exist_learn_nothing(void **unused) {
    (void)unused;
    static struct estimate e;
    struct calibration row = {.value = 0.5, .std = 0.1};
    memset(&e, 0, sizeof e);
    row.of[SYSTEMATIC_P1_GAIN] = 1.0;
    calibration_learn(&row, CALIBRATION_WEIGHT, &e);
    assert_true(e.value[UNKNOWN_SYSTEMATIC] == 0.0 && e.surprise[CALIBRATION_WEIGHT] == 0.0);
}

/* If the gains of the lengths are exact, a reading on a stop determines the zero alone. */
static void a_stop_teaches_the_zero_alone_where_gains_are_exact(void **unused) {
    (void)unused;
    static struct equations equations;
    static struct estimate e;
    double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES] = {{0}};
    const int zero = UNKNOWN_SYSTEMATIC + SYSTEMATIC_LENGTH_ZERO, gain = UNKNOWN_SYSTEMATIC + SYSTEMATIC_LENGTH_GAIN;
    struct calibration row = {.value = 2e-3, .std = 1e-4};
    for (int i = 0; i < MATRIX_ENTRIES; i++) matrix[i][i] = 1.0;
    for (int i = 0; i < UNKNOWN_SYSTEMATIC; i++) equations.product[i][i] = 1.0;
    equations.systematic[SYSTEMATIC_LENGTH_ZERO] = 1e-3;
    row.of[SYSTEMATIC_LENGTH_ZERO] = 1.0, row.of[SYSTEMATIC_LENGTH_GAIN] = -0.5;
    assert_true(equations_solve(&equations, matrix, &e));
    calibration_learn(&row, CALIBRATION_STOP, &e);
    assert_close(e.value[zero], 2e-3 / 1.01, 1e-9);
    assert_true(e.value[gain] == 0.0);
    assert_close(e.surprise[CALIBRATION_STOP], 2e-3 / sqrt(1e-6 + 1e-8), 1e-6);
}

/* The reading of a leg on its stop contains its zero error, and its gain error times the distance
 * of the stop from neutral. */
static void the_configuration_holds_the_measurements(void **unused) {
    (void)unused;
    struct calibration row[CALIBRATIONS];
    struct params params;
    struct kinematics k;
    config_default(&params);
    kinematics_place(&k, &params);
    params.found.weight_p1[2] = 0.4, params.found.weight_p2[5] = -0.1, params.found.weight_error = 0.02, params.found.weight_std = 1e-3;
    params.found.retracted_m[4] = 3e-4, params.found.retracted_std_m = 1e-4;
    calibration_find(&params, &k, row);
    assert_true(row[CALIBRATION_WEIGHT].of[SYSTEMATIC_P1_GAIN + 2] == 0.4 && row[CALIBRATION_WEIGHT].of[SYSTEMATIC_P2_GAIN + 5] == -0.1);
    assert_true(row[CALIBRATION_WEIGHT].value == 0.02 && row[CALIBRATION_WEIGHT].std == 1e-3);
    assert_true(row[CALIBRATION_STOP + 4].of[SYSTEMATIC_LENGTH_ZERO + 4] == 1.0 && row[CALIBRATION_STOP + 4].value == 3e-4);
    assert_close(row[CALIBRATION_STOP + 4].of[SYSTEMATIC_LENGTH_GAIN + 4], -0.5 * params.actuator.stroke_m[4], 1e-9);
}

/* Twelve independent gains have a mean of a twelfth of their variance; a known weight replaces that
 * prior. */
static void the_common_gain_rests_on_the_mean_of_the_priors(void **unused) {
    (void)unused;
    struct params params;
    double prior[SYSTEMATICS];
    config_default(&params);
    for (int pressures = 0; pressures < 2; pressures++) {
        systematic_priors(&params, pressures, prior);
        struct common_gain gain = calibration_common_gain(&params, prior);
        assert_int_equal(gain.sensors, pressures ? 2 * LEGS : LEGS);
        assert_true(gain.pressures == pressures && gain.tolerance == 0.005);
        assert_close(gain.std, 0.005 / sqrt(gain.sensors), 1e-15);
    }
    params.found.weight_std = 0.001;
    assert_int_equal(calibration_common_gain(&params, prior).sensors, 0);
    params.found.weight_std = 0.0, params.model.tolerance.pressure_gain = 0.0;
    systematic_priors(&params, true, prior);
    assert_int_equal(calibration_common_gain(&params, prior).sensors, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(it_learns_as_least_squares_with_one_more_row),
                                       cmocka_unit_test(a_reading_surprises_by_its_distance),
                                       cmocka_unit_test(errors_that_do_not_exist_learn_nothing),
                                       cmocka_unit_test(a_stop_teaches_the_zero_alone_where_gains_are_exact),
                                       cmocka_unit_test(the_configuration_holds_the_measurements),
                                       cmocka_unit_test(the_common_gain_rests_on_the_mean_of_the_priors)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
