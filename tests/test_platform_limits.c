/* The controller's limits: readings that are beyond limits, late or missing end in a fault, and not
 * before they must. */
#include "platform_rig.h"

/* Asserts that a fault keeps the platform still until the reset, whatever is requested and however
 * good the samples; then the platform waits to be engaged. */
static void assert_stays_still_until_reset(struct rig *rig) {
    static const enum command tempting[] = {COMMAND_ENGAGE, COMMAND_START, COMMAND_STOP, COMMAND_PARK, COMMAND_NONE};
    uint32_t faults = rig->now.faults, headline = rig->now.first_fault;
    for (int n = 0; n < 100; n++) {
        rig_cycle(rig, tempting[n % 5]);
        assert_int_equal(rig->now.state, STATE_FAULT);
        assert_int_equal(rig->now.faults, faults);
        assert_int_equal(rig->now.first_fault, headline);
    }
    rig_cycle(rig, COMMAND_RESET);
    assert_int_equal(rig->now.state, STATE_INIT);
    rig_run(rig, 100);
    assert_int_equal(rig->now.state, STATE_SETTLED);
}

static void each_limit_trips_in_bad_cycles_and_holds_until_reset(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    for (int b = 0; b < BAD; b++)
        for (int h = 0; h < HELD; h++) {
            rig_bring(&rig, held[h], 40);
            spoil_cycles(&rig, bad[b].spoil, params.limits.bad_cycles - 1);
            if (rig.now.state != held[h])
                fail_msg("%s in %s: tripped early (%s)", bad[b].what, state_names[held[h]], fault_name(rig.now.first_fault));
            rig_spoilt(&rig, bad[b].spoil, params.limits.bad_cycles - 1);
            if (!rig.now.faults) fail_msg("%s in %s: not tripped", bad[b].what, state_names[held[h]]);
            if (rig.now.first_fault != bad[b].headline)
                fail_msg("%s: headline %s, not %s", bad[b].what, fault_name(rig.now.first_fault), fault_name(bad[b].headline));
            rig_trip(&rig, bad[b].spoil);
            assert_stays_still_until_reset(&rig);
        }
    rig_bring(&rig, STATE_READY, 0); /* it still engages */
    plant_destroy(rig.plant);
}

static void flagged_foreign(struct hal_sample *s, int cycle) { (void)cycle, s->flags |= SAMPLE_FOREIGN; }
static void flagged_foreign_and_not_read(struct hal_sample *s, int cycle) {
    (void)cycle;
    *s = (struct hal_sample){.flags = SAMPLE_FOREIGN | SAMPLE_IO};
}

/* This applies in every state, also at rest, and however tolerant the limits are. */
static void another_master_trips_at_the_first_sample_that_says_so(void **unused) {
    (void)unused;
    static const enum state states[] = {STATE_INIT, STATE_SETTLED, STATE_ENGAGING, STATE_READY, STATE_TESTING, STATE_PARKING};
    static spoiler *const spoil[] = {flagged_foreign, flagged_foreign_and_not_read};
    struct params params = by_hand();
    params.limits.bad_cycles = 20;
    for (unsigned i = 0; i < sizeof states / sizeof *states; i++)
        for (unsigned k = 0; k < 2; k++) {
            struct rig rig;
            rig_init(&rig, &params);
            if (states[i] != STATE_INIT) rig_bring(&rig, states[i], 20);
            spoil_cycles(&rig, spoil[k], 1);
            assert_int_equal(rig.now.state, STATE_FAULT);
            assert_true(rig.now.faults & FAULT_MASTER);
            if (k == 0) assert_int_equal(rig.now.first_fault, FAULT_MASTER);
            assert_false(rig.now.out.enable);
            plant_destroy(rig.plant);
        }
}

