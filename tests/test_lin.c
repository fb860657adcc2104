/* Linear algebra shim: identities between its functions, and honest reports on bad input. */
#include <complex.h>
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "lin.h"
#include "random.h"

enum { N = 12 };

static void fill(double *a, int count, uint64_t seed) {
    for (int i = 0; i < count; i++) a[i] = random_unit(&seed);
}

static void multiply(int rows, int inner, int columns, const double *a, const double *b, double *c) {
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) {
            c[i * columns + j] = 0.0;
            for (int k = 0; k < inner; k++) c[i * columns + j] += a[i * inner + k] * b[k * columns + j];
        }
}

/* Makes A' A + I / 10, which is symmetric with eigenvalues of at least 0.1. */
static void fill_spd(double *s, int n, uint64_t seed) {
    double a[LIN_MAX * LIN_MAX], transposed[LIN_MAX * LIN_MAX];
    fill(a, n * n, seed);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) transposed[i * n + j] = a[j * n + i];
    multiply(n, n, n, transposed, a, s);
    for (int i = 0; i < n; i++) s[i * n + i] += 0.1;
}

static double distance(const double *a, const double *b, int count) {
    double largest = 0.0;
    for (int i = 0; i < count; i++) {
        if (isnan(a[i]) || isnan(b[i])) return NAN;
        largest = fmax(largest, fabs(a[i] - b[i]));
    }
    return largest;
}

static void assert_below(double value, double limit) {
    if (!(value < limit)) fail_msg("%g is not below %g", value, limit);
}

static void solve_right_recovers_x_in_every_size(void **unused) {
    (void)unused;
    for (int n = 1; n <= LIN_MAX; n++)
        for (int m = 1; m <= LIN_MAX; m += 5) {
            double a[LIN_MAX * LIN_MAX], x[LIN_MAX * LIN_MAX], b[LIN_MAX * LIN_MAX], found[LIN_MAX * LIN_MAX];
            fill(a, n * n, (uint64_t)(100 * n + m));
            fill(x, m * n, (uint64_t)(n + 100 * m));
            multiply(m, n, n, x, a, b);
            struct lin_report report = lin_solve_right(n, m, a, b, found);
            assert_int_equal(report.rank, n);
            /* The method is backward stable: the error is below the condition number times a few
             * roundings per size. */
            assert_below(distance(x, found, m * n), report.condition * 16 * n * DBL_EPSILON);
        }
}

static void inverse_times_matrix_is_the_identity(void **unused) {
    (void)unused;
    double a[N * N], inverse[N * N], product[N * N], identity[N * N] = {0};
    fill(a, N * N, 7);
    for (int i = 0; i < N; i++) identity[i * N + i] = 1.0;
    struct lin_report report = lin_inverse(N, a, inverse);
    multiply(N, N, N, inverse, a, product);
    assert_below(distance(product, identity, N * N), report.condition * 16 * N * DBL_EPSILON);
}

static void spd_and_general_solutions_agree(void **unused) {
    (void)unused;
    enum { M = 14 };
    double s[LIN_MAX * LIN_MAX], b[LIN_MAX * M], x[LIN_MAX * M], bt[M * LIN_MAX], xt[M * LIN_MAX];
    fill_spd(s, LIN_MAX, 3);
    fill(b, LIN_MAX * M, 4);
    for (int i = 0; i < LIN_MAX; i++)
        for (int j = 0; j < M; j++) bt[j * LIN_MAX + i] = b[i * M + j];
    struct lin_report spd = lin_solve_spd(LIN_MAX, M, s, b, x);
    struct lin_report general = lin_solve_right(LIN_MAX, M, s, bt, xt);
    assert_int_equal(spd.rank, LIN_MAX);
    /* One condition number comes from eigenvalues, the other from singular values. */
    assert_below(fabs(spd.condition / general.condition - 1.0), spd.condition * LIN_MAX * DBL_EPSILON);
    for (int i = 0; i < LIN_MAX; i++)
        for (int j = 0; j < M; j++) assert_below(fabs(x[i * M + j] - xt[j * LIN_MAX + i]), spd.condition * 160 * DBL_EPSILON);
}

static void squared_singular_values_are_eigenvalues_of_the_gram_matrix(void **unused) {
    (void)unused;
    enum { ROWS = 15, COLUMNS = 9 };
    double a[ROWS * COLUMNS], transposed[COLUMNS * ROWS], gram[COLUMNS * COLUMNS], values[COLUMNS], squares[COLUMNS];
    fill(a, ROWS * COLUMNS, 11);
    for (int i = 0; i < ROWS; i++)
        for (int j = 0; j < COLUMNS; j++) transposed[j * ROWS + i] = a[i * COLUMNS + j];
    multiply(COLUMNS, ROWS, COLUMNS, transposed, a, gram);
    assert_int_equal(lin_singular_values(ROWS, COLUMNS, a, values), 0);
    assert_int_equal(lin_eigenvalues(COLUMNS, gram, squares), 0);
    /* both are accurate to rounding of the largest value */
    for (int i = 0; i < COLUMNS; i++) assert_below(fabs(values[i] * values[i] - squares[COLUMNS - 1 - i]), squares[COLUMNS - 1] * 1e-14);
    assert_int_equal(lin_singular_values(COLUMNS, ROWS, transposed, squares), 0);
    assert_below(distance(values, squares, COLUMNS), values[0] * 1e-14);
}

