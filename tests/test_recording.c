/* A recording that contradicts its configuration is refused with the reason, because a plug in the
 * wrong socket is no physical effect. Missing samples are left out. */
#include "support.h"

#include <stdlib.h>

#include "controller.h"
#include "force.h"
#include "frequency.h"
#include "gap.h"
#include "admit_rig.h"
#include "gap_rig.h"
#include "reference_check.h"
#include "residual.h"
#include "sampling.h"
#include "units.h"

static struct params params;
static struct recording clean; /* six tests of the simulated platform */

static int set_up(void **unused) {
    (void)unused;
    struct error error;
    config_default(&params);
    return gap_rig(&params, &params, DOFS, &clean, &error);
}

static int tear_down(void **unused) {
    (void)unused;
    recording_free(&clean);
    return 0;
}

typedef void change(struct recording_sample *s);

static struct recording copy(void) {
    struct recording r = clean;
    for (int i = 0; i < r.tests; i++) {
        size_t size = (size_t)r.test[i].count * sizeof *r.test[i].sample;
        r.test[i].sample = malloc(size);
        memcpy(r.test[i].sample, clean.test[i].sample, size);
        r.test[i].measured = NULL;
    }
    return r;
}

static void alter(struct recording *r, change *what) {
    struct cylinder_areas areas = cylinder_areas(&params.actuator);
    for (int i = 0; i < r->tests; i++)
        for (int j = 0; j < r->test[i].count; j++) {
            struct recording_sample *s = &r->test[i].sample[j];
            what(s);
            for (int k = 0; k < LEGS; k++) s->force_n[k] = leg_force(&areas, k, s->p1_pa[k], s->p2_pa[k]);
        }
}

static void swap(double *x, int a, int b) {
    double kept = x[a];
    x[a] = x[b], x[b] = kept;
}

static void swap_lengths(struct recording_sample *s) { swap(s->length_m, 1, 3); }
static void swap_pressures(struct recording_sample *s) { swap(s->p1_pa, 1, 4), swap(s->p2_pa, 1, 4); }
static void swap_valves(struct recording_sample *s) { swap(s->valve, 0, 3); }
static void swap_legs(struct recording_sample *s) { swap_lengths(s), swap(s->p1_pa, 1, 3), swap(s->p2_pa, 1, 3), swap(s->valve, 1, 3); }
static void exchange_ports(struct recording_sample *s) {
    for (int k = 0; k < LEGS; k++) {
        double p1_pa = s->p1_pa[k];
        s->p1_pa[k] = s->p2_pa[k], s->p2_pa[k] = p1_pa;
    }
}
static void flip_valve(struct recording_sample *s) { s->valve[2] = -s->valve[2]; }
static void flip_length(struct recording_sample *s) { s->length_m[4] = 2.0 * 1.8310 - s->length_m[4]; }
static void millimetres(struct recording_sample *s) {
    for (int k = 0; k < LEGS; k++) s->length_m[k] *= 1e3;
}
static void bar(struct recording_sample *s) {
    for (int k = 0; k < LEGS; k++) s->p1_pa[k] *= 1e-5, s->p2_pa[k] *= 1e-5;
}
static void double_motion(struct recording_sample *s) {
    for (int k = 0; k < LEGS; k++) s->length_m[k] = 1.8310 + 2.5 * (s->length_m[k] - 1.8310);
}
static void zero_valve(struct recording_sample *s) { s->valve[3] = 0.0; }
static void dead_pressure(struct recording_sample *s) { s->p2_pa[5] = 0.0; }
static void clip(struct recording_sample *s) {
    for (int k = 0; k < LEGS; k++) s->p2_pa[k] = fmin(2.5 * s->p2_pa[k], 16e6);
}
static void clip_softly(struct recording_sample *s) { s->p1_pa[2] = fmin(s->p1_pa[2], 3.35e6); }
static void stop_short(struct recording_sample *s) { s->length_m[0] = fmax(s->length_m[0], 1.8305); }
static void percent(struct recording_sample *s) {
    for (int k = 0; k < LEGS; k++) s->valve[k] *= 100.0;
}
static void pump_up(struct recording_sample *s) {
    for (int k = 0; k < LEGS; k++) s->p1_pa[k] += 7e6 * 0.0020 / 0.0045, s->p2_pa[k] += 7e6;
}
static void one_absurd(struct recording_sample *s) {
    if (fabs(s->test_time_s - 2.0) < 1e-6) s->p1_pa[0] = 1e300;
}
static void mostly_nothing(struct recording_sample *s) {
    if (fmod(s->test_time_s, 0.01) > 0.003) s->p1_pa[0] = NAN;
}