static void fewer_bad_samples_are_ridden_out_with_the_command_held(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    for (int b = 0; b < BAD; b++)
        for (int h = 0; h < HELD; h++) {
            rig_bring(&rig, held[h], 40);
            for (int length = 1; length < params.limits.bad_cycles; length++) {
                struct hal_command kept = rig.now.out;
                for (int n = 0; n < length; n++) {
                    rig_spoilt(&rig, bad[b].spoil, n);
                    if (!parks(bad[b].headline)) assert_memory_equal(kept.valve, rig.now.out.valve, sizeof kept.valve);
                    assert_true(rig.now.out.enable);
                    /* so that the identifier excludes the sample */
                    assert_true(rig.now.in.flags & (SAMPLE_INVALID | SAMPLE_IO));
                }
                rig_run(&rig, 10);
                assert_int_equal(rig.now.in.flags, 0);
                assert_int_equal(rig.now.state, held[h]);
            }
            rig_run(&rig, 10);
        }
    print_message("# largest valve step with samples missing: %.3f\n", rig.largest_valve_step);
    assert_below(rig.largest_valve_step, 0.2);
    plant_destroy(rig.plant);
}

static void a_leg_that_does_not_follow_trips(void **unused) {
    (void)unused;
    struct params params = by_hand();
    params.limits.standstill_m = 1.0; /* otherwise this limit would trip first */
    for (int leg = 0; leg < LEGS; leg++) {
        struct rig rig;
        int beyond = 0;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_ENGAGING, 100);
        rig.cut_leg = leg;
        while (rig.now.state == STATE_ENGAGING) {
            double ref = rig.platform.leg_ref_m[leg]; /* reference with which the next sample is
                                                       * compared */
            rig_cycle(&rig, COMMAND_NONE);
            if (fabs(ref - rig.now.in.length_m[leg]) > params.limits.following_m) beyond++;
        }
        assert_int_equal(rig.now.first_fault, FAULT_FOLLOWING);
        assert_int_equal(beyond, params.limits.bad_cycles);
        plant_destroy(rig.plant);
    }
}

/* A transducer fails while the platform moves. Without this limit its leg would be driven to the
 * end stop, because the reading never reaches the reference. */
static void a_length_that_stands_still_trips_before_its_leg_has_gone_far(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    static const enum state moving[] = {STATE_ENGAGING, STATE_TESTING, STATE_PARKING};
    params.tests.order[0] = DOF_Z; /* a test of z moves all legs by 3.6 mm */
    for (int m = 0; m < 3; m++)
        for (int leg = 0; leg < LEGS; leg++) {
            struct rig rig;
            double astray = 0.0;
            rig_init(&rig, &params);
            rig_bring(&rig, moving[m], 250);
            double frozen = rig.now.in.length_m[leg];
            while (rig.now.state == moving[m]) {
                struct hal_sample sample = {.time_ns = rig.cycles * PERIOD_NS};
                struct plant_truth truth;
                plant_measure(rig.plant, &sample);
                plant_get_truth(rig.plant, &truth);
                sample.length_m[leg] = frozen;
                astray = fmax(astray, fabs(truth.length_m[leg] - rig.platform.leg_ref_m[leg]));
                rig_given(&rig, &sample);
            }
            assert_int_equal(rig.now.first_fault, FAULT_STANDSTILL);
            assert_true(rig.platform.still_high_m[leg] - rig.platform.still_low_m[leg] > params.limits.standstill_m);
            double held_s = params.limits.bad_cycles * params.loop.period_s;
            /* limit: until the fault, valves stay open at 0.4 m/s */
            assert_below(astray, 2 * params.limits.standstill_m + 0.4 * held_s);
            plant_destroy(rig.plant);
        }
}

/* The range of the reference counts, wherever it lies relative to the frozen reading. psi moves all
 * legs by 2.5 mm from end to end. */
