/* Identification: recovers the matrices of a known machine from synthetic cycles; handles flagged,
 * lost and repeated data. */
#include "ident_rig.h"

static void method_a_recovers_inertia_and_damping_of_a_known_machine(void **unused) {
    (void)unused;
    struct rig *r = rig_create(1, 5);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_true(ident_solve(id));
    const struct method_result *a = &id->result.method_a;
    /* Tolerance: forward kinematics stops at 1e-13 m of 4 mm, a relative error of 2.5e-11, which is
     * not averaged. It is multiplied by the largest entries, up to friction of 10 N s/mm, divided
     * by w = 25. */
    assert_below(distance(&a->mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-9 * 272);
    assert_below(distance(&a->bt[0][0], &r->bt[0][0], DOFS * DOFS), 1e-9 * 272 * omega(r, 0));
    for (int i = 0; i < DOFS; i++)
        assert_true(a->bt[i][i] > 0); /* damping is positive, so the sign
                                                                  * of Q is right */
    assert_true(a->condition_number > 1 && a->condition_number < 1.5);
}

static void each_axis_has_a_frequency_of_its_own(void **unused) {
    (void)unused;
    struct rig *r = rig_create(1, 5);
    for (int d = 0; d < DOFS; d++) r->params.tests.hz[d] = 2.0 + 0.7 * d, r->params.tests.amplitude[d] *= 1.0 - 0.1 * d;
    rig_record(r); /* motion amplitudes unchanged */
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_true(ident_solve(id));
    /* tolerance as above, times (4 Hz / 2 Hz)^2 */
    assert_below(distance(&id->result.method_a.mt[0][0], &r->mt[0][0], DOFS * DOFS), 4e-9 * 272);
    for (int d = 0; d < DOFS; d++) {
        const struct test_result *t = &id->result.test[d];
        assert_true(t->frequency_hz == 2.0 + 0.7 * d && t->amplitude == r->params.tests.amplitude[d]);
        assert_close(t->achieved_amplitude, hypot(r->pose[d][d][0][0], r->pose[d][d][0][1]), 1e-9 * t->amplitude);
    }
}

static void fundamentals_are_those_of_the_motion(void **unused) {
    (void)unused;
    struct rig *r = rig_create(2, 5);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_int_equal(id->result.tests, DOFS);
    for (int d = 0; d < DOFS; d++) {
        const struct test_result *t = &id->result.test[d];
        const double *own = r->pose[d][d][0];
        assert_true(t->test == d && (int)t->dof == d && !t->refused && t->samples == r->samples && t->excluded == 0);
        for (int i = 0; i < DOFS; i++) {
            double share = 100 * hypot(r->pose[d][i][0][0], r->pose[d][i][0][1]) / amplitude(r, i);
            assert_close(t->unwanted_pct[i], i == d ? 0 : share, 1e-7);
            assert_below(distance(t->pose[i], r->pose[d][i][0], 2), 1e-12);
        }
        assert_close(t->achieved_amplitude, hypot(own[0], own[1]), 1e-12);
        assert_close(t->phase_deg, deg_from_rad(atan2(own[1], own[0])), 1e-7);
        assert_true(t->amplitude == amplitude(r, d) && t->frequency_hz == r->params.tests.hz[d]);
    }
}

/* An imported log may be evaluated with a configuration that states other amplitudes than its
 * tests had. The reference is the truth; without one only the configured amplitude is left. */
static void unwanted_motion_is_relative_to_the_recorded_amplitude(void **unused) {
    (void)unused;
    for (int recorded = 0; recorded < 2; recorded++) {
        struct rig *r = rig_create(2, 5);
        double driven = amplitude(r, DOF_THETA);
        r->params.tests.amplitude[DOF_THETA] *= 0.375;
        for (int i = 0; i < r->samples; i++) {
            struct cycle *c = &r->cycle[DOF_THETA][i];
            c->ref[DOF_THETA] = recorded ? driven * sin(omega(r, DOF_THETA) * c->test_time_s) : (double)NAN;
        }
        struct ident *id = ident_create(r);
        feed_all(id, r);
        double expected = recorded ? driven : amplitude(r, DOF_THETA);
        double share = 100 * hypot(r->pose[DOF_X][DOF_THETA][0][0], r->pose[DOF_X][DOF_THETA][0][1]) / expected;
        assert_close(id->result.test[DOF_X].unwanted_pct[DOF_THETA], share, 1e-3 * share);
    }
}

static void order_of_the_tests_changes_no_bit(void **unused) {
    (void)unused;
    static const int order[DOFS] = {4, 2, 0, 5, 1, 3};
    struct rig *r = rig_create(3, 1);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_true(ident_solve(id));
    struct identification first = id->result;
    id = ident_create(r);
    for (int d = 0; d < DOFS; d++) feed_part(id, r, order[d], 0, r->samples);
    assert_true(ident_end(id));
    assert_true(ident_solve(id));
    assert_int_equal(id->result.test[0].dof, DOF_THETA);
    assert_memory_equal(&id->result.method_a, &first.method_a, sizeof first.method_a);
    assert_memory_equal(&id->result.method_b, &first.method_b, sizeof first.method_b);
}

static void what_came_before_the_evaluated_part_changes_no_bit(void **unused) {
    (void)unused;
    struct rig *r = rig_create(4, 1);
    struct ident *id = ident_create(r);
    feed_part(id, r, 0, 0, r->samples);
    assert_true(ident_end(id));
    struct test_result alone = *last_result(id);
    id = ident_create(r);
    feed_part(id, r, 3, 0, 100);
    for (int i = 0; i < 50; i++) {
        struct cycle settling = r->cycle[5][i];
        settling.phase = i < 25 ? PHASE_SETTLE : PHASE_RAMP_IN;
        ident_feed(id, &settling);
    }
    feed_part(id, r, 0, 0, r->samples);
    assert_true(ident_feed(id, &ramp_out));
    assert_memory_equal(last_result(id), &alone, sizeof alone);
}

/* Flagged samples contain nonsense here, so that the use of a single one would show. */
static void excluded_samples_are_counted_and_never_used(void **unused) {
    (void)unused;
    static const uint32_t flags[] = {SAMPLE_STALE, SAMPLE_LATE, SAMPLE_DROPPED, SAMPLE_INVALID, SAMPLE_OVERRUN, SAMPLE_IO, SAMPLE_FOREIGN};
    struct rig *r = rig_create(5, 1);
    struct ident *id = ident_create(r);
    uint64_t state = 9;
    for (int d = 0; d < DOFS; d++) {
        int excluded = 0;
        for (int i = 0; i < r->samples; i++) {
            struct cycle *c = &r->cycle[d][i];
            int what = random_below(&state, 30);
            if (what < 7) c->in.flags = flags[what], c->in.length_m[what % LEGS] += 0.001, c->in.p1_pa[what % LEGS] *= 2;
            if (what == 7) c->in.length_m[d] = (double)NAN;
            if (what == 8) c->in.p2_pa[d] = (double)INFINITY;
            /* impossible lengths: forward kinematics does not converge */
            if (what == 9) c->in.length_m[d] = 9;
            excluded += what <= 9;
            ident_feed(id, c);
            enum refusal why = what < 7 ? refusal_of(c, LEGS) : what < 9 ? REFUSED_NO_NUMBER : what == 9 ? REFUSED_NO_POSE : REFUSED_NOT;
            assert_int_equal(id->refused, why);
        }
        ident_end(id);
        assert_true(excluded > 50);
        assert_int_equal(last_result(id)->excluded, excluded);
        assert_int_equal(last_result(id)->samples, r->samples - excluded);
        assert_false(last_result(id)->refused);
    }
    assert_true(ident_solve(id));
    assert_below(distance(&id->result.method_a.mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-9 * 272);
}

/* Legs are compared with the reference in the record. If the record has no reference, they are not
 * compared. */
static void a_leg_that_is_off_its_reference_is_found(void **unused) {
    (void)unused;
    static const double further_m = 4e-3;
    struct rig *r = rig_create(4, 5);
    double off_m[2];
    for (int i = 0; i < r->samples; i++) {
        r->cycle[0][i].in.length_m[2] -= 20e-3; /* far more than the rig's poses differ from the
                                                 * reference by themselves */
        r->cycle[1][i].in.length_m[2] -= 20e-3;
        r->cycle[1][i].ref[DOF_PSI] = (double)NAN;
    }
    for (int k = 0; k < 2; k++) {
        struct ident *id = ident_create(r);
        feed_all(id, r);
        assert_int_equal(id->result.test[0].off_leg, 2);
        assert_true(id->result.test[1].off_m == 0.0);
        off_m[k] = id->result.test[0].off_m;
        for (int i = 0; i < r->samples; i++) r->cycle[0][i].in.length_m[2] -= further_m;
    }
    assert_close(off_m[1] - off_m[0], -further_m, 1e-9);
}

static void a_test_ends_with_its_evaluated_part(void **unused) {
    (void)unused;
    struct rig *r = rig_create(6, 1);
    struct ident *id = ident_create(r);
    assert_false(ident_end(id));
    assert_false(ident_feed(id, &ramp_out));
    assert_false(feed_part(id, r, 0, 0, r->samples));
    assert_true(ident_feed(id, &ramp_out));
    assert_false(ident_feed(id, &ramp_out));
    assert_false(feed_part(id, r, 1, 0, r->samples));
    assert_true(ident_feed(id, &r->cycle[2][0])); /* the next test begins without a pause */
    assert_int_equal(id->result.tests, 2);
    assert_false(last_result(id)->refused);
}

static void a_test_cut_short_is_not_complete_and_no_method_uses_it(void **unused) {
    (void)unused;
    struct rig *r = rig_create(7, 1);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_true(ident_solve(id));
    feed_part(id, r, 2, 0, r->samples - 5);
    assert_true(ident_feed(id, &ramp_out));
    assert_int_equal(last_result(id)->refused, REFUSED_INCOMPLETE);
    assert_int_equal(last_result(id)->samples, r->samples - 5);
    assert_false(ident_solve(id));
    assert_false(id->result.method_a.evaluated || id->result.modified_a.evaluated || id->result.method_b.evaluated);
}

static void a_test_without_a_usable_sample_is_not_complete(void **unused) {
    (void)unused;
    struct rig *r = rig_create(8, 1);
    struct ident *id = ident_create(r);
    for (int i = 0; i < r->samples; i++) r->cycle[0][i].in.flags = SAMPLE_LATE;
    feed_part(id, r, 0, 0, r->samples);
    assert_true(ident_end(id));
    assert_int_equal(last_result(id)->refused, REFUSED_UNDETERMINED);
    assert_int_equal(last_result(id)->samples, 0);
    assert_true(isnan(last_result(id)->achieved_amplitude));
}

/* Data of another program: every second sample is missing, so the rate is not the
 * configuration's. */
static void a_slower_rate_is_complete_too(void **unused) {
    (void)unused;
    struct rig *r = rig_create(9, 5);
    struct ident *id = ident_create(r);
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < r->samples; i += 2) ident_feed(id, &r->cycle[d][i]);
    ident_end(id);
    for (int d = 0; d < DOFS; d++) assert_false(id->result.test[d].refused);
    assert_true(ident_solve(id));
    assert_below(distance(&id->result.method_a.mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-9 * 272);
}

static void a_repeated_test_replaces_the_earlier_one(void **unused) {
    (void)unused;
    struct rig *r = rig_create(10, 1);
    struct ident *id = ident_create(r);
    for (int i = 0; i < r->samples; i++) { /* first, phi is tested with a wrong amplitude */
        struct cycle wrong = r->cycle[0][i];
        wrong.test = 3;
        wrong.dof = DOF_PHI;
        ident_feed(id, &wrong);
    }
    feed_all(id, r);
    assert_int_equal(id->result.tests, DOFS);
    assert_int_equal(last_result(id)->dof, DOF_PSI);
    assert_true(ident_solve(id));
    assert_below(distance(&id->result.method_a.mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-9 * 272);
    feed_part(id, r, 0, 0, r->samples);
    ident_end(id);
    assert_int_equal(id->result.tests, DOFS);
    assert_int_equal(last_result(id)->dof, DOF_X);
    assert_int_equal(id->result.replaced[DOF_X], 1);
    assert_int_equal(id->result.replaced[DOF_PHI], 1);
    assert_int_equal(id->result.replaced[DOF_Z], 0);
}

static void without_all_six_axes_no_method_is_evaluated(void **unused) {
    (void)unused;
    struct rig *r = rig_create(11, 1);
    for (int missing = 0; missing < DOFS; missing++) {
        struct ident *id = ident_create(r);
        for (int d = 0; d < DOFS; d++)
            if (d != missing) feed_part(id, r, d, 0, r->samples);
        ident_end(id);
        assert_int_equal(id->result.tests, DOFS - 1);
        assert_false(ident_solve(id));
        assert_false(id->result.method_a.evaluated);
    }
}

static void cycles_of_no_axis_are_ignored(void **unused) {
    (void)unused;
    struct rig *r = rig_create(18, 1);
    struct ident *id = ident_create(r);
    struct cycle c = r->cycle[0][0];
    c.dof = DOF_NONE;
    assert_false(ident_feed(id, &c));
    c = r->cycle[0][0];
    c.test = -1;
    assert_false(ident_feed(id, &c));
    assert_false(ident_end(id));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(method_a_recovers_inertia_and_damping_of_a_known_machine),
        cmocka_unit_test(each_axis_has_a_frequency_of_its_own),
        cmocka_unit_test(fundamentals_are_those_of_the_motion),
        cmocka_unit_test(unwanted_motion_is_relative_to_the_recorded_amplitude),
        cmocka_unit_test(order_of_the_tests_changes_no_bit),
        cmocka_unit_test(what_came_before_the_evaluated_part_changes_no_bit),
        cmocka_unit_test(excluded_samples_are_counted_and_never_used),
        cmocka_unit_test(a_leg_that_is_off_its_reference_is_found),
        cmocka_unit_test(a_test_ends_with_its_evaluated_part),
        cmocka_unit_test(a_test_cut_short_is_not_complete_and_no_method_uses_it),
        cmocka_unit_test(a_test_without_a_usable_sample_is_not_complete),
        cmocka_unit_test(a_slower_rate_is_complete_too),
        cmocka_unit_test(a_repeated_test_replaces_the_earlier_one),
        cmocka_unit_test(without_all_six_axes_no_method_is_evaluated),
        cmocka_unit_test(cycles_of_no_axis_are_ignored),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
