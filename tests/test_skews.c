/* Skews of single tests: eliminating them is the same as generalised least squares with their
 * covariance, and their size is found from the data. */
#include "support.h"

#include "dense.h"
#include "skews.h"

enum { TESTS = 40, LOGS = 3, ROWS = 5, SKEW = UNKNOWN_SYSTEMATIC + SYSTEMATIC_SKEW };
/* Unknowns that occur in the rows. */
static const int column[] = {0, UNKNOWN_VISCOUS, SKEW, UNKNOWN_BASIS + 3};
enum { COLUMNS = sizeof column / sizeof *column };

/* Rows of all tests, of weight 1. */
struct rows {
    double x[TESTS][ROWS][COLUMNS], y[TESTS][ROWS];
};

/* Draws rows of noise `noise`, in which each test has a skew of its own. */
static void draw(struct rows *r, double noise, double size, uint64_t *seed) {
    for (int t = 0; t < TESTS; t++) {
        double departure = size * sqrt(3.0) * random_unit(seed);
        for (int i = 0; i < ROWS; i++) {
            r->y[t][i] = noise * sqrt(3.0) * random_unit(seed);
            for (int c = 0; c < COLUMNS; c++) {
                r->x[t][i][c] = random_unit(seed);
                if (column[c] == SKEW) r->y[t][i] += departure * r->x[t][i][c];
            }
        }
    }
}

static struct equations *equations_of(const struct rows *r, double weight) {
    static struct equations e;
    e = (struct equations){.skew_test_s = 1.0};
    for (int t = 0; t < TESTS; t++) {
        struct test_skew before = skews_now(&e);
        for (int i = 0; i < ROWS; i++)
            for (int a = 0; a < COLUMNS; a++) {
                e.with[column[a]] += weight * r->x[t][i][a] * r->y[t][i];
                for (int b = 0; b <= a; b++) e.product[column[a]][column[b]] += weight * r->x[t][i][a] * r->x[t][i][b];
            }
        skews_add(&e, &before);
    }
    return &e;
}

/* Multiplies by the inverse of a test's covariance, 1 + size^2 D D'. */
static void whiten(const double x[ROWS][COLUMNS], double size, double value[ROWS]) {
    double covariance[ROWS][ROWS];
    for (int i = 0; i < ROWS; i++)
        for (int j = 0; j < ROWS; j++) covariance[i][j] = (i == j) + size * size * x[i][2] * x[j][2];
    assert_true(dense_factor(ROWS, ROWS, covariance[0]));
    dense_solve(ROWS, ROWS, covariance[0], value);
}

/* Compares equations without departures with generalised least squares of all tests' rows. */
static void expect_covariance_of_the_rows(const struct equations *e, int logs, const struct rows *r, double size) {
    for (int a = 0; a < COLUMNS; a++) {
        double product[COLUMNS] = {0}, with = 0.0;
        for (int t = 0; t < logs * TESTS; t++) {
            const struct rows *log = &r[t / TESTS];
            double solved[ROWS];
            for (int i = 0; i < ROWS; i++) solved[i] = log->x[t % TESTS][i][a];
            whiten(log->x[t % TESTS], size, solved);
            for (int i = 0; i < ROWS; i++) {
                with += solved[i] * log->y[t % TESTS][i];
                for (int b = 0; b <= a; b++) product[b] += solved[i] * log->x[t % TESTS][i][b];
            }
        }
        assert_close(e->with[column[a]], with, 1e-10);
        for (int b = 0; b <= a; b++) assert_close(e->product[column[a]][column[b]], product[b], 1e-10);
    }
}

static void eliminated_skews_are_a_covariance_of_the_rows(void **unused) {
    (void)unused;
    static struct rows r;
    const double size = 0.7;
    uint64_t seed = 3;
    draw(&r, 1.0, size, &seed);
    struct equations *e = equations_of(&r, 1.0);
    skews_eliminate(e, size);
    expect_covariance_of_the_rows(e, 1, &r, size);
}

/* Solves for the size as equations.c does; unknowns that do not occur have a prior. */
static double size_of(struct equations *e) {
    static double factor[UNKNOWNS][UNKNOWNS];
    memcpy(factor, e->product, sizeof factor);
    for (int c = 0; c < UNKNOWNS; c++) factor[c][c] += 1.0;
    assert_true(dense_factor(UNKNOWNS, UNKNOWNS, factor[0]));
    return skews_size(e, factor);
}

/* With 40 tests a size is known to about an eighth; the noise hides one far below it. */
static void the_size_is_found_and_is_at_most_the_stated_one(void **unused) {
    (void)unused;
    static struct rows r;
    uint64_t seed = 4;
    const double noise = 0.01, weight = 1.0 / (noise * noise);
    draw(&r, noise, 0.3, &seed);
    struct equations *e = equations_of(&r, weight);
    assert_close(size_of(e), 0.3, 3.0 * 0.3 / 8.0);
    e->skew_test_s = 0.1;
    assert_close(size_of(e), 0.1, 1e-12);
    e->skew_test_s = 0.0;
    assert_true(size_of(e) == 0.0);
    draw(&r, noise, 0.0, &seed);
    assert_below(size_of(equations_of(&r, weight)), noise);
}

static void a_departure_is_that_of_its_test(void **unused) {
    (void)unused;
    static struct rows r;
    uint64_t seed = 5;
    double departure[SKEW_TESTS], value[UNKNOWNS] = {0};
    draw(&r, 0.0, 0.0, &seed);
    for (int i = 0; i < ROWS; i++) r.y[7][i] += 0.2 * r.x[7][i][2];
    skews_departures(equations_of(&r, 1e8), 1.0, value, departure);
    for (int t = 0; t < TESTS; t++) assert_close(departure[t], t == 7 ? 0.2 : 0.0, 1e-7);
}

/* Three logs have more tests than there is room for. Each test still has a departure of its own:
 * with the largest size, of 1 as equations_of() states it, none differs from the others. */
static void tests_without_room_have_departures_of_the_largest_size(void **unused) {
    (void)unused;
    static struct rows r[LOGS];
    static struct equations sum;
    uint64_t seed = 6;
    sum = (struct equations){0};
    for (int log = 0; log < LOGS; log++) {
        draw(&r[log], 0.1, 1.0, &seed);
        equations_add(&sum, equations_of(&r[log], 1.0));
    }
    assert_true(sum.skews == SKEW_TESTS && SKEW_TESTS < LOGS * TESTS);
    skews_eliminate(&sum, sum.skew_test_s);
    expect_covariance_of_the_rows(&sum, LOGS, r, 1.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eliminated_skews_are_a_covariance_of_the_rows), cmocka_unit_test(the_size_is_found_and_is_at_most_the_stated_one),
        cmocka_unit_test(a_departure_is_that_of_its_test), cmocka_unit_test(tests_without_room_have_departures_of_the_largest_size)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
