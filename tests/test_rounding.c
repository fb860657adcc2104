/* Rounding errors that repeat in every cycle. */
#include "support.h"

#include "rounding.h"
#include "sampling.h"
#include "spectrum.h"
#include "units.h"

enum { SAMPLES = 2500, DRAWS = 100 };

static const double step_s = 0.002;
static const double SETTLING_CYCLES = 1.5;
static spectrum_cycle room[CYCLES_MAX];

static struct recording_test make(double frequency_hz, struct recording_sample *sample) {
    for (int i = 0; i < SAMPLES; i++) sample[i] = (struct recording_sample){.test_time_s = 1.0 + i * step_s};
    return (struct recording_test){.frequency_hz = frequency_hz, .sample = sample, .count = SAMPLES, .end = SAMPLES};
}

/* The length of a test in its mean cycle, as it is rounded; `room` has its cycles. */
static struct rounding rounded(const struct spectrum *s, double hz, double step_m, double middle[CYCLES_MAX]) {
    for (int i = 0; i < s->cycles; i++) middle[i] = room[i][CHANNEL_LENGTH][0][0];
    return (struct rounding){.step = step_m,
                             .scatter = s->scatter[CHANNEL_LENGTH][0],
                             .places = (int)ceil(s->offsets / hz / step_s - 1e-6),
                             .cycles = s->cycles,
                             .middle = middle};
}

/* Returns the square of the rounding error in the mean cycle's harmonics first to last, in excess
 * of the scatter, divided by the predicted one. The sinusoids have about this amplitude and this
 * much vibration, and their middle settles exponentially by settles_m. */
static double harmonics_over_predicted(double hz, double amplitude_m, double shaken_m, double settles_m, int first, int last) {
    static struct recording_sample sample[SAMPLES];
    const double step_m = 50e-6;
    double found = 0.0, predicted = 0.0;
    uint64_t random = 3;
    for (int n = 0; n < DRAWS; n++) {
        struct recording_test t = make(hz, sample);
        struct spectrum s;
        double amplitude = amplitude_m * (1.0 + 0.1 * random_unit(&random)), offset_m = step_m * random_unit(&random);
        double phase = 2.0 * PI * hz * step_s * random_unit(&random);
        for (int i = 0; i < SAMPLES; i++) {
            /* triangular distribution */
            double shaken = shaken_m * sqrt(1.5) * (random_unit(&random) + random_unit(&random));
            double x = amplitude * sin(2.0 * PI * hz * sample[i].test_time_s + phase) + offset_m + shaken;
            x -= settles_m * exp(-floor((sample[i].test_time_s - 1.0) * hz + 1e-6) / SETTLING_CYCLES);
            sample[i].length_m[0] = step_m * round(x / step_m);
        }
        assert_true(spectrum_measure(&s, room, &t, sampling_step_s(&t, t.first, t.end), CYCLES_ALL));
        double variance[SPECTRUM_SIZE], middle[CYCLES_MAX];
        const struct rounding r = rounded(&s, hz, step_m, middle);
        struct rounding_shares shares;
        rounding_find_shares(&r, s.harmonics, s.mean[CHANNEL_LENGTH][0], &shares);
        rounding_in_step(&r, &shares, s.harmonics, variance);
        for (int a = 2 * first - 1; a <= 2 * last; a++) {
            double truth = a == 1 ? amplitude * cos(phase) : a == 2 ? amplitude * sin(phase) : 0.0;
            found += pow(s.mean[CHANNEL_LENGTH][0][a] - truth, 2.0) - pow(s.std[CHANNEL_LENGTH][0][a], 2.0);
            predicted += variance[a];
        }
    }
    return found / predicted;
}

static double rounding_over_predicted(double hz, double amplitude_m, double shaken_m, double settles_m) {
    return harmonics_over_predicted(hz, amplitude_m, shaken_m, settles_m, 1, 8);
}

/* A leg that moves by four steps: what falls on each harmonic depends on where in a step it turns,
 * which the rounded samples do not tell. */
static void each_harmonic_has_its_share(void **state) {
    (void)state;
    numbers_case();
    for (int harmonic = 1; harmonic <= 5; harmonic++)
        assert_close(harmonics_over_predicted(4.0, 224e-6, 3e-6, 0.0, harmonic, harmonic), 1.0, 0.35);
}

/* Below 2 mm, tones of the rounding errors coincide with harmonics; above, they are aliased onto
 * harmonics. Vibration reduces both. */
static void quantisation_in_step_is_as_large_as_predicted(void **state) {
    (void)state;
    slow_sweep();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    static const double amplitude_m[] = {0.3e-3, 3.4e-3}, shaken_m[] = {0.0, 4e-6, 9e-6};
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < (more_cases() ? 3 : 2); j++)
            assert_close(rounding_over_predicted(4.0, amplitude_m[i], shaken_m[j], 0.0), 1.0, 0.35);
    /* a cycle is no whole number of samples: aliased errors average out, the others remain */
    assert_close(rounding_over_predicted(3.0, amplitude_m[0], 0.0, 0.0), 1.0, 0.35);
    assert_close(rounding_over_predicted(3.97, amplitude_m[0], 0.0, 0.0), 1.0, 0.35);
}

/* A machine that settles by two steps in the first second moves much, but most cycles of the test
 * come later and have no dither. Their errors repeat as if nothing had settled. */
static void settling_is_no_dither(void **state) {
    (void)state;
    numbers_case();
    assert_close(rounding_over_predicted(4.0, 2.1e-3, 0.0, 100e-6), 1.0, 0.35);
    assert_close(rounding_over_predicted(4.0, 2.1e-3, 4e-6, 100e-6), 1.0, 0.35);
}

/* The even cycles have the same rounding errors by the shares of all cycles as by their own. */
static void shares_of_all_cycles_serve_half_of_them(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    const double step_m = 50e-6, hz = 4.0;
    struct recording_test t = make(hz, sample);
    struct spectrum s[2];
    struct rounding_shares shares[2];
    double variance[2][SPECTRUM_SIZE], middle[CYCLES_MAX], sum[2] = {0.0, 0.0};
    uint64_t random = 7;
    for (int i = 0; i < SAMPLES; i++)
        sample[i].length_m[0] = step_m *
                                round((0.9e-3 * sin(2.0 * PI * hz * sample[i].test_time_s) + 3e-6 * random_unit(&random)) / step_m);
    for (int n = 0; n < 2; n++) {
        assert_true(spectrum_measure(&s[n], room, &t, sampling_step_s(&t, t.first, t.end), n ? CYCLES_EVEN : CYCLES_ALL));
        const struct rounding r = rounded(&s[n], hz, step_m, middle);
        rounding_find_shares(&r, s[n].harmonics, s[n].mean[CHANNEL_LENGTH][0], &shares[n]);
        rounding_in_step(&r, &shares[0], s[n].harmonics, variance[0]);
        rounding_in_step(&r, &shares[n], s[n].harmonics, variance[1]);
    }
    for (int a = 1; a < 1 + 2 * s[1].harmonics; a++) sum[0] += variance[0][a], sum[1] += variance[1][a];
    assert_true(sum[1] > 0.0);
    assert_close(sum[0] / sum[1], 1.0, 0.1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quantisation_in_step_is_as_large_as_predicted),
        cmocka_unit_test(settling_is_no_dither),
        cmocka_unit_test(each_harmonic_has_its_share),
        cmocka_unit_test(shares_of_all_cycles_serve_half_of_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