static void a_length_that_stands_still_in_a_test_trips_within_a_period(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    int ramped = (int)((params.tests.settle_s + params.tests.ramp_s) / params.loop.period_s);
    int period = (int)(1.0 / params.tests.hz[DOF_PSI] / params.loop.period_s);
    params.tests.order[0] = DOF_PSI;
    for (int leg = 0; leg < LEGS; leg++)
        for (int at = 0; at < period; at += period / 5) {
            struct rig rig;
            rig_init(&rig, &params);
            rig_bring(&rig, STATE_TESTING, ramped + at);
            double frozen = rig.now.in.length_m[leg];
            int cycles = 0;
            for (; rig.now.state == STATE_TESTING; cycles++) {
                struct hal_sample sample = {.time_ns = rig.cycles * PERIOD_NS};
                plant_measure(rig.plant, &sample);
                sample.length_m[leg] = frozen;
                rig_given(&rig, &sample);
            }
            assert_int_equal(rig.now.first_fault, FAULT_STANDSTILL);
            assert_in_range(cycles, 1, period + params.limits.bad_cycles);
            plant_destroy(rig.plant);
        }
}

static void a_leg_with_much_dry_friction_does_not_stand_still_for_long_enough_to_trip(void **unused) {
    (void)unused;
    struct params params = brisk();
    struct rig rig;
    int effect = effect_find("cylinder_coulomb_friction");
    assert_true(effect >= 0);
    params.effects[effect].on = true;
    /* twice the paper's */
    for (int k = 0; k < EFFECT_KEYS && effect_table[effect]->keys[k].name; k++)
        for (int i = 0; i < LEGS; i++) params.effects[effect].value[k][i] = 400.0;
    rig_init(&rig, &params);
    for (int n = 0; n < 20000 && (n == 0 || rig.platform.automatic); n++) rig_cycle(&rig, COMMAND_NONE);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    assert_int_equal(rig.now.first_fault, 0);
    plant_destroy(rig.plant);
}

/* Sets lengths that are possible for each leg, but together fit no pose. */
static void no_such_platform(struct hal_sample *s, int cycle) {
    (void)cycle;
    for (int i = 0; i < LEGS; i++) s->length_m[i] = i % 2 ? 2.2 : 1.45;
}

static void lengths_that_fit_no_pose_trip(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    /* otherwise these limits would trip first */
    params.limits.leg_rate_mps = params.limits.following_m = params.limits.standstill_m = 1e6;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 10);
    spoil_cycles(&rig, no_such_platform, params.limits.bad_cycles - 1);
    assert_int_equal(rig.now.state, STATE_READY);
    spoil_cycles(&rig, no_such_platform, 1);
    assert_int_equal(rig.now.first_fault, FAULT_KINEMATICS);
    assert_stays_still_until_reset(&rig);
    plant_destroy(rig.plant);
}

static void commanded_by_another(struct hal_sample *s, int cycle) { (void)cycle, s->flags |= SAMPLE_FOREIGN; }
static void commanded_by_another_unread(struct hal_sample *s, int cycle) {
    (void)cycle, *s = (struct hal_sample){.flags = SAMPLE_FOREIGN | SAMPLE_IO};
}

/* The fault comes in any state, and whatever else is wrong with that sample. */
static void a_second_master_is_a_fault_at_its_first_frame(void **unused) {
    static const enum state states[] = {STATE_INIT, STATE_SETTLED, STATE_ENGAGING, STATE_READY, STATE_TESTING, STATE_PARKING};
    (void)unused;
    struct params params = by_hand();
    for (unsigned h = 0; h < sizeof states / sizeof *states; h++)
        for (int unread = 0; unread < 2; unread++) {
            struct rig rig;
            rig_init(&rig, &params);
            if (states[h] == STATE_INIT) rig_run(&rig, 5);
            else rig_bring(&rig, states[h], 5);
            assert_int_equal(rig.now.state, states[h]);
            rig_spoilt(&rig, unread ? commanded_by_another_unread : commanded_by_another, 0);
            assert_int_equal(rig.now.first_fault, FAULT_MASTER);
            assert_stays_still_until_reset(&rig);
            plant_destroy(rig.plant);
        }
}

static void overran(struct hal_sample *s, int cycle) { (void)cycle, s->flags |= SAMPLE_OVERRUN, s->missed = 1; }

static void overrun_limit_in_a_row_trips_and_one_less_does_not(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 10);
    for (int n = 0; n < 10; n++) {
        spoil_cycles(&rig, overran, params.loop.overrun_limit - 1);
        rig_run(&rig, 1);
        assert_int_equal(rig.now.state, STATE_READY);
    }
    spoil_cycles(&rig, overran, params.loop.overrun_limit);
    assert_int_equal(rig.now.first_fault, FAULT_OVERRUN);
    assert_stays_still_until_reset(&rig);
    plant_destroy(rig.plant);
}

