/* Friction as it is estimated before any force is evaluated, from motions with known reversals, and
 * the scale of its basis functions. */
#include "support.h"

#include "basis_sizes.h"
#include "friction_course.h"
#include "kinematics.h"
#include "units.h"

enum { RATE = 500, CYCLES = 20, HZ = 4, SAMPLES = CYCLES * RATE / HZ };

static struct params params;

/* Returns a record in which every leg moves in a sinusoid of its own amplitude, all in phase, with
 * noise of the readings. */
static struct residual_data *record(const double amplitude_m[LEGS], double noise_m) {
    static struct recording recording;
    static struct residual_data data;
    struct kinematics k;
    struct error error;
    uint64_t seed = 3;
    config_default(&params);
    params.sensors.enabled = false;
    assert_int_equal(kinematics_init(&k, &params, &error), 0);
    recording_init(&recording, &params);
    recording.measured = (struct recording_measured){.force = true};
    recording.tests = 1;
    recording.test[0] = (struct recording_test){.dof = DOF_X, .frequency_hz = HZ, .stated_hz = HZ, .first = 0, .end = SAMPLES};
    for (int i = 0; i < SAMPLES; i++) {
        double t_s = (double)i / RATE;
        struct recording_sample s = {.test_time_s = t_s, .clock_s = t_s};
        for (int l = 0; l < LEGS; l++)
            s.length_m[l] = k.neutral_length_m[l] + amplitude_m[l] * sin(2.0 * PI * HZ * t_s) + noise_m * random_unit(&seed);
        assert_int_equal(recording_append(&recording.test[0], &s, &error), 0);
    }
    assert_int_equal(measured_make(&recording, 0, &error), 0);
    assert_int_equal(residual_prepare(&data, &recording, CYCLES_ALL, &error), 0);
    recording_free(&recording);
    return &data;
}

static const double amplitude_m[LEGS] = {3e-3, 1e-3, 0.3e-3, 0.1e-3, 10e-6, 0.0};

static void a_leg_is_sure_of_its_direction_but_near_reversals(void **unused) {
    (void)unused;
    static struct friction_course c;
    struct residual_data *data = record(amplitude_m, 20e-6);
    friction_course_find(&c, &data->test[0], 0.0);
    for (int k = 0; k < LEGS; k++) {
        double doubt = 0.0;
        for (int i = 0; i < PHASES; i++) {
            double truth = cos(2.0 * PI * i / PHASES) > 0.0 ? 1.0 : -1.0;
            assert_true(fabs(c.direction[i][k]) <= 1.0 && c.doubt[i][k] >= 0.0);
            assert_close(c.doubt[i][k], 1.0 - c.direction[i][k] * c.direction[i][k], 1e-12);
            if (c.doubt[i][k] < 0.1 && amplitude_m[k] > 50e-6) assert_true(c.direction[i][k] * truth > 0.0);
            doubt += c.doubt[i][k] / PHASES;
        }
        if (k == 0) assert_below(doubt, 0.05);          /* this leg moves at up to 75 mm/s */
        if (k < 3) assert_below(doubt, 0.3);            /* 7.5 mm/s */
        /* this leg moves at a tenth of the speed at which it may stick, or rests */
        if (k >= 4) assert_true(doubt > 0.9);
    }
    residual_free(data);
}

/* The friction of a leg that does not move can be anything up to one newton. */
static void what_is_not_known_is_as_large_as_friction_is(void **unused) {
    (void)unused;
    static struct friction_course c;
    static double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE];
    struct residual_data *data = record(amplitude_m, 1e-6);
    const struct residual_test *t = &data->test[0];
    friction_course_find(&c, t, 0.0);
    double power[LEGS] = {0};
    for (int k = 0; k < LEGS; k++) {
        friction_course_covariance(&c, t, k, covariance);
        for (int a = 0; a < t->size; a++) {
            assert_true(covariance[a][a] >= 0.0);
            /* Parseval's theorem: the sum over the harmonics is the mean over the time */
            power[k] += covariance[a][a] * (a ? 0.5 : 1.0);
            for (int b = 0; b < a; b++) {
                assert_close(covariance[a][b], covariance[b][a], 1e-12);
                assert_true(covariance[a][b] * covariance[a][b] <= covariance[a][a] * covariance[b][b] * (1.0 + 1e-9));
            }
        }
        if (k)
            assert_true(power[k] > power[k - 1]); /* the uncertainty of a leg's friction grows as
                                                      * the leg slows down */
    }
    assert_below(power[0], 0.05);
    assert_below(power[LEGS - 1], 1.0 + 1e-9);
    assert_true(power[LEGS - 1] > 0.9);
    residual_free(data);
}

/* Dahl's law: after a reversal the state approaches the new direction as exp(-way / length), and
 * the basis function is its deviation from that direction. This one has the longest fitted length;
 * the leg moves 6 mm. */
static void the_last_basis_function_is_a_seal_that_gives_by_a_third_of_a_millimetre(void **unused) {
    (void)unused;
    static const double give_m = 320e-6;
    static struct friction_course c;
    struct residual_data *data = record(amplitude_m, 0.0);
    friction_course_find(&c, &data->test[0], 0.0);
    for (int i = PHASES / 4 + 6; i < 3 * PHASES / 4 - 6; i++) { /* the leg retracts after the
                                                                 * crest */
        double way_m = amplitude_m[0] * (1.0 - sin(2.0 * PI * i / PHASES));
        assert_close(c.basis[BASIS_SIZE - 1][i][0], 2.0 * exp(-way_m / give_m), 0.01);
    }
    residual_free(data);
}

/* The equations measure each coefficient directly, with a standard deviation of one newton. */
static void sizes_are_those_of_the_coefficients(void **unused) {
    (void)unused;
    enum { LOGS = 400 }; /* number of times that the equations of one log are added */
    static struct equations e;
    double size[BASIS_SIZE], square = 0.0;
    uint64_t seed = 11;
    memset(&e, 0, sizeof e);
    for (int k = 0; k < LEGS; k++) e.dry_n[k] = 100.0;
    for (int c = 0; c < UNKNOWNS; c++) e.product[c][c] = LOGS;
    for (int k = 0; k < LEGS; k++) {
        double *with = &e.with[UNKNOWN_BASIS + k * BASIS_SIZE], large_n = 50.0 * random_unit(&seed);
        with[3] = LOGS * large_n;
        square += large_n * large_n / LEGS;
        for (int i = 0; i < BASIS_SIZE; i++)
            if (i != 3)
                with[i] = sqrt(LOGS) * 0.5 * random_unit(&seed); /* these coefficients
                                                                          * are smaller than the
                                                                          * noise */
    }
    assert_true(basis_sizes_find(&e, e.product, size));
    for (int i = 0; i < BASIS_SIZE; i++)
        if (i == 3) assert_close(size[i], sqrt(square) / 100.0, 0.01 * size[i]);
        else assert_below(size[i], 1e-3 + 1e-9);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_leg_is_sure_of_its_direction_but_near_reversals),
                                       cmocka_unit_test(what_is_not_known_is_as_large_as_friction_is),
                                       cmocka_unit_test(the_last_basis_function_is_a_seal_that_gives_by_a_third_of_a_millimetre),
                                       cmocka_unit_test(sizes_are_those_of_the_coefficients)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
