/* Evidence of linear models, whose integrals are known. */
#include "support.h"

#include "dense.h"
#include "evidence.h"
#include "numeric.h"

enum { ROWS = 9, VARIABLES = 2, FEATURES = 1, FIRST_HELD = 2, HELD = 5, COEFFICIENTS = 3 };

struct world {
    double white[ROWS], column[VARIABLES][ROWS], spread[ROWS], law[ROWS], least[ROWS], feature[FEATURES][ROWS];
    bool evaluated[ROWS];
    struct linearised model;
    struct covariance covariance;
    /* friction of a leg that may be held, in the rows from FIRST_HELD on */
    struct held_rows place;
    int coefficient[ROWS];
    double per_n[ROWS];
};

static void build(struct world *w, uint64_t seed) {
    uint64_t random = seed;
    memset(w, 0, sizeof *w);
    for (int a = 0; a < ROWS; a++) {
        w->white[a] = 3.0 * random_unit(&random);
        for (int i = 0; i < VARIABLES; i++) w->column[i][a] = random_unit(&random);
        w->spread[a] = 2.0, w->law[a] = 5.0 + a, w->least[a] = 0.1, w->feature[0][a] = 1.0 + random_unit(&random);
        w->evaluated[a] = true;
    }
    w->model = (struct linearised){.rows = ROWS, .variables = VARIABLES, .white = w->white, .column = w->column[0]};
    for (int i = 0; i < VARIABLES; i++)
        w->model.inverse_std[i] = 0.5 + i, w->model.off[i] = 0.3 - i, w->model.least[i] = -HUGE_VAL, w->model.most[i] = HUGE_VAL;
    w->covariance = (struct covariance){.values = ROWS,
                                        .features = FEATURES,
                                        .evaluated = w->evaluated,
                                        .spread = w->spread,
                                        .law = w->law,
                                        .least = w->least,
                                        .feature = w->feature[0]};
}

/* Lets a leg be held whose force has COEFFICIENTS coefficients. Some rows share a coefficient, as
 * those of a force and of a pressure do. */
static void hold(struct world *w, uint64_t seed) {
    double root[COEFFICIENTS][COEFFICIENTS];
    w->place = (struct held_rows){.first = FIRST_HELD, .rows = HELD};
    for (int i = 0; i < COEFFICIENTS; i++)
        for (int k = 0; k < COEFFICIENTS; k++) root[i][k] = 3.0 * random_unit(&seed);
    for (int i = 0; i < COEFFICIENTS; i++)
        for (int j = 0; j < COEFFICIENTS; j++)
            for (int k = 0; k < COEFFICIENTS; k++) w->place.covariance[i][j] += root[i][k] * root[j][k];
    for (int a = 0; a < ROWS; a++) w->coefficient[a] = a % COEFFICIENTS, w->per_n[a] = 1.0 + random_unit(&seed);
    w->model.held = (struct held){.places = 1, .place = &w->place, .coefficient = w->coefficient, .per_n = w->per_n};
}

static double of_friction(const struct world *w, int a, int b) {
    bool in = w->model.held.places && a >= FIRST_HELD && b >= FIRST_HELD && a < FIRST_HELD + HELD && b < FIRST_HELD + HELD;
    return in ? w->per_n[a] * w->per_n[b] * w->place.covariance[w->coefficient[a]][w->coefficient[b]] : 0.0;
}

/* Returns the log density of the residuals. They are normal; their covariance is the sum of noise,
 * remainder, friction of a leg that may be held, and the priors of the values. */
static double density(const struct world *w, const struct covariance_size *size) {
    double c[ROWS][ROWS] = {{0}}, off[ROWS], x[ROWS], sum = 0.0;
    for (int a = 0; a < ROWS; a++) {
        off[a] = w->white[a];
        for (int i = 0; i < VARIABLES; i++) off[a] -= w->column[i][a] * w->model.off[i];
        x[a] = off[a];
        for (int b = 0; b < ROWS; b++) {
            if (a == b) c[a][a] = covariance_of(&w->covariance, size, a);
            for (int i = 0; i < VARIABLES; i++) c[a][b] += w->column[i][a] * w->column[i][b] / square(w->model.inverse_std[i]);
            c[a][b] += square(size->repeats) * w->feature[0][a] * w->feature[0][b] + of_friction(w, a, b);
        }
    }
    assert_true(dense_factor(ROWS, ROWS, c[0]));
    dense_solve(ROWS, ROWS, c[0], x);
    for (int a = 0; a < ROWS; a++) sum += off[a] * x[a] + 2.0 * log(c[a][a]);
    return -0.5 * sum;
}