static void recordings_that_lie_are_refused_for_what_they_are(void **unused) {
    (void)unused;
    slow_case();
    static const struct {
        change *change;
        bool reference;
        const char *says;
    } lies[] = {
        {swap_lengths, true, "exchanged"},
        {swap_lengths, false, "exchanged"},
        {swap_pressures, true, "pressures: legs 2 and 5 exchanged"},
        {swap_valves, true, "valve command of leg 1"},
        {swap_legs, true, "exchanged"},
        {swap_legs, false, "exchanged"},
        {exchange_ports, true, "p1 and p2"},
        {flip_valve, true, "valve command of leg 3"},
        {flip_length, true, "length of leg 5"},
        {flip_length, false, "length of leg 5"},
        {millimetres, true, "other units"},
        {bar, true, "other units"},
        {double_motion, true, "times as far"},
        {zero_valve, true, "valve command of leg 4 does not change"},
        {dead_pressure, true, "p2 of leg 6 does not change"},
        {clip, true, "clipped"},
        {clip_softly, true, "p1 of leg 3 is clipped"},
        {stop_short, true, "length of leg 1 is clipped"},
        {percent, true, "percent"},
        {pump_up, true, "another supply"},
        {one_absurd, true, "1e+300"},
        {mostly_nothing, true, "half of its samples"},
    };
    for (size_t n = 0; n < sizeof lies / sizeof *lies; n++) {
        struct error error = {0};
        struct recording r = copy();
        alter(&r, lies[n].change);
        r.measured.reference = lies[n].reference;
        int status = admit_rig(&r, false, &error);
        recording_free(&r);
        if (status != STATUS_USAGE || !strstr(error.text, lies[n].says))
            fail_msg("%d: \"%s\" does not say \"%s\"", (int)n, error.text, lies[n].says);
    }
}

static void rest_and_flip(struct recording_sample *s) {
    s->length_m[1] = 0.0;
    flip_length(s);
}

/* A leg at rest tells nothing of itself, but hides no error of another leg. */
static void a_leg_at_rest_does_not_hide_another(void **unused) {
    (void)unused;
    slow_case();
    struct error error = {0};
    struct recording r = copy();
    struct kinematics k;
    assert_int_equal(kinematics_init(&k, &params, &error), STATUS_OK);
    assert_int_equal(admit_rig(&r, false, &error), STATUS_OK);
    alter(&r, rest_and_flip);
    assert_int_equal(reference_check(&r, &k, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "leg 5 moves against its reference"));
    recording_free(&r);
}

/* Returns all six tests one after the other, as one recording of any motion. */
static struct recording in_a_row(void) {
    struct recording r;
    struct error error;
    double begin_s = 0.0;
    recording_init(&r, &params);
    r.measured = clean.measured;
    r.test[r.tests++] = (struct recording_test){.dof = DOF_NONE, .frequency_hz = (double)NAN, .stated_hz = (double)NAN};
    for (int i = 0; i < clean.tests; i++) {
        const struct recording_test *t = &clean.test[i];
        for (int j = 0; j < t->count; j++) {
            struct recording_sample s = t->sample[j];
            s.test_time_s += begin_s;
            assert_int_equal(recording_append(&r.test[0], &s, &error), STATUS_OK);
        }
        begin_s += t->sample[t->count - 1].test_time_s + params.loop.period_s;
    }
    r.test[0].end = r.test[0].count;
    return r;
}

