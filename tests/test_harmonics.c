/* Running harmonic least squares recovers its input, agrees with an orthogonal decomposition, and
 * states its own uncertainty correctly. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "harmonics.h"
#include "units.h"

static const double omega = 2 * PI * 4;

/* Returns a random number, uniform in 0..1; the same sequence in every run. */
static double random_uniform(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

static double random_normal(uint64_t *state) { return sqrt(-2.0 * log(1.0 - random_uniform(state))) * cos(2 * PI * random_uniform(state)); }

/* Fails on NaN. */
static void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance)) fail_msg("%.17g is not within %g of %.17g", value, tolerance, expected);
}

struct signal {
    double constant, drift_per_s, sine[HARMONICS_MAX], cosine[HARMONICS_MAX];
};

static double signal_at(const struct signal *s, double t_s, int harmonics) {
    double value = s->constant + s->drift_per_s * t_s;
    for (int k = 0; k < harmonics; k++) value += s->sine[k] * sin((k + 1) * omega * t_s) + s->cosine[k] * cos((k + 1) * omega * t_s);
    return value;
}

static struct signal signal_random(uint64_t *state) {
    struct signal s = {.constant = 10 * random_normal(state), .drift_per_s = random_normal(state)};
    for (int k = 0; k < HARMONICS_MAX; k++) s.sine[k] = random_normal(state), s.cosine[k] = random_normal(state);
    return s;
}

static void fit_recovers_the_signal_it_was_made_from(void **unused) {
    (void)unused;
    for (int harmonics = 1; harmonics <= HARMONICS_MAX; harmonics++) {
        uint64_t state = (uint64_t)harmonics;
        struct signal s[CHANNELS_MAX];
        struct harmonics h;
        struct harmonics_fit fit;
        for (int c = 0; c < CHANNELS_MAX; c++) s[c] = signal_random(&state);
        harmonics_reset(&h, omega, harmonics, CHANNELS_MAX);
        for (int i = 0; i < 2500; i++) {
            double values[CHANNELS_MAX], t = 1.0 + 0.002 * i;
            for (int c = 0; c < CHANNELS_MAX; c++) values[c] = signal_at(&s[c], t, harmonics);
            harmonics_add(&h, t, values);
        }
        assert_true(harmonics_solve(&h, &fit));
        assert_true(fit.condition < 4);
        for (int c = 0; c < CHANNELS_MAX; c++) {
            /* values near 10 rounded to 1e-15, squared condition number 4, and some hundred samples
             * whose errors may add up */
            const double tolerance = 1e-12;
            assert_near(fit.constant[c], s[c].constant + s[c].drift_per_s * 1.0, tolerance);
            assert_near(fit.drift_per_s[c], s[c].drift_per_s, tolerance);
            for (int k = 0; k < harmonics; k++) {
                assert_near(fit.sine[c][k], s[c].sine[k], tolerance);
                assert_near(fit.cosine[c][k], s[c].cosine[k], tolerance);
            }
            /* the residual's floor, stated in the header, is 1e-8 of values up to 30 */
            assert_near(fit.rms[c], 0.0, 1e-6);
        }
    }
}

/* Reference solution: QR by Givens rotations, one row at a time, in extended precision. */
enum { QR_SIZE = REGRESSORS_MAX };

static void givens_add(long double r[QR_SIZE][QR_SIZE + 1], int n, long double *row) {
    for (int i = 0; i < n; i++) {
        long double length = hypotl(r[i][i], row[i]);
        if (!(length > 0)) continue;
        long double c = r[i][i] / length, s = row[i] / length;
        for (int j = i; j <= n; j++) {
            long double upper = r[i][j];
            r[i][j] = c * upper + s * row[j];
            row[j] = c * row[j] - s * upper;
        }
    }
}

static void givens_solve(long double r[QR_SIZE][QR_SIZE + 1], int n, long double *x) {
    for (int i = n - 1; i >= 0; i--) {
        x[i] = r[i][n];
        for (int j = i + 1; j < n; j++) x[i] -= r[i][j] * x[j];
        x[i] /= r[i][i];
    }
}

/* The channel is noisy, with an offset of 1000 and a drift, over a test of ten minutes, in the
 * daemon's doubles. */
static void normal_equations_agree_with_orthogonal_decomposition_over_600_s(void **unused) {
    (void)unused;
    enum { HARMONICS = 3, N = 2 + 2 * HARMONICS };
    long double r[QR_SIZE][QR_SIZE + 1] = {0}, x[N];
    struct signal s = {.constant = 1000, .drift_per_s = 0.01, .sine = {1, 0.1, 0.05}, .cosine = {0.3, -0.1, 0.02}};
    struct harmonics h;
    struct harmonics_fit fit;
    uint64_t state = 5;
    harmonics_reset(&h, omega, HARMONICS, 1);
    for (int i = 0; i < 300000; i++) {
        double t = 1.0 + 0.002 * i, value = signal_at(&s, t, HARMONICS) + 0.05 * random_normal(&state);
        long double row[N + 1] = {1, (long double)t - 1.0L};
        for (int k = 0; k < HARMONICS; k++) {
            row[2 + 2 * k] = sinl((long double)omega * (k + 1) * t);
            row[3 + 2 * k] = cosl((long double)omega * (k + 1) * t);
        }
        row[N] = value;
        givens_add(r, N, row);
        harmonics_add(&h, t, &value);
    }
    givens_solve(r, N, x);
    assert_true(harmonics_solve(&h, &fit));
    assert_true(fit.condition < 4);
    /* The phase w t goes up to 1.5e4 rad and is rounded to 2e-12 rad, which bounds the accuracy of
     * doubles; the mean of that error over the test is far smaller. */
    assert_near(fit.constant[0], (double)x[0], 1e-12 * 1000);
    assert_near(fit.drift_per_s[0], (double)x[1], 1e-12);
    for (int k = 0; k < HARMONICS; k++) {
        assert_near(fit.sine[0][k], (double)x[2 + 2 * k], 1e-12);
        assert_near(fit.cosine[0][k], (double)x[3 + 2 * k], 1e-12);
    }
}