static void evidence_is_the_density_of_the_residuals(void **unused) {
    (void)unused;
    static const struct covariance_size sizes[] = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.1}, {0.3, 1.0, 0.0}, {0.1, 0.3, 0.2}};
    struct world w;
    for (uint64_t seed = 1; seed < 20; seed++)
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
            build(&w, seed);
            assert_close(evidence_of(&w.model, &w.covariance, &sizes[i], NULL, NULL), density(&w, &sizes[i]), 1e-9);
            hold(&w, seed);
            assert_close(evidence_of(&w.model, &w.covariance, &sizes[i], NULL, NULL), density(&w, &sizes[i]), 1e-9);
        }
}

static void values_stay_in_their_range(void **unused) {
    (void)unused;
    static const struct covariance_size noise = {0.0, 0.0, 0.0};
    struct world w;
    double change[VARIABLES], std[VARIABLES];
    build(&w, 3);
    double free = evidence_of(&w.model, &w.covariance, &noise, change, std);
    assert_true(fabs(change[0]) > 0.1 && std[0] > 0.0 && std[0] < 1.0 / w.model.inverse_std[0]);
    w.model.least[0] = w.model.most[0] = 0.0;
    assert_true(evidence_of(&w.model, &w.covariance, &noise, change, std) < free);
    assert_close(change[0], 0.0, 1e-12);
}

/* Twice the negative log density of the residuals and of the values' priors, under noise alone. */
static double square_at(const struct world *w, const double change[VARIABLES]) {
    double sum = 0.0;
    for (int a = 0; a < ROWS; a++) {
        double left = w->white[a];
        for (int i = 0; i < VARIABLES; i++) left += w->column[i][a] * change[i];
        sum += square(left) / (1.0 + w->least[a]);
    }
    for (int i = 0; i < VARIABLES; i++) sum += square((w->model.off[i] + change[i]) * w->model.inverse_std[i]);
    return sum;
}

/* The columns are nearly parallel, so both values leave their ranges if they are free. The best
 * place may be at the end of one range and inside the other. */
static void ends_of_ranges_are_chosen_together(void **unused) {
    (void)unused;
    enum { GRID = 200 };
    static const struct covariance_size noise = {0.0, 0.0, 0.0};
    struct world w;
    for (uint64_t seed = 1; seed < 40; seed++) {
        double change[VARIABLES], tried[VARIABLES], best = HUGE_VAL;
        build(&w, seed);
        for (int a = 0; a < ROWS; a++) w.column[1][a] = 20.0 * (w.column[0][a] + 0.02 * w.column[1][a]), w.column[0][a] *= 20.0;
        for (int i = 0; i < VARIABLES; i++) w.model.least[i] = -0.1 - 0.2 * i, w.model.most[i] = 0.3 - 0.1 * i;
        evidence_of(&w.model, &w.covariance, &noise, change, NULL);
        for (int i = 0; i <= GRID; i++)
            for (int j = 0; j <= GRID; j++) {
                tried[0] = w.model.least[0] + (w.model.most[0] - w.model.least[0]) * i / GRID;
                tried[1] = w.model.least[1] + (w.model.most[1] - w.model.least[1]) * j / GRID;
                best = fmin(best, square_at(&w, tried));
            }
        for (int i = 0; i < VARIABLES; i++) assert_true(change[i] >= w.model.least[i] - 1e-12 && change[i] <= w.model.most[i] + 1e-12);
        assert_below(square_at(&w, change), best + 1e-9);
    }
}

/* A remainder that is the same function of the motion in every piece hides effects that look like
 * it, however many pieces there are; one that differs from piece to piece averages out. */
static void pieces_that_repeat_are_no_more_evidence(void **unused) {
    (void)unused;
    static const struct covariance_size repeats = {0.0, 1.0, 0.0}, spread = {1.0, 0.0, 0.0};
    struct world w;
    double std[VARIABLES];
    build(&w, 5);
    for (int a = 0; a < ROWS; a++) w.feature[0][a] = 4.0 * w.column[0][a], w.spread[a] = 16.0 * square(w.column[0][a]);
    w.model.inverse_std[0] = 1e-3;
    evidence_of(&w.model, &w.covariance, &repeats, NULL, std);
    double repeated = std[0];
    evidence_of(&w.model, &w.covariance, &spread, NULL, std);
    assert_true(repeated > 4.0 && std[0] < 0.8 * repeated);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(evidence_is_the_density_of_the_residuals),
        cmocka_unit_test(values_stay_in_their_range),
        cmocka_unit_test(ends_of_ranges_are_chosen_together),
        cmocka_unit_test(pieces_that_repeat_are_no_more_evidence),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