/* For a third of the time the legs move in the direction opposite to the reference, but overall
 * they follow it. */
static void a_reference_is_judged_by_the_whole_record(void **unused) {
    (void)unused;
    slow_case();
    for (int all = 0; all < 2; all++) {
        struct error error = {0};
        struct recording r = in_a_row();
        for (int i = 0; i < r.test[0].count; i++)
            for (int dof = 0; dof < DOFS && (all || i < r.test[0].count / 3); dof++) r.test[0].sample[i].ref[dof] *= -1.0;
        int status = admit_rig(&r, false, &error);
        assert_true(r.tests > 6);
        if (!all && status) fail_msg("%s", error.text);
        if (all) assert_non_null(strstr(error.text, "all legs move against the reference"));
        recording_free(&r);
    }
}

static void another_rate_than_the_controllers_is_seen(void **unused) {
    (void)unused;
    static struct params slower;
    slower = params;
    slower.loop.period_s = 2.0 * params.loop.period_s;
    assert_true(controller_other_rate(&params, &clean) == 0.0);
    assert_close(controller_other_rate(&slower, &clean), params.loop.period_s, 1e-9);
    assert_true(isfinite(controller_difference(&params, &clean)) && isnan(controller_difference(&slower, &clean)));
}

static void another_machine_is_refused(void **unused) {
    (void)unused;
    slow_case();
    static struct params other;
    struct error error = {0};
    for (int i = 0; i < 3; i++) {
        struct recording r = copy();
        other = params;
        if (i == 0) other.geometry.height_m = 1.75;
        if (i == 1) other.payload.mass_kg = 4000.0;
        if (i == 2) all_legs(other.actuator.piston_diameter_m, 0.2);
        r.params = &other;
        /* forces that this cylinder would have at these pressures */
        for (int n = 0; i == 2 && n < r.tests; n++)
            for (int j = 0; j < r.test[n].count; j++)
                for (int k = 0; k < LEGS; k++) {
                    struct cylinder_areas areas = cylinder_areas(&other.actuator);
                    struct recording_sample *s = &r.test[n].sample[j];
                    s->force_n[k] = leg_force(&areas, k, s->p1_pa[k], s->p2_pa[k]);
                }
        assert_int_equal(admit_rig(&r, false, &error), STATUS_USAGE);
        if (!strstr(error.text, "machine")) fail_msg("%d: %s", i, error.text);
        recording_free(&r);
    }
}

static void stand_still(struct recording *r) {
    for (int i = 0; i < r->tests; i++)
        for (int j = 0; j < r->test[i].count; j++) r->test[i].sample[j].clock_s = 3.0;
}

static void stamps_that_stand_still_are_no_clock(void **unused) {
    (void)unused;
    struct recording r = copy();
    double std;
    assert_true(fabs(recording_clock(&r, &std) - 1.0) < 1e-6); /* tolerance: time stamps are whole
                                                                * nanoseconds */
    stand_still(&r);
    assert_true(isnan(recording_clock(&r, &std)));
    recording_free(&r);
}

/* The recording is played faster: 4 Hz become 4.125 Hz, halfway between two frequencies of the
 * search. */
static void any_frequency_that_the_configuration_states_is_accepted(void **unused) {
    (void)unused;
    struct error error = {0};
    struct recording r = copy();
    for (int i = 0; i < r.tests; i++) {
        r.test[i].frequency_hz = r.test[i].stated_hz = 4.125;
        for (int j = 0; j < r.test[i].count; j++) r.test[i].sample[j].test_time_s *= 4.0 / 4.125;
    }
    if (admit_rig(&r, false, &error)) fail_msg("%s", error.text);
    recording_free(&r);
}

