/* Least squares with bounds. */
#include "support.h"

#include "dense.h"
#include "fit.h"

enum { N = 6, VALUES = 40 };

static void factor_and_solve_give_back_the_vector(void **state) {
    (void)state;
    uint64_t random = 3;
    double root[N][N], a[N][N] = {{0}}, x[N], b[N] = {0}, diagonal[N], work[N];
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) root[i][j] = random_unit(&random) + 2.0 * (i == j);
    for (int i = 0; i < N; i++) x[i] = random_unit(&random);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            for (int k = 0; k < N; k++) a[i][j] += root[i][k] * root[j][k];
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) b[i] += a[i][j] * x[j];
    double first[N] = {1.0};
    assert_true(dense_factor(N, N, a[0]));
    dense_solve(N, N, a[0], b);
    assert_below(distance(b, x, N), 1e-10);
    dense_inverse_diagonal(N, N, a[0], diagonal, work);
    dense_solve(N, N, a[0], first);
    assert_close(diagonal[0], first[0], 1e-10);
}

struct problem {
    double column[N][VALUES], residual[VALUES], min[N], max[N];
    const double *pointer[N];
};

static void draw(struct problem *p, uint64_t *random) {
    for (int i = 0; i < N; i++) {
        for (int a = 0; a < VALUES; a++) p->column[i][a] = random_unit(random);
        p->min[i] = -0.05 - 0.1 * fabs(random_unit(random)), p->max[i] = 0.05 + 0.1 * fabs(random_unit(random));
        p->pointer[i] = p->column[i];
    }
    for (int a = 0; a < VALUES; a++) p->residual[a] = random_unit(random);
}

/* Karush-Kuhn-Tucker conditions: the gradient is zero inside, and at a bound it does not point
 * inward. */
static void box_solution_is_optimal(void **state) {
    (void)state;
    uint64_t random = 11;
    for (int trial = 0; trial < 200; trial++) {
        struct problem p;
        double x[N], r[VALUES], std[N];
        draw(&p, &random);
        assert_true(fit_box(N, VALUES, p.residual, p.pointer, NULL, p.min, p.max, x, std));
        for (int a = 0; a < VALUES; a++) {
            r[a] = p.residual[a];
            for (int i = 0; i < N; i++) r[a] += x[i] * p.column[i][a];
        }
        for (int i = 0; i < N; i++) {
            double slope = 0.0;
            for (int a = 0; a < VALUES; a++) slope += r[a] * p.column[i][a];
            assert_true(x[i] >= p.min[i] && x[i] <= p.max[i]);
            if (x[i] > p.min[i]) assert_below(slope, 1e-7);
            if (x[i] < p.max[i]) assert_below(-slope, 1e-7);
            assert_true((x[i] == p.min[i] || x[i] == p.max[i]) == (std[i] == 0.0));
        }
    }
}

static void two_equal_columns_share_what_one_cannot_take(void **state) {
    (void)state;
    uint64_t random = 5;
    struct problem p;
    double x[N];
    draw(&p, &random);
    memcpy(p.column[1], p.column[0], sizeof p.column[0]);
    for (int a = 0; a < VALUES; a++) p.residual[a] = -1.2 * p.column[0][a];
    p.min[0] = p.min[1] = 0.0, p.max[0] = 1.0, p.max[1] = 0.5;
    assert_true(fit_box(2, VALUES, p.residual, p.pointer, NULL, p.min, p.max, x, NULL));
    assert_close(x[0] + x[1], 1.2, 1e-6); /* the two columns are parallel, and the ridge of 1e-10
                                           * keeps them solvable */
}

/* A prior takes unobservable directions to its centre and does not change observable ones. */
static void a_prior_decides_where_the_data_do_not(void **state) {
    (void)state;
    uint64_t random = 7;
    struct problem p;
    struct fit_prior prior[3] = {{1e-3, 0.0}, {1e-3, 0.4}, {1e-3, 0.0}};
    double x[N];
    draw(&p, &random);
    memcpy(p.column[1], p.column[0], sizeof p.column[0]);
    for (int a = 0; a < VALUES; a++) p.residual[a] = -1.2 * p.column[0][a] - 0.3 * p.column[2][a];
    for (int i = 0; i < 3; i++) p.min[i] = -10.0, p.max[i] = 10.0;
    assert_true(fit_box(3, VALUES, p.residual, p.pointer, prior, p.min, p.max, x, NULL));
    assert_close(x[0] + x[1], 1.2, 1e-5);
    assert_close(x[0], x[1] + 0.4, 1e-3); /* both values are equally far from their priors */
    assert_close(x[2], 0.3, 1e-5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(factor_and_solve_give_back_the_vector),
        cmocka_unit_test(box_solution_is_optimal),
        cmocka_unit_test(two_equal_columns_share_what_one_cannot_take),
        cmocka_unit_test(a_prior_decides_where_the_data_do_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