/* The matrix is V D V^-1 with V = 1 + i a b'/2, whose inverse is 1 - i a b'/(2 + i a'b). */
static void a_complex_matrix_has_the_eigenvalues_that_it_was_made_of(void **unused) {
    (void)unused;
    enum { SIZE = 3 };
    static const double a[SIZE] = {1.0, -2.0, 0.5}, b[SIZE] = {0.3, 1.0, 2.0};
    const double complex wanted[SIZE] = {CMPLX(1.0, 2.0), CMPLX(-3.0, 0.5), CMPLX(0.0, -1.0)};
    double complex square[SIZE][SIZE] = {{0}}, found[SIZE], inner = 0.0;
    for (int i = 0; i < SIZE; i++) inner += a[i] * b[i];
    for (int i = 0; i < SIZE; i++)
        for (int j = 0; j < SIZE; j++)
            for (int k = 0; k < SIZE; k++) {
                double complex there = (i == k) + CMPLX(0.0, 0.5 * a[i] * b[k]);
                double complex back = (k == j) - CMPLX(0.0, a[k] * b[j]) / (2.0 + CMPLX(0.0, 1.0) * inner);
                square[i][j] += there * wanted[k] * back;
            }
    assert_int_equal(lin_complex_eigenvalues(SIZE, (const double *)square, (double *)found), 0);
    for (int i = 0; i < SIZE; i++) {
        double nearest = HUGE_VAL;
        for (int j = 0; j < SIZE; j++) nearest = fmin(nearest, cabs(found[j] - wanted[i]));
        assert_below(nearest, 1e-13);
    }
    square[1][1] = NAN;
    assert_int_equal(lin_complex_eigenvalues(SIZE, (const double *)square, (double *)found), -1);
}

static void condition_of_a_diagonal_matrix_is_its_spread(void **unused) {
    (void)unused;
    double a[9] = {1e4, 0, 0, 0, -1, 0, 0, 0, 1e-4}, b[3] = {1e4, -1, 1e-4}, x[3];
    struct lin_report report = lin_solve_right(3, 1, a, b, x);
    assert_int_equal(report.rank, 3);
    assert_below(fabs(report.condition - 1e8), 1e8 * 1e-14);
    assert_below(distance(x, (double[]){1, 1, 1}, 3), 1e-14);
}

static void a_singular_matrix_is_reported_and_solved_with_least_norm(void **unused) {
    (void)unused;
    /* the equations x1 + x2 = 2 and x1 + x2 = 4 contradict: the best sum is 3, and the least norm
     * has 1.5 for each */
    double a[4] = {1, 1, 1, 1}, b[2] = {2, 4}, x[2];
    struct lin_report report = lin_solve_right(2, 1, a, b, x);
    assert_int_equal(report.rank, 1);
    assert_true(isinf(report.condition));
    assert_below(distance(x, (double[]){1.5, 1.5}, 2), 1e-14);
}

static void an_indefinite_matrix_is_not_solved_as_definite(void **unused) {
    (void)unused;
    double a[4] = {1, 2, 2, 1}, b[2] = {1, 1}, x[2]; /* this matrix has the eigenvalues 3 and -1 */
    struct lin_report report = lin_solve_spd(2, 1, a, b, x);
    assert_int_equal(report.rank, 1);
    assert_true(isinf(report.condition));
    assert_true(isnan(x[0]) && isnan(x[1]));
}

static void values_that_are_not_finite_are_refused(void **unused) {
    (void)unused;
    const double bad[] = {NAN, INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++) {
        double a[4] = {1, 0, bad[k], 1}, good[4] = {1, 0, 0, 1}, b[2] = {1, 1}, c[2] = {bad[k], 1}, x[4];
        assert_int_equal(lin_solve_right(2, 1, a, b, x).rank, 0);
        assert_true(isnan(x[0]) && isnan(x[1]));
        assert_int_equal(lin_solve_right(2, 1, good, c, x).rank, 0);
        assert_int_equal(lin_solve_spd(2, 1, a, b, x).rank, 0);
        assert_int_equal(lin_solve_spd(2, 1, good, c, x).rank, 0);
        assert_int_equal(lin_inverse(2, a, x).rank, 0);
        assert_int_equal(lin_eigenvalues(2, a, x), -1);
        assert_int_equal(lin_singular_values(2, 2, a, x), -1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solve_right_recovers_x_in_every_size),
        cmocka_unit_test(inverse_times_matrix_is_the_identity),
        cmocka_unit_test(spd_and_general_solutions_agree),
        cmocka_unit_test(squared_singular_values_are_eigenvalues_of_the_gram_matrix),
        cmocka_unit_test(a_complex_matrix_has_the_eigenvalues_that_it_was_made_of),
        cmocka_unit_test(condition_of_a_diagonal_matrix_is_its_spread),
        cmocka_unit_test(a_singular_matrix_is_reported_and_solved_with_least_norm),
        cmocka_unit_test(an_indefinite_matrix_is_not_solved_as_definite),
        cmocka_unit_test(values_that_are_not_finite_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