/* A frequency that a file states is measured before it is used. */
static void a_stated_frequency_that_is_off_is_corrected(void **unused) {
    (void)unused;
    numbers_case();
    static const double off[] = {1e-3, -0.01, 0.05, -0.09, 0.3, -0.5};
    for (size_t n = 0; n < sizeof off / sizeof *off; n++) {
        struct error error = {0};
        struct recording r = copy();
        for (int i = 0; i < r.tests; i++)
            for (int j = 0; j < r.test[i].count; j++) r.test[i].sample[j].test_time_s /= 1.0 + off[n];
        if (admit_rig(&r, false, &error)) fail_msg("%s", error.text);
        for (int i = 0; i < r.tests; i++) assert_close(r.test[i].frequency_hz, 4.0 * (1.0 + off[n]), 1e-4);
        recording_free(&r);
    }
}

/* If a loop settles throughout a test, its phase drifts without a change of frequency. The
 * reference shows that; without a reference, the second half of the test does. */
static void legs_that_settle_move_at_the_frequency_of_the_reference(void **unused) {
    (void)unused;
    const double turned_rad = 0.3, settled_s = 1.0, most_off[] = {2e-4, 1e-9};
    for (int reference = 0; reference < 2; reference++) {
        struct recording r = copy();
        r.measured.reference = reference;
        for (int i = 0; i < r.tests; i++)
            for (int j = 0; j < r.test[i].count; j++) {
                struct recording_sample *s = &r.test[i].sample[j];
                double w = 2.0 * PI * r.test[i].frequency_hz, late = turned_rad * exp(-s->test_time_s / settled_s);
                for (int k = 0; k < LEGS; k++) s->length_m[k] = 1.8 + 4e-3 * sin(w * s->test_time_s + k - late);
                s->ref[r.test[i].dof] = r.test[i].amplitude * sin(w * s->test_time_s);
            }
        for (int i = 0; i < r.tests; i++) {
            const struct recording_test *t = &r.test[i];
            assert_close(frequency_fit(t, LEGS, reference, 4.0), 4.0, 4.0 * most_off[reference]);
        }
        recording_free(&r);
    }
}

static void a_bad_first_sample_hides_no_frequency(void **unused) {
    (void)unused;
    slow_case();
    struct error error = {0};
    struct recording r = copy();
    for (int i = 0; i < r.tests; i++) {
        for (int j = 0; j < r.test[i].count; j++) r.test[i].sample[j].test_time_s /= 1.3;
        for (int k = 0; k < LEGS; k++) r.test[i].sample[r.test[i].first].length_m[k] = (double)NAN;
        r.test[i].sample[r.test[i].first].refused = REFUSED_LATE;
    }
    if (admit_rig(&r, false, &error)) fail_msg("%s", error.text);
    for (int i = 0; i < r.tests; i++) assert_close(r.test[i].frequency_hz, 5.2, 1e-4);
    recording_free(&r);
}

static void what_is_as_it_should_be_is_accepted(void **unused) {
    (void)unused;
    struct error error;
    for (int lacking = 0; lacking < 3; lacking++) {
        struct recording r = copy();
        if (lacking == 1) r.measured.reference = false;
        if (lacking == 2) r.measured.valve = false;
        if (admit_rig(&r, false, &error)) fail_msg("%s", error.text);
        recording_free(&r);
    }
}

/* Without commands the chambers are not evaluated, and an effect that shows only in them is not
 * named. */