/* The loop is away for 16 ms while the platform moves at its top speed. The leg kept its rate
 * limit, and the supply's relay is still closed. */
static void a_missed_deadline_is_no_leg_rate_fault(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    /* otherwise these limits would trip first */
    params.loop.overrun_limit = 100, params.limits.following_m = 0.05;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_ENGAGING, 500); /* the middle of the move */
    for (int n = 0; n < 8; n++) plant_step(rig.plant, rig.now.out.valve);
    struct hal_sample sample = {.flags = SAMPLE_OVERRUN};
    plant_measure(rig.plant, &sample);
    double moved = fabs(sample.length_m[0] - rig.platform.length_m[0]);
    /* for a single period this would be a jump */
    assert_true(moved > 2 * params.limits.leg_rate_mps * params.loop.period_s);
    for (int n = 0; n < 20; n++) {
        sample.time_ns = (rig.cycles + 8) * PERIOD_NS;
        if (n > 0) sample.flags = 0, plant_measure(rig.plant, &sample);
        rig_given(&rig, &sample);
        assert_int_equal(rig.now.state, STATE_ENGAGING);
        assert_false(rig.now.in.flags & SAMPLE_INVALID);
    }
    plant_destroy(rig.plant);
}

static void late_but_young_enough_samples_are_used(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 10);
    for (int n = 0; n < 100; n++) {
        struct hal_sample sample = {.time_ns = rig.cycles * PERIOD_NS - 9000000, .age_ns = 9000000, .flags = SAMPLE_LATE};
        plant_measure(rig.plant, &sample);
        rig_given(&rig, &sample);
        assert_int_equal(rig.now.state, STATE_READY);
        assert_int_equal(rig.now.in.flags, SAMPLE_LATE);
    }
    plant_destroy(rig.plant);
}

static void a_stale_sample_trips_once_it_is_too_old(void **unused) {
    (void)unused;
    struct params params = by_hand();
    for (int h = 0; h < HELD; h++) {
        struct rig rig;
        int cycles = 0;
        rig_init(&rig, &params);
        rig_bring(&rig, held[h], 40);
        struct hal_sample last = rig.now.in;
        for (; rig.now.state == held[h]; cycles++) {
            last.age_ns += PERIOD_NS;
            last.flags = SAMPLE_STALE;
            rig_given(&rig, &last);
        }
        assert_int_equal(rig.now.first_fault, FAULT_SENSOR_AGE);
        /* samples of 2, 4, ... 10 ms are young enough; the next bad_cycles ones are too old */
        assert_int_equal(cycles, (int)(params.limits.sensor_age_s / params.loop.period_s + 0.5) + params.limits.bad_cycles);
        plant_destroy(rig.plant);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_limit_trips_in_bad_cycles_and_holds_until_reset),
        cmocka_unit_test(another_master_trips_at_the_first_sample_that_says_so),
        cmocka_unit_test(fewer_bad_samples_are_ridden_out_with_the_command_held),
        cmocka_unit_test(a_leg_that_does_not_follow_trips),
        cmocka_unit_test(a_length_that_stands_still_trips_before_its_leg_has_gone_far),
        cmocka_unit_test(a_length_that_stands_still_in_a_test_trips_within_a_period),
        cmocka_unit_test(a_leg_with_much_dry_friction_does_not_stand_still_for_long_enough_to_trip),
        cmocka_unit_test(lengths_that_fit_no_pose_trip),
        cmocka_unit_test(a_second_master_is_a_fault_at_its_first_frame),
        cmocka_unit_test(overrun_limit_in_a_row_trips_and_one_less_does_not),
        cmocka_unit_test(a_missed_deadline_is_no_leg_rate_fault),
        cmocka_unit_test(late_but_young_enough_samples_are_used),
        cmocka_unit_test(a_stale_sample_trips_once_it_is_too_old),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
