/* Harmonics of a test, cycle by cycle. */
#include "support.h"

#include <stdlib.h>

#include "tone.h"
#include "units.h"

enum { SAMPLES = 2500 };

static const double step_s = 0.002;
static spectrum_cycle room[CYCLES_MAX];

static struct recording_test make(double frequency_hz, struct recording_sample *sample) {
    for (int i = 0; i < SAMPLES; i++) sample[i] = (struct recording_sample){.test_time_s = 1.0 + i * step_s};
    return (struct recording_test){.frequency_hz = frequency_hz, .sample = sample, .count = SAMPLES, .end = SAMPLES};
}

static double wave(double phase) { return 0.3 + sin(phase) - 0.5 * cos(3.0 * phase); }

/* At 3 Hz a cycle is not a whole number of samples. */
static void spectrum_recovers_a_waveform_at_any_frequency(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    for (double f = 3.0; f <= 4.0; f += 0.5) {
        struct recording_test t = make(f, sample);
        struct spectrum s;
        double value[3], phase = 0.7, omega = 2.0 * PI * f;
        for (int i = 0; i < SAMPLES; i++) sample[i].length_m[2] = wave(omega * sample[i].test_time_s);
        assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
        spectrum_value(s.mean[CHANNEL_LENGTH][2], s.harmonics, omega, phase / omega, value);
        assert_close(value[0], wave(phase), 1e-9); /* tolerance: rounding of a 33x33 system */
        assert_close(value[1], omega * (cos(phase) + 1.5 * sin(3.0 * phase)), 1e-7);
        assert_close(value[2], omega * omega * (-sin(phase) + 4.5 * cos(3.0 * phase)), 1e-5);
        assert_below(s.noise[CHANNEL_LENGTH][2], 1e-9);
    }
}

static void a_drift_is_measured_and_leaves_no_harmonics(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    struct recording_test t = make(4.0, sample);
    struct spectrum s;
    for (int i = 0; i < SAMPLES; i++) sample[i].p1_pa[0] = 100.0 * sample[i].test_time_s;
    assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
    assert_close(s.drift[CHANNEL_P1][0], 100.0, 1e-6);
    for (int a = 1; a < SPECTRUM_SIZE; a++) assert_below(fabs(s.mean[CHANNEL_P1][0][a]), 1e-9);
}

/* Four cycles make halves of two, which alone would not show a slope. A cycle's share of the drift
 * is neither noise nor harmonics. */
static void both_halves_of_a_test_have_its_drift(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    struct recording_test t = make(4.0, sample);
    struct spectrum s;
    double per_s = 100.0;
    t.count = t.end = 500;
    for (int i = 0; i < t.count; i++) sample[i].p1_pa[0] = per_s * sample[i].test_time_s + (i % 2 ? 1.0 : -1.0);
    for (enum cycles half = CYCLES_EVEN; half <= CYCLES_ALL; half++) {
        assert_true(spectrum_measure(&s, room, &t, step_s, half));
        assert_int_equal(s.cycles, half == CYCLES_ALL ? 4 : 2);
        assert_close(s.drift[CHANNEL_P1][0], per_s, 0.05);
        assert_close(s.noise[CHANNEL_P1][0], 1.0, 0.05);
        for (int a = 1; a < SPECTRUM_SIZE; a++) assert_below(fabs(s.mean[CHANNEL_P1][0][a]), 0.1);
    }
    for (int c = 1; c < 4; c += 2) sample[c * 125 + 62].refused = sample[c * 125 + 63].refused = true;
    assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_EVEN));
    assert_close(s.drift[CHANNEL_P1][0], per_s, 0.5);
}

/* The means of independent draws have the stated standard deviation. */
static void noise_is_measured_from_the_spread_of_cycles(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    struct recording_test t = make(4.0, sample);
    struct spectrum s;
    uint64_t random = 7;
    double square = 0.0, expected = 0.0;
    for (int i = 0; i < SAMPLES; i++)
        for (int k = 0; k < LEGS; k++) sample[i].p1_pa[k] = random_unit(&random);
    assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
    for (int k = 0; k < LEGS; k++)
        for (int a = 1; a < 1 + 2 * s.harmonics; a++) {
            square += s.mean[CHANNEL_P1][k][a] * s.mean[CHANNEL_P1][k][a];
            expected += s.std[CHANNEL_P1][k][a] * s.std[CHANNEL_P1][k][a];
        }
    /* tolerance: for 192 values, either sum has a standard deviation of 0.1 */
    assert_close(square / expected, 1.0, 0.35);
    assert_close(s.noise[CHANNEL_P1][0], 1.0 / sqrt(3.0), 0.02);
}

/* Every harmonic has a correlation of 0.7 from cycle to cycle, so the variance of the mean is 1.7 /
 * 0.3 times as large as with independent cycles. */