static void without_commands_forces_alone_are_explained(void **unused) {
    (void)unused;
    slow_case();
    static struct gap_result g;
    struct error error;
    struct gap_options options = {.replay = GAP_CLOSED_LOOP, .simulate = true, .threads = 2};
    struct recording r = copy();
    r.measured.valve = false;
    assert_int_equal(admit_rig(&r, false, &error), STATUS_OK);
    assert_int_equal(gap_solve(&params, &r, NULL, &options, &g, NULL, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "valve commands"));
    options.replay = GAP_AS_KNOWN;
    if (gap_solve(&params, &r, NULL, &options, &g, NULL, &error)) fail_msg("%s", error.text);
    assert_int_equal(g.replay, GAP_MOTION);
    assert_int_equal(g.verdict, GAP_NO_GAP);
    assert_true(isnan(g.noise_floor.channel[GAP_P1]) && isfinite(g.noise_floor.channel[GAP_FORCE]));
    for (int i = 0; i < g.candidates; i++) assert_string_not_equal(effect_table[g.candidate[i].effect]->name, "internal_leakage");
    recording_free(&r);
}

/* One row in a hundred is lost: cycles that lack more than a tenth do not count, and the sampling
 * period is taken between the gaps. */
static void lost_samples_do_not_change_the_sampling(void **unused) {
    (void)unused;
    struct error error;
    struct recording r = copy();
    for (int i = 0; i < r.tests; i++) {
        struct recording_test *t = &r.test[i];
        int kept = 0, first = t->first, end = t->end;
        for (int j = 0; j < t->count; j++) {
            if (j == first) t->first = kept;
            if (j == end) t->end = kept;
            if (j % 100 != 50 && (j < first + 700 || j >= first + 900)) t->sample[kept++] = t->sample[j];
        }
        t->count = kept;
        if (end > kept) t->end = kept;
        assert_close(sampling_step_s(t, t->first, t->end), 0.002, 1e-9);
    }
    if (admit_rig(&r, false, &error)) fail_msg("%s", error.text);
    struct spectrum whole, gaps;
    static spectrum_cycle room[CYCLES_MAX];
    assert_true(spectrum_measure(&whole, room, &clean.test[0], sampling_step_s(&clean.test[0], clean.test[0].first, clean.test[0].end),
                                 CYCLES_ALL) &&
                spectrum_measure(&gaps, room, &r.test[0], sampling_step_s(&r.test[0], r.test[0].first, r.test[0].end), CYCLES_ALL));
    assert_true(gaps.cycles < whole.cycles && gaps.cycles >= whole.cycles - 3);
    for (int k = 0; k < LEGS; k++)
        for (int a = 1; a < 5; a++) /* tolerance: the sensor's step, divided by the root of the
                                     * number of samples */
            assert_close(gaps.mean[CHANNEL_LENGTH][k][a], whole.mean[CHANNEL_LENGTH][k][a], 50e-6 / sqrt(2000.0) * 5.0);
    recording_free(&r);
}

/* The second run has z again at half the frequency, after six tests of the first. */
static void a_second_run_has_tests_of_its_own(void **unused) {
    (void)unused;
    slow_case();
    struct error error;
    struct recording like, r;
    struct test_params second = params.tests;
    second.hz[DOF_Z] *= 0.5, second.amplitude[DOF_Z] *= 2.0;
    recording_init(&like, &params);
    assert_int_equal(recording_begin(&like, &second, &error), STATUS_OK);
    for (int i = 0; i < DOFS; i++) like.test[like.tests++] = (struct recording_test){.test = i, .dof = (enum dof)i, .first = -1};
    like.test[like.tests++] = (struct recording_test){.run = 1, .test = DOFS, .dof = DOF_Z, .first = -1};
    if (replay_closed_loop(&params, &like, &r, &error)) fail_msg("%s", error.text);
    const struct recording_test *last = &r.test[DOFS];
    assert_int_equal(r.runs, 2);
    assert_int_equal(r.tests, DOFS + 1);
    assert_true(last->run == 1 && last->test == DOFS && last->dof == DOF_Z);
    assert_true(last->frequency_hz == second.hz[DOF_Z] && last->amplitude == second.amplitude[DOF_Z]);
    /* the legs move at the frequency of their run, not of the model */
    if (admit_rig(&r, false, &error)) fail_msg("%s", error.text);
    double first_mt[DOFS][DOFS], both_mt[DOFS][DOFS];
    assert_true(replay_identify(&params, &clean, first_mt) && replay_identify(&params, &r, both_mt));
    for (int i = 0; i < DOFS; i++) /* the matrix is from the first run alone */
        for (int j = 0; j < DOFS; j++) assert_close(both_mt[i][j], first_mt[i][j], 1e-9 * fabs(first_mt[i][i]));
    recording_free(&r);
}

