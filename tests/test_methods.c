/* The methods on known test results: which is exact, which is biased by what, and how far noise
 * spreads them. */
#include "ident_rig.h"

#include <complex.h>

static void modified_a_replaces_the_couplings_by_their_mean_with_the_nominal_signs(void **unused) {
    (void)unused;
    struct rig *r = rig_create(12, 1);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_true(ident_solve(id));
    const struct identification *i = &id->result;
    double m_qz = (fabs(i->method_a.mt[0][4]) + fabs(i->method_a.mt[3][1])) / 2;
    assert_true(i->modified_a.evaluated);
    assert_true(i->modified_a.mt[0][4] == m_qz && i->modified_a.mt[4][0] == m_qz);
    assert_true(i->modified_a.mt[1][3] == -m_qz && i->modified_a.mt[3][1] == -m_qz);
    for (int k = 0; k < DOFS * DOFS; k++) {
        int row = k / DOFS, column = k % DOFS;
        if ((row == 0 && column == 4) || (row == 4 && column == 0) || (row == 1 && column == 3) || (row == 3 && column == 1)) continue;
        assert_true(i->modified_a.mt[row][column] == i->method_a.mt[row][column]);
    }
}

/* Computes test results from matrices and motions: F = -w^2 M x + B xdot on the fundamental. */
static void exact_results(const struct rig *r, struct test_result result[DOFS]) {
    for (int d = 0; d < DOFS; d++) {
        struct test_result *t = &result[d];
        double w = omega(r, d);
        *t = (struct test_result){.dof = (enum dof)d, .frequency_hz = r->params.tests.hz[d]};
        t->amplitude = amplitude(r, d);
        for (int i = 0; i < DOFS; i++) memcpy(t->pose[i], r->pose[d][i][0], sizeof t->pose[i]);
        t->achieved_amplitude = hypot(t->pose[d][0], t->pose[d][1]);
        for (int i = 0; i < DOFS; i++)
            for (int k = 0; k < DOFS; k++) {
                t->wrench[i][0] -= w * w * r->mt[i][k] * t->pose[k][0] + w * r->bt[i][k] * t->pose[k][1];
                t->wrench[i][1] -= w * w * r->mt[i][k] * t->pose[k][1] - w * r->bt[i][k] * t->pose[k][0];
            }
    }
}

static void pointers(const struct test_result result[DOFS], const struct test_result *test[DOFS]) {
    for (int d = 0; d < DOFS; d++) test[d] = &result[d];
}