static void what_lasts_from_cycle_to_cycle_counts_in_the_means(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    struct recording_test t = make(4.0, sample);
    struct spectrum s;
    uint64_t random = 8;
    double square = 0.0, expected = 0.0;
    for (int draw = 0; draw < 40; draw++) {
        double part[1 + 2 * SPECTRUM_HARMONICS] = {0}, basis[1 + 2 * SPECTRUM_HARMONICS];
        for (int i = -20 * 125; i < SAMPLES; i++) { /* begins twenty cycles earlier, to forget the
                                                     * initial state */
            if (i % 125 == 0)
                for (int a = 1; a < 17; a++) part[a] = 0.7 * part[a] + random_unit(&random);
            if (i < 0) continue;
            spectrum_basis(2.0 * PI * 4.0 * sample[i].test_time_s, 8, basis);
            sample[i].p1_pa[0] = 0.0;
            for (int a = 1; a < 17; a++) sample[i].p1_pa[0] += part[a] * basis[a];
        }
        assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
        for (int a = 1; a < 17; a++) {
            square += s.mean[CHANNEL_P1][0][a] * s.mean[CHANNEL_P1][0][a];
            expected += s.std[CHANNEL_P1][0][a] * s.std[CHANNEL_P1][0][a];
        }
    }
    print_message("# mean squares of the means over those stated: %.2f\n", square / expected);
    assert_true(square / expected > 0.6 && square / expected < 2.5);
}

/* The amplitude of the motion itself may change within a minute; that change is no noise of the
 * other harmonics. */
static void a_harmonic_that_drifts_does_not_spoil_the_others(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    struct recording_test t = make(4.0, sample);
    struct spectrum s;
    double third[2];
    for (int drifts = 0; drifts < 2; drifts++) {
        uint64_t random = 9;
        for (int i = 0; i < SAMPLES; i++) {
            double phase = 2.0 * PI * 4.0 * sample[i].test_time_s;
            sample[i].length_m[0] = (1.0 + drifts * 0.2 * i / SAMPLES) * sin(phase) + 0.01 * random_unit(&random);
        }
        assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
        third[drifts] = hypot(s.std[CHANNEL_LENGTH][0][5], s.std[CHANNEL_LENGTH][0][6]);
    }
    print_message("# the third harmonic's deviation, %.2f times as large\n", third[1] / third[0]);
    assert_below(third[1], 1.5 * third[0]);
}

static void even_and_odd_cycles_are_apart(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    struct recording_test t = make(4.0, sample);
    struct spectrum s;
    for (int i = 0; i < SAMPLES; i++) sample[i].length_m[0] = i / 125 % 2 * sin(2.0 * PI * t.frequency_hz * sample[i].test_time_s);
    assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_EVEN));
    assert_close(s.mean[CHANNEL_LENGTH][0][1], 0.0, 1e-12);
    assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ODD));
    assert_close(s.mean[CHANNEL_LENGTH][0][1], 1.0, 1e-9);
    assert_int_equal(s.cycles, 10);
}

static void bad_samples_are_left_out_and_a_cycle_that_has_too_many(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    struct recording_test t = make(4.0, sample);
    struct spectrum s;
    sample[300].refused = REFUSED_LATE;
    sample[300].length_m[0] = NAN;
    assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
    assert_int_equal(s.cycles, 20);
    assert_true(fabs(s.mean[CHANNEL_LENGTH][0][0]) < 1e-12 && s.noise[CHANNEL_LENGTH][0] < 1e-12);
    for (int i = 260; i < 300; i += 4) sample[i].refused = REFUSED_LATE;
    assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
    assert_int_equal(s.cycles, 20);
    sample[310].refused = sample[320].refused = REFUSED_LATE; /* with these, too many samples are
                                                               * missing */
    assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
    assert_int_equal(s.cycles, 19);
    /* the gap is 10 ms, longer than the 16th harmonic's period of 7.8 ms */
    for (int i = 400; i < 404; i++) sample[i].refused = REFUSED_LATE;
    assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
    assert_int_equal(s.cycles, 18);
}

/* The amplitude oscillates in the first second and settles, which is no tone; a pump's tone is
 * found even if it is a fiftieth as large. */
static void what_fades_is_no_line_and_what_stays_is_one(void **state) {
    (void)state;
    static struct recording_sample sample[SAMPLES];
    for (int pump = 0; pump < 2; pump++) {
        struct recording_test t = make(2.0, sample);
        struct spectrum s;
        uint64_t random = 11;
        for (int i = 0; i < SAMPLES; i++) {
            double at_s = i * step_s, fading = exp(-at_s / 0.3);
            for (int k = 0; k < LEGS; k++)
                sample[i].length_m[k] = (1.0 + 0.01 * fading) * sin(4.0 * PI * at_s) + 0.002 * fading * sin(50.0 * at_s) +
                                        1e-4 * random_unit(&random) + pump * 2e-4 * sin(2.0 * PI * 83.3 * at_s + k);
        }
        assert_true(spectrum_measure(&s, room, &t, step_s, CYCLES_ALL));
        struct tone tone = tone_in(&s, &t, step_s, CHANNEL_LENGTH);
        if (pump) {
            assert_close(tone.hz, 83.3, 0.2);
            /* tolerance: half-way between two bins a tone seems 15 % smaller */
            assert_close(tone.rms, 2e-4 / sqrt(2.0), 0.22e-4);
        }
        assert_true(pump ? tone.power > 30.0 : tone.power < 6.0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spectrum_recovers_a_waveform_at_any_frequency),
        cmocka_unit_test(a_drift_is_measured_and_leaves_no_harmonics),
        cmocka_unit_test(both_halves_of_a_test_have_its_drift),
        cmocka_unit_test(noise_is_measured_from_the_spread_of_cycles),
        cmocka_unit_test(what_lasts_from_cycle_to_cycle_counts_in_the_means),
        cmocka_unit_test(a_harmonic_that_drifts_does_not_spoil_the_others),
        cmocka_unit_test(even_and_odd_cycles_are_apart),
        cmocka_unit_test(bad_samples_are_left_out_and_a_cycle_that_has_too_many),
        cmocka_unit_test(what_fades_is_no_line_and_what_stays_is_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
