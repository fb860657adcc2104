#include "skews.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "numeric.h"

enum { SKEW = UNKNOWN_SYSTEMATIC + SYSTEMATIC_SKEW, ITERATIONS = 30 };
static const double SIZE_LEAST_S = 1e-6; /* in a smaller time a leg of 0.1 m/s moves by less than
                                          * 0.1 um */

struct test_skew skews_now(const struct equations *e) {
    struct test_skew now = {.with = e->with[SKEW]};
    for (int c = 0; c < UNKNOWNS; c++) now.product[c] = c >= SKEW ? e->product[c][SKEW] : e->product[SKEW][c];
    return now;
}

/* The factor (D'WD + 1/size^2)^-1 of skews.h, for one test. */
static double gain(const struct test_skew *test, double size) { return 1.0 / (test->product[SKEW] + 1.0 / square(size)); }

static void eliminate(struct equations *e, const struct test_skew *test, double size) {
    double own = gain(test, size);
    for (int c = 0; c < UNKNOWNS; c++) {
        if (test->product[c] == 0.0) continue;
        e->with[c] -= own * test->product[c] * test->with;
        for (int d = 0; d <= c; d++) e->product[c][d] -= own * test->product[c] * test->product[d];
    }
}

static void keep(struct equations *e, const struct test_skew *test) {
    if (e->skews < SKEW_TESTS) e->skew[e->skews++] = *test;
    else eliminate(e, test, e->skew_test_s);
}

void skews_add(struct equations *e, const struct test_skew *before) {
    struct test_skew test = skews_now(e);
    test.with -= before->with;
    for (int c = 0; c < UNKNOWNS; c++) test.product[c] -= before->product[c];
    keep(e, &test);
}

void skews_join(struct equations *sum, const struct equations *e) {
    sum->skew_test_s = fmax(sum->skew_test_s, e->skew_test_s);
    for (int t = 0; t < e->skews; t++) keep(sum, &e->skew[t]);
}

/* Normal equations of the departures alone, with all other unknowns eliminated. */
struct reduced {
    double product[SKEW_TESTS][SKEW_TESTS], with[SKEW_TESTS];
};

static void reduce(const struct equations *e, double factor[UNKNOWNS][UNKNOWNS], struct reduced *r) {
    for (int t = 0; t < e->skews; t++) {
        double solved[UNKNOWNS];
        memcpy(solved, e->skew[t].product, sizeof solved);
        dense_solve(UNKNOWNS, UNKNOWNS, factor[0], solved);
        r->with[t] = e->skew[t].with - dense_dot(UNKNOWNS, solved, e->with);
        for (int u = 0; u < e->skews; u++) r->product[u][t] = -dense_dot(UNKNOWNS, solved, e->skew[u].product);
        r->product[t][t] += e->skew[t].product[SKEW];
    }
}

/* Improves the size by one step. Returns false if the equations are not positive definite. */
static bool step(const struct reduced *r, int tests, double *size) {
    double factor[SKEW_TESTS][SKEW_TESTS], departure[SKEW_TESTS], variance[SKEW_TESTS], work[SKEW_TESTS], sum = 0.0, determined = 0.0;
    memcpy(factor, r->product, sizeof factor);
    memcpy(departure, r->with, sizeof departure);
    for (int t = 0; t < tests; t++) factor[t][t] += 1.0 / square(*size);
    if (!dense_factor(tests, SKEW_TESTS, factor[0])) return false;
    dense_solve(tests, SKEW_TESTS, factor[0], departure);
    dense_inverse_diagonal(tests, SKEW_TESTS, factor[0], variance, work);
    for (int t = 0; t < tests; t++) {
        sum += square(departure[t]);
        determined += fmax(1.0 - variance[t] / square(*size), 0.0);
    }
    if (determined > 0.0) *size = sqrt(sum / determined);
    return true;
}

double skews_size(const struct equations *e, double factor[UNKNOWNS][UNKNOWNS]) {
    struct reduced r = {0};
    double size = e->skew_test_s;
    if (!e->skews || !(size > 0.0)) return 0.0;
    reduce(e, factor, &r);
    for (int i = 0; i < ITERATIONS && step(&r, e->skews, &size); i++) size = fmin(fmax(size, SIZE_LEAST_S), e->skew_test_s);
    return size;
}

void skews_eliminate(struct equations *e, double size) {
    for (int t = 0; t < e->skews && size > 0.0; t++) eliminate(e, &e->skew[t], size);
}

void skews_departures(const struct equations *e, double size, const double value[UNKNOWNS], double departure[SKEW_TESTS]) {
    memset(departure, 0, SKEW_TESTS * sizeof *departure);
    for (int t = 0; t < e->skews && size > 0.0; t++)
        departure[t] = gain(&e->skew[t], size) * (e->skew[t].with - dense_dot(UNKNOWNS, e->skew[t].product, value));
}
