/* Each quantity of a recording is measured once, however many stages read it. The linker puts
 * these counters between the callers and the functions that measure (--wrap, Makefile). */
#include "support.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "gap.h"
#include "gap_rig.h"
#include "sampling.h"
#include "admit_rig.h"
#include "waves.h"

static struct params params;
static struct recording recording;
static atomic_int spectra, segments, steps;

bool __real_spectrum_measure(struct spectrum *s, spectrum_cycle room[CYCLES_MAX], const struct recording_test *test, double step_s,
                             enum cycles which);
bool __wrap_spectrum_measure(struct spectrum *s, spectrum_cycle room[CYCLES_MAX], const struct recording_test *test, double step_s,
                             enum cycles which);
bool __wrap_spectrum_measure(struct spectrum *s, spectrum_cycle room[CYCLES_MAX], const struct recording_test *test, double step_s,
                             enum cycles which) {
    spectra++;
    return __real_spectrum_measure(s, room, test, step_s, which);
}

bool __real_spectrum_cut(struct spectrum *s, const struct recording_test *test, double from_s, double until_s, double omega,
                         double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]);
bool __wrap_spectrum_cut(struct spectrum *s, const struct recording_test *test, double from_s, double until_s, double omega,
                         double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]);
bool __wrap_spectrum_cut(struct spectrum *s, const struct recording_test *test, double from_s, double until_s, double omega,
                         double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]) {
    segments++;
    return __real_spectrum_cut(s, test, from_s, until_s, omega, inverse);
}

double __real_sampling_step_s(const struct recording_test *t, int first, int end);
double __wrap_sampling_step_s(const struct recording_test *t, int first, int end);
double __wrap_sampling_step_s(const struct recording_test *t, int first, int end) {
    steps++;
    return __real_sampling_step_s(t, first, end);
}

/* Records some axes, and sets the counters to zero afterwards. */
static void record(int axes) {
    struct error error;
    config_default(&params);
    params.tests.duration_s = 2.0;
    if (gap_rig(&params, &params, axes, &recording, &error)) fail_msg("%s", error.text);
    spectra = segments = steps = 0;
}

/* Goes through all stages of `hexid gap`, pictures included. Returns the number of simulated
 * tests. */
static int diagnose(enum gap_replay replay) {
    static struct gap_result result;
    struct waves closed_loop = {0}, motion;
    struct error error;
    const struct gap_options options = {.replay = replay, .simulate = true, .threads = 1};
    if (admit_rig(&recording, true, &error) || gap_solve(&params, &recording, NULL, &options, &result, &closed_loop, &error) ||
        waves_motion(&motion, &result, &recording, &error))
        fail_msg("%s", error.text);
    int simulated = closed_loop.tests;
    assert_int_equal(result.verdict, GAP_NO_GAP);
    waves_free(&closed_loop);
    waves_free(&motion);
    recording_free(&recording);
    return simulated;
}

static void a_test_has_three_spectra_and_one_step(void **unused) {
    (void)unused;
    slow_case();
    record(1);
    assert_int_equal(diagnose(GAP_MOTION), 0);
    assert_int_equal(spectra, 3);
    assert_int_equal(steps, 1);
    assert_int_equal(segments, 0);
}

static void a_simulated_test_has_no_more(void **unused) {
    (void)unused;
    slow_case();
    record(2);
    assert_int_equal(diagnose(GAP_CLOSED_LOOP), 2);
    assert_int_equal(spectra, 3 * (2 + 2));
    assert_int_equal(steps, 2 + 2);
}

static void the_raw_recording_stays_as_it_was(void **unused) {
    (void)unused;
    static struct recording before;
    static struct measured_recording measured;
    struct admission admission = {0};
    struct error error;
    record(1);
    recording.test[0].dof = DOF_NONE;
    recording_settle(&recording);
    before = recording;
    const struct recording_test *t = &recording.test[0];
    size_t size = (size_t)t->count * sizeof *t->sample;
    struct recording_sample *sample = malloc(size);
    assert_non_null(sample);
    memcpy(sample, t->sample, size);
    if (measured_add(&measured, &recording, &error) || admit(&recording, &measured, &admission, &error)) fail_msg("%s", error.text);
    assert_true(measured.recording.tests > 1 && !measured.record[0].sinusoid);
    assert_memory_equal(&before, &recording, sizeof before);
    assert_memory_equal(sample, t->sample, size);
    free(sample);
    measured_free(&measured);
    recording_free(&recording);
}

/* The step of the whole record, before it is cut, is one more. */
static void a_segment_has_one_spectrum_and_one_step(void **unused) {
    (void)unused;
    struct residual_data data[2];
    struct error error;
    record(1);
    recording.test[0].dof = DOF_NONE;
    if (admit_rig(&recording, true, &error) || residual_prepare(&data[0], &recording, CYCLES_EVEN, &error) ||
        residual_prepare(&data[1], &recording, CYCLES_ODD, &error))
        fail_msg("%s", error.text);
    assert_true(data[0].tests > 2 && data[1].tests > 2);
    assert_int_equal(segments, recording.tests);
    assert_int_equal(steps, recording.tests + 1);
    assert_int_equal(spectra, 0);
    residual_free(&data[0]), residual_free(&data[1]);
    recording_free(&recording);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_test_has_three_spectra_and_one_step),
        cmocka_unit_test(a_simulated_test_has_no_more),
        cmocka_unit_test(the_raw_recording_stays_as_it_was),
        cmocka_unit_test(a_segment_has_one_spectrum_and_one_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