static void viscous_legs_have_the_damping_of_the_method(void **unused) {
    (void)unused;
    /* values of docs/method.md, section 4, for b = 2000 N s/m */
    static const double neutral[DOFS] = {0}, diagonal[DOFS] = {1186, 1186, 9630, 1323, 1323, 552};
    struct rig *r = rig_create(19, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    double j[LEGS][DOFS];
    pointers(result, test);
    ik_jacobian(&r->kinematics, neutral, j);
    memset(r->bt, 0, sizeof r->bt);
    for (int k = 0; k < LEGS * DOFS * DOFS; k++) {
        int leg = k / (DOFS * DOFS), row = k / DOFS % DOFS, column = k % DOFS;
        r->bt[row][column] += 2000 * j[leg][row] * j[leg][column];
    }
    exact_results(r, result);
    struct method_result a = method_a(test);
    /* tolerance: those values were read off a simulation */
    for (int i = 0; i < DOFS; i++) assert_below(fabs(a.bt[i][i] / diagonal[i] - 1), 1e-3);
}

static double complex phasor(const double coefficient[2]) { return CMPLX(coefficient[0], coefficient[1]); }

/* Makes the tests' fundamentals columns, x = Im(X exp(i w t)), each rotated back by the phase of
 * its tested axis. */
static void turned(const struct test_result result[DOFS], double complex x[DOFS][DOFS], double complex f[DOFS][DOFS]) {
    for (int d = 0; d < DOFS; d++) {
        double complex back = cexp(CMPLX(0, -carg(phasor(result[d].pose[d]))));
        for (int i = 0; i < DOFS; i++) {
            x[i][d] = back * phasor(result[d].pose[i]);
            f[i][d] = back * phasor(result[d].wrench[i]);
        }
    }
}

static void method_b_maps_acceleration_in_phase_to_wrench_in_phase(void **unused) {
    (void)unused;
    struct rig *r = rig_create(13, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    double complex x[DOFS][DOFS], f[DOFS][DOFS];
    double w = omega(r, 0);
    pointers(result, test);
    exact_results(r, result);
    struct method_result b = method_b(test);
    assert_true(b.evaluated && b.condition_number < 1.5);
    turned(result, x, f);
    for (int i = 0; i < DOFS; i++)
        for (int d = 0; d < DOFS; d++) {
            double wrench = 0;
            for (int k = 0; k < DOFS; k++) wrench -= b.mt[i][k] * w * w * creal(x[k][d]);
            assert_close(wrench, creal(f[i][d]), 1e-10); /* tolerance: rounding of 700 N */
        }
}

/* F = (-w^2 M + i w B)(P + i Q) has the in-phase part -w^2 M P - w B Q. So method B is off by B Q
 * P^-1 / w, where Q is unwanted motion in quadrature. */
static void damping_biases_method_b_by_unwanted_motion_in_quadrature(void **unused) {
    (void)unused;
    struct rig *r = rig_create(13, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    double complex x[DOFS][DOFS], f[DOFS][DOFS];
    double w = omega(r, 0), largest = 0;
    pointers(result, test);
    exact_results(r, result);
    struct method_result b = method_b(test);
    turned(result, x, f);
    for (int i = 0; i < DOFS; i++)
        for (int d = 0; d < DOFS; d++) {
            double bias = 0, predicted = 0;
            for (int k = 0; k < DOFS; k++) {
                bias += (b.mt[i][k] - r->mt[i][k]) * creal(x[k][d]);
                predicted += r->bt[i][k] * cimag(x[k][d]) / w;
            }
            assert_close(bias, predicted, 1e-14); /* tolerance: rounding of 272 kg times 4 mm */
            largest = fmax(largest, fabs(predicted));
        }
    assert_true(largest > 1e-3); /* kg m, 0.1 % of 272 kg at 4 mm: the bias is large enough to be
                                  * predicted */
}

static void without_damping_or_quadrature_method_b_is_exact(void **unused) {
    (void)unused;
    struct rig *r = rig_create(13, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    pointers(result, test);
    double own[DOFS][DOFS];
    memcpy(own, r->bt, sizeof own);
    memset(r->bt, 0, sizeof r->bt);
    exact_results(r, result);
    /* rounding of 272 */
    assert_below(distance(&method_b(test).mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-11);
    memcpy(r->bt, own, sizeof own);
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < DOFS; i++) { /* every axis moves in phase or antiphase with the tested
                                          * one */
            double *coefficient = r->pose[d][i][0], *tested = r->pose[d][d][0], share = (i + d) % 2 ? 0.05 : -0.05;
            if (i != d) coefficient[0] = share * tested[0], coefficient[1] = share * tested[1];
        }
    exact_results(r, result);
    assert_below(distance(&method_b(test).mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-11);
}

static void condition_is_one_for_perfect_tests_and_singular_ones_give_no_number(void **unused) {
    (void)unused;
    struct rig *r = rig_create(14, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    pointers(result, test);
    memset(r->pose, 0, sizeof r->pose);
    for (int d = 0; d < DOFS; d++) r->pose[d][d][0][0] = amplitude(r, d);
    exact_results(r, result);
    assert_close(method_a(test).condition_number, 1, 1e-14);
    assert_close(method_b(test).condition_number, 1, 1e-14);
    test[DOF_Y] = &result[DOF_X]; /* the x test takes the place of the y test, so no test moves y */
    struct method_result singular[] = {method_a(test), method_b(test)};
    for (int m = 0; m < 2; m++) {
        assert_false(singular[m].evaluated);
        for (int i = 0; i < DOFS; i++)
            for (int k = 0; k < DOFS; k++) assert_true(isnan(singular[m].mt[i][k]) && isnan(singular[m].mt_std[i][k]));
    }
}

static void tests_of_different_frequencies_can_be_combined(void **unused) {
    (void)unused;
    struct rig *r = rig_create(15, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    pointers(result, test);
    for (int d = 0; d < DOFS; d += 2) r->params.tests.hz[d] = 7;
    exact_results(r, result);
    struct method_result a = method_a(test);
    assert_true(a.evaluated);
    assert_below(distance(&a.mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-11);
}

/* Sums for the ratio of observed to predicted variance of each entry. */
struct spread {
    double observed[DOFS * DOFS], predicted[DOFS * DOFS];
    int runs;
};

static void spread_add(struct spread *s, const double *value, const double *truth, const double *std) {
    for (int i = 0; i < DOFS * DOFS; i++) {
        s->observed[i] += pow(value[i] - truth[i], 2);
        s->predicted[i] += pow(std[i], 2);
    }
    s->runs++;
}

/* An observed variance has a relative spread of sqrt(2 / runs). The worst of 36 entries may be off
 * by five of these spreads. The mean over all entries contains at least six independent ones, as
 * many as there are rows, and may be off by four of its spreads. */
static void assert_spread(const struct spread *s, const char *name) {
    double one = sqrt(2.0 / s->runs), mean = 0;
    for (int i = 0; i < DOFS * DOFS; i++) {
        double ratio = s->observed[i] / s->predicted[i];
        mean += ratio / (DOFS * DOFS);
        if (!(fabs(ratio - 1) < 5 * one)) fail_msg("%s[%d][%d]: variance %g of the predicted one", name, i / DOFS, i % DOFS, ratio);
    }
    if (!(fabs(mean - 1) < 4 * one / sqrt(6))) fail_msg("%s: mean variance %g of the predicted one", name, mean);
}

static void disturb(struct test_result *t, uint64_t *state) {
    for (int i = 0; i < DOFS; i++)
        for (int k = 0; k < 2; k++) {
            t->pose[i][k] += t->pose_std[i] * random_normal(state);
            t->wrench[i][k] += t->wrench_std[i] * random_normal(state);
        }
}

static void predicted_std_is_the_spread_over_noisy_coefficients(void **unused) {
    (void)unused;
    struct rig *r = rig_create(16, 1);
    struct spread mt = {0}, bt = {0}, b = {0};
    struct test_result exact[DOFS], noisy[DOFS];
    const struct test_result *test[DOFS];
    uint64_t state = 3;
    exact_results(r, exact);
    pointers(exact, test);
    struct method_result biased = method_b(test); /* what method B finds without noise, including
                                                   * its bias */
    pointers(noisy, test);
    for (int run = 0; run < 4000; run++) {
        for (int d = 0; d < DOFS; d++) {
            noisy[d] = exact[d];
            for (int i = 0; i < DOFS; i++) {
                /* noise of equal effect: 0.1 % of the amplitude, and of the corresponding wrench */
                noisy[d].pose_std[i] = 1e-3 * amplitude(r, i);
                noisy[d].wrench_std[i] = 1e-3 * pow(omega(r, 0), 2) * r->mt[i][i] * amplitude(r, i);
            }
            disturb(&noisy[d], &state);
        }
        struct method_result found = method_a(test), found_b = method_b(test);
        spread_add(&mt, &found.mt[0][0], &r->mt[0][0], &found.mt_std[0][0]);
        spread_add(&bt, &found.bt[0][0], &r->bt[0][0], &found.bt_std[0][0]);
        spread_add(&b, &found_b.mt[0][0], &biased.mt[0][0], &found_b.mt_std[0][0]);
    }
    assert_spread(&mt, "Mt");
    assert_spread(&bt, "Bt");
    assert_spread(&b, "Mt of method B");
}

/* Runs the whole chain with white noise of the paper's sensors: 50 um / sqrt(12) on lengths, 20 kPa
 * / sqrt(3) on pressures. */
static void predicted_std_is_the_spread_over_noisy_sensors(void **unused) {
    (void)unused;
    slow_case();
    struct rig *r = rig_create(17, 0.5);
    struct ident *id = ident_create(r);
    struct spread mt = {0}, bt = {0};
    uint64_t state = 4;
    for (int run = 0; run < 400; run++) {
        for (int d = 0; d < DOFS; d++)
            for (int i = 0; i < r->samples; i++) {
                struct cycle c = r->cycle[d][i];
                for (int leg = 0; leg < LEGS; leg++) {
                    c.in.length_m[leg] += 14.4e-6 * random_normal(&state);
                    c.in.p1_pa[leg] += 11.5e3 * random_normal(&state);
                    c.in.p2_pa[leg] += 11.5e3 * random_normal(&state);
                }
                ident_feed(id, &c);
            }
        ident_end(id);
        assert_true(ident_solve(id));
        const struct method_result *a = &id->result.method_a;
        spread_add(&mt, &a->mt[0][0], &r->mt[0][0], &a->mt_std[0][0]);
        spread_add(&bt, &a->bt[0][0], &r->bt[0][0], &a->bt_std[0][0]);
    }
    assert_spread(&mt, "Mt");
    assert_spread(&bt, "Bt");
}

static void errors_in_percent_keep_their_sign_by_magnitude(void **unused) {
    (void)unused;
    struct identification id = {.nominal_mt = {[0][0] = 200, [1][3] = -10}};
    struct method_result m = {.mt = {[0][0] = 202, [1][3] = -5}};
    assert_close(ident_error_pct(&id, &m, &ident_entries[0]), 1, 1e-12);
    assert_string_equal(ident_entries[7].name, "Mt24");
    assert_close(ident_error_pct(&id, &m, &ident_entries[7]), -50, 1e-12);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(modified_a_replaces_the_couplings_by_their_mean_with_the_nominal_signs),
        cmocka_unit_test(viscous_legs_have_the_damping_of_the_method),
        cmocka_unit_test(method_b_maps_acceleration_in_phase_to_wrench_in_phase),
        cmocka_unit_test(damping_biases_method_b_by_unwanted_motion_in_quadrature),
        cmocka_unit_test(without_damping_or_quadrature_method_b_is_exact),
        cmocka_unit_test(condition_is_one_for_perfect_tests_and_singular_ones_give_no_number),
        cmocka_unit_test(tests_of_different_frequencies_can_be_combined),
        cmocka_unit_test(predicted_std_is_the_spread_over_noisy_coefficients),
        cmocka_unit_test(predicted_std_is_the_spread_over_noisy_sensors),
        cmocka_unit_test(errors_in_percent_keep_their_sign_by_magnitude),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