static void a_small_motion_on_a_large_offset_keeps_its_digits(void **unused) {
    (void)unused;
    struct harmonics h;
    struct harmonics_fit fit;
    harmonics_reset(&h, omega, 1, 1);
    for (int i = 0; i < 2500; i++) {
        double t = 0.002 * i, value = 1e6 + sin(omega * t);
        harmonics_add(&h, t, &value);
    }
    assert_true(harmonics_solve(&h, &fit));
    /* each sample is rounded to 1e-10, and 2500 of them are averaged */
    assert_near(fit.sine[0][0], 1.0, 1e-11);
    assert_near(fit.cosine[0][0], 0.0, 1e-11);
}

static void rms_is_that_of_the_noise_and_std_the_spread_of_the_coefficients(void **unused) {
    (void)unused;
    enum { RUNS = 1000, SAMPLES = 300 };
    const double noise = 0.2;
    uint64_t state = 17;
    double squares = 0, variances = 0, rms = 0;
    for (int run = 0; run < RUNS; run++) {
        struct harmonics h;
        struct harmonics_fit fit;
        harmonics_reset(&h, omega, 1, 1);
        for (int i = 0; i < SAMPLES; i++) {
            double t = 0.002 * i, value = 3 + sin(omega * t) + noise * random_normal(&state);
            harmonics_add(&h, t, &value);
        }
        assert_true(harmonics_solve(&h, &fit));
        squares += pow(fit.sine[0][0] - 1, 2) + pow(fit.cosine[0][0], 2);
        variances += 2 * fit.std[0] * fit.std[0];
        rms += fit.rms[0] * fit.rms[0];
    }
    /* The observed variance of 2 RUNS values has a relative spread of sqrt(2 / (2 RUNS)) = 3.2 %;
     * the tolerance is four of them. */
    assert_near(squares / variances, 1.0, 0.13);
    /* The rms has RUNS * SAMPLES squares, less the share of the four coefficients: its spread is
     * sqrt(2 / 3e5) = 0.26 %, and the tolerance four of them. */
    assert_near(rms / RUNS / (noise * noise * (SAMPLES - 4) / SAMPLES), 1.0, 0.0104);
}

static void channels_do_not_mix(void **unused) {
    (void)unused;
    struct harmonics together, alone;
    struct harmonics_fit fit_together, fit_alone;
    harmonics_reset(&together, omega, 2, 3);
    harmonics_reset(&alone, omega, 2, 1);
    for (int i = 0; i < 500; i++) {
        double t = 0.002 * i, values[3] = {1e5 * cos(omega * t), sin(omega * t) + t, 1e-5 * t};
        harmonics_add(&together, t, values);
        harmonics_add(&alone, t, values + 1);
    }
    assert_true(harmonics_solve(&together, &fit_together) && harmonics_solve(&alone, &fit_alone));
    assert_true(fit_together.sine[1][0] == fit_alone.sine[0][0] && fit_together.std[1] == fit_alone.std[0]);
}

static bool solvable(int harmonics, double period_s, int samples) {
    struct harmonics h;
    struct harmonics_fit fit;
    harmonics_reset(&h, omega, harmonics, 1);
    for (int i = 0; i < samples; i++) {
        double t = period_s * i, value = sin(omega * t);
        harmonics_add(&h, t, &value);
    }
    bool solved = harmonics_solve(&h, &fit);
    if (!solved) assert_true(isnan(fit.sine[0][0]) && isnan(fit.rms[0]) && isnan(fit.std[0]));
    return solved;
}

static void what_cannot_be_told_apart_is_refused(void **unused) {
    (void)unused;
    assert_true(solvable(3, 0.002, 250));
    assert_false(solvable(3, 0.002, 0));
    assert_false(solvable(3, 0.002, 1));
    assert_false(solvable(3, 0.002, 8));      /* the fit has eight unknowns, so eight samples leave
                                               * no residual */
    assert_false(solvable(3, 0.0001, 20));    /* the samples span only 1/125 of a period */
    assert_false(solvable(2, 1.0 / 16, 500)); /* second harmonic at half the sampling rate: its sine
                                               * is zero at every sample */
    assert_false(solvable(1, 0.0, 500));      /* zero sampling period */
}

static void a_value_that_is_not_finite_is_not_hidden(void **unused) {
    (void)unused;
    struct harmonics h;
    struct harmonics_fit fit;
    harmonics_reset(&h, omega, 1, 1);
    for (int i = 0; i < 500; i++) harmonics_add(&h, 0.002 * i, &(double){i == 77 ? (double)NAN : 1.0});
    assert_false(harmonics_solve(&h, &fit));
    assert_true(isnan(fit.sine[0][0]));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fit_recovers_the_signal_it_was_made_from),
        cmocka_unit_test(normal_equations_agree_with_orthogonal_decomposition_over_600_s),
        cmocka_unit_test(a_small_motion_on_a_large_offset_keeps_its_digits),
        cmocka_unit_test(rms_is_that_of_the_noise_and_std_the_spread_of_the_coefficients),
        cmocka_unit_test(channels_do_not_mix),
        cmocka_unit_test(what_cannot_be_told_apart_is_refused),
        cmocka_unit_test(a_value_that_is_not_finite_is_not_hidden),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
