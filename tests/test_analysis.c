/* Figures computed from a stream of cycles, also of a hostile log. */
#include "support.h"

#include <stdlib.h>

#include "analysis.h"
#include "config.h"
#include "gains.h"
#include "units.h"

static struct analysis a;
static struct params params;

static void take(uint64_t seq, int64_t wake_late_ns) {
    struct cycle c = {.seq = seq, .test = -1, .dof = DOF_NONE, .in.flags = SAMPLE_OVERRUN, .wake_late_ns = wake_late_ns};
    analysis_take(&a, &c);
}

static void sums_of_what_a_log_says_end_at_the_largest_number(void **unused) {
    (void)unused;
    struct error error;
    config_default(&params);
    assert_int_equal(analysis_init(&a, &params, &error), STATUS_OK);
    for (int i = 0; i < 4; i++) {
        take(0, INT64_MAX);
        take(UINT64_MAX, INT64_MAX);
        assert_true(a.lost == INT64_MAX && a.behind_ns > 0 && a.missed > 0);
    }
    for (int i = 0; i < 9; i++) take(UINT64_MAX, INT64_MIN);
    assert_true(a.lost == INT64_MAX);
    assert_true(isfinite(analysis_statistics(&a).pace));
    analysis_free(&a);
}

static void missing_cycles_are_counted(void **unused) {
    (void)unused;
    assert_int_equal(cycles_between(1, 2), 0);
    assert_int_equal(cycles_between(1, 5), 3);
    assert_true(cycles_between(0, UINT64_MAX) == INT64_MAX);
    assert_true(cycles_between(0, (uint64_t)INT64_MAX + 1) == INT64_MAX);
    assert_true(add_saturated(INT64_MIN, -1) == INT64_MIN && add_saturated(INT64_MAX, INT64_MAX) == INT64_MAX);
    assert_int_equal(add_saturated(-3, 5), 2);
}

/* Takes a cycle of the test of an axis, driven with this kp. */
static void test(enum dof dof, double kp) {
    struct cycle c = {.seq = (uint64_t)a.cycles + 1, .in.time_ns = a.cycles * 2000000, .test = (int)dof, .dof = dof};
    c.gains.value[GAIN_KP] = kp;
    analysis_take(&a, &c);
}

/* Returns true if the run is not evaluated because its tests had different gains. */
static bool mixes_gains(void) {
    const struct verdict run = analysis_verdicts(&a).run;
    for (int i = 0; i < run.reasons; i++)
        if (strstr(run.reason[i], "the gains were changed between its tests")) return run.status != VERDICT_PASS;
    return false;
}

static void tests_with_different_gains_are_not_one_result(void **unused) {
    (void)unused;
    struct error error;
    config_default(&params);
    assert_int_equal(analysis_init(&a, &params, &error), STATUS_OK);
    test(DOF_X, 40), test(DOF_Y, 40);
    assert_false(mixes_gains());
    test(DOF_Z, 45);
    assert_true(mixes_gains());
    test(DOF_X, 45), test(DOF_Y, 45); /* these tests replace the earlier ones */
    assert_false(mixes_gains());
    analysis_free(&a);
}

/* Legs at 3.92 Hz for stated 4 are 2 % slow, or the clock is 2 % fast, which makes masses 4 % too
 * large. Segments of other motions have no stated frequency. */
static void another_frequency_than_stated_is_noted(void **unused) {
    (void)unused;
    struct error error;
    config_default(&params);
    assert_int_equal(analysis_init(&a, &params, &error), STATUS_OK);
    struct recording *r = &a.measured.recording;
    static const double hz[] = {4.0, 3.92, (double)NAN, 3.92};
    r->tests = 4;
    for (int i = 0; i < r->tests; i++) r->test[i] = (struct recording_test){.dof = DOF_X + i, .frequency_hz = hz[i], .stated_hz = 4.0};
    r->test[3].segment_s = 1.0;
    const struct verdict run = analysis_verdicts(&a).run;
    assert_true(run.notes > 0);
    assert_non_null(strstr(run.note[run.notes - 1], "in test y the legs move at 3.92 Hz where 4 was stated: "));
    assert_non_null(strstr(run.note[run.notes - 1], "off by +4.1 %"));
    r->tests = 1;
    assert_int_equal(analysis_verdicts(&a).run.notes, run.notes - 1);
    r->tests = 0;
    analysis_free(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_of_what_a_log_says_end_at_the_largest_number),
        cmocka_unit_test(missing_cycles_are_counted),
        cmocka_unit_test(tests_with_different_gains_are_not_one_result),
        cmocka_unit_test(another_frequency_than_stated_is_noted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