/* At any rate the number of samples that are kept is limited, and each quarter of the recording
 * contributes. */
static void a_long_recording_is_kept_from_all_over_it(void **unused) {
    (void)unused;
    slow_case();
    enum { MOST = 400000, ROWS = 6 * MOST - 1, QUARTERS = 4 };
    static const double rates_hz[] = {200.0, 5000.0, 10000.0, HUGE_VAL}; /* a clock that jumps */
    for (size_t n = 0; n < sizeof rates_hz / sizeof *rates_hz; n++) {
        struct error error;
        struct recording r;
        int in_quarter[QUARTERS] = {0}, most = 0;
        recording_init(&r, &params);
        for (int i = 0; i < ROWS; i++) {
            struct cycle c = {.test = 0, .dof = DOF_NONE, .test_time_s = i / rates_hz[n]};
            if (!isfinite(rates_hz[n])) c.test_time_s = i < MOST - 1 ? 1e-9 * i : 1e6 + i;
            assert_int_equal(recording_add(&r, &c, &error), STATUS_OK);
            if (r.test[0].count > most) most = r.test[0].count;
        }
        const struct recording_test *t = &r.test[0];
        assert_int_equal(r.tests, 1);
        assert_in_range(most, MOST / 2, MOST);
        assert_true(t->first == 0 && t->end == t->count);
        for (int i = 0; i < t->count && isfinite(rates_hz[n]); i++)
            in_quarter[(int)(t->sample[i].test_time_s * rates_hz[n] * QUARTERS / ROWS)]++;
        for (int i = 0; i < QUARTERS && isfinite(rates_hz[n]); i++)
            if (in_quarter[i] < MOST / 32) fail_msg("%g Hz: %d samples of quarter %d", rates_hz[n], in_quarter[i], i + 1);
        recording_free(&r);
    }
}

static void more_runs_than_there_is_room_for_are_refused(void **unused) {
    (void)unused;
    struct error error;
    struct recording r;
    recording_init(&r, &params);
    for (int run = 1; run < RECORDING_RUNS; run++) assert_int_equal(recording_begin(&r, &params.tests, &error), STATUS_OK);
    assert_int_equal(recording_begin(&r, &params.tests, &error), STATUS_USAGE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(recordings_that_lie_are_refused_for_what_they_are),
        cmocka_unit_test(a_leg_at_rest_does_not_hide_another),
        cmocka_unit_test(a_reference_is_judged_by_the_whole_record),
        cmocka_unit_test(another_rate_than_the_controllers_is_seen),
        cmocka_unit_test(another_machine_is_refused),
        cmocka_unit_test(a_stated_frequency_that_is_off_is_corrected),
        cmocka_unit_test(legs_that_settle_move_at_the_frequency_of_the_reference),
        cmocka_unit_test(a_bad_first_sample_hides_no_frequency),
        cmocka_unit_test(what_is_as_it_should_be_is_accepted),
        cmocka_unit_test(stamps_that_stand_still_are_no_clock),
        cmocka_unit_test(any_frequency_that_the_configuration_states_is_accepted),
        cmocka_unit_test(without_commands_forces_alone_are_explained),
        cmocka_unit_test(lost_samples_do_not_change_the_sampling),
        cmocka_unit_test(a_second_run_has_tests_of_its_own),
        cmocka_unit_test(a_long_recording_is_kept_from_all_over_it),
        cmocka_unit_test(more_runs_than_there_is_room_for_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
