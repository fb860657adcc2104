/* The controller through its states: the automatic run, the states before and after it, and
 * requests at any instant. */
#include "platform_rig.h"

#include "gains.h"

/* ---- the run ---- */

static void door_opens(struct hal_sample *sample, int which) {
    (void)which;
    sample->inputs &= ~(uint32_t)INPUT_DOOR;
}

static void automatic_run_tests_every_axis_and_ends_put_down(void **unused) {
    (void)unused;
    static const enum state story[] = {STATE_INIT,    STATE_SETTLED, STATE_PRESSURISING, STATE_ENGAGING, STATE_READY,
                                       STATE_TESTING, STATE_READY,   STATE_PARKING,      STATE_SETTLED};
    struct params params = brisk();
    struct rig rig;
    int chapter = 0, evaluated[DOFS] = {0};
    rig_init(&rig, &params);
    for (int n = 0; n < 20000 && (n == 0 || rig.platform.automatic); n++) {
        rig_cycle(&rig, COMMAND_NONE);
        const struct cycle *c = &rig.now;
        if (c->state != story[chapter]) assert_int_equal(c->state, story[++chapter]);
        if (c->phase == PHASE_EVALUATE) {
            assert_int_equal(c->dof, params.tests.order[c->test]);
            evaluated[c->test]++;
            /* tolerance: a lag of 10 degrees at 4 Hz is 0.7 mm of 4 mm */
            assert_below(distance(c->pose, c->ref, DOFS), 1e-3);
        }
        assert_int_equal(c->test >= 0, c->phase != PHASE_NONE);
    }
    assert_int_equal(chapter, 8);
    for (int i = 0; i < DOFS; i++) assert_int_equal(evaluated[i], 250);
    struct plant_truth truth;
    plant_get_truth(rig.plant, &truth);
    assert_close(truth.pose[DOF_Z], params.motion.park_z_m, 2e-3);
    print_message("# largest valve step of a run: %.3f\n", rig.largest_valve_step);
    assert_below(rig.largest_valve_step, 0.2);
    rig_run(&rig, 500); /* and remains there */
    assert_int_equal(rig.now.state, STATE_SETTLED);
    plant_destroy(rig.plant);
}

/* The supply is requested motion.rest_s after the sensors are first trusted. A door that opens
 * meanwhile ends the automatic run. */
static void an_automatic_run_rests_before_the_supply(void **unused) {
    (void)unused;
    struct params params = brisk();
    params.motion.rest_s = 1.0;
    struct rig rig;
    rig_init(&rig, &params);
    rig_until(&rig, STATE_SETTLED);
    int64_t settled = rig.cycles;
    rig_until(&rig, STATE_PRESSURISING);
    assert_int_equal(rig.cycles - settled, 500);
    plant_destroy(rig.plant);
    rig_init(&rig, &params);
    rig_until(&rig, STATE_SETTLED);
    rig_spoilt(&rig, door_opens, 0);
    rig_run(&rig, 2000);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    plant_destroy(rig.plant);
}

static void nothing_moves_without_engage(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    static const enum command others[] = {COMMAND_START, COMMAND_STOP, COMMAND_PARK, COMMAND_RESET, COMMAND_NONE};
    rig_init(&rig, &params);
    for (int n = 0; n < 500; n++) rig_cycle(&rig, others[n % 5]);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    plant_destroy(rig.plant);
}

/* ---- gains that change ---- */

static void rig_set(struct rig *rig, const struct gains *gains) {
    rig_request(rig, (struct request){.id = ++rig->id, .command = COMMAND_SET, .gains = *gains}, NULL, 0);
}

static struct gains other_gains(const struct params *p) {
    struct gains g = gains_of(&p->control);
    g.value[GAIN_KP] *= 1.35, g.value[GAIN_KI] *= 0.75, g.value[GAIN_KFF] *= 1.2, g.value[GAIN_KPF] *= 0.72;
    return g;
}

/* The commands of the cycle in which the gains change are those that the old gains would have
 * given; both laws. The platform stays where it is, and the later cycles have the new gains. */
static void gains_change_without_a_bump(void **unused) {
    (void)unused;
    for (int law = CONTROL_PID; law <= CONTROL_MODEL; law++) {
        struct params params = by_hand();
        static struct rig rig;
        static struct platform twin;
        struct cycle c;
        params.control.law = (enum control_law)law;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_READY, 1000);
        struct gains gains = other_gains(&params);
        struct hal_sample sample = {.time_ns = rig.cycles * PERIOD_NS, .device_seq = (uint64_t)rig.cycles + 1};
        plant_measure(rig.plant, &sample);
        twin = rig.platform;
        platform_step(&twin, &sample, (struct request){.id = rig.id}, &c);
        rig_step(&rig, &sample, (struct request){.id = ++rig.id, .command = COMMAND_SET, .gains = gains});
        assert_true(rig.platform.request_taken);
        assert_true(gains_equal(&rig.now.gains, &gains));
        /* the reference force that the model's feedback has varies by its low-pass alone at rest */
        for (int i = 0; i < LEGS; i++) assert_close(rig.now.out.valve[i], c.out.valve[i], law == CONTROL_PID ? 1e-12 : 1e-6);
        rig_run(&rig, 500);
        assert_int_equal(rig.now.state, STATE_READY);
        assert_true(gains_equal(&rig.now.gains, &gains));
        plant_destroy(rig.plant);
    }
}

/* SAFETY: neither in motion, nor with a fault or a doubtful sample, nor twice in a second, nor by
 * more than a factor of 1.4. */
static void gains_do_not_change_where_something_moves_or_is_wrong(void **unused) {
    (void)unused;
    static const enum state moving[] = {STATE_INIT, STATE_PRESSURISING, STATE_ENGAGING, STATE_TESTING, STATE_PARKING};
    struct params params = by_hand();
    struct gains as_configured = gains_of(&params.control), gains = other_gains(&params);
    static struct rig rig;
    for (unsigned i = 0; i < sizeof moving / sizeof *moving; i++) {
        rig_init(&rig, &params);
        if (moving[i] != STATE_INIT) rig_bring(&rig, moving[i], 2);
        rig_set(&rig, &gains);
        assert_false(rig.platform.request_taken);
        assert_true(gains_equal(&rig.now.gains, &as_configured));
        plant_destroy(rig.plant);
    }
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 1000);
    rig_request(&rig, (struct request){.id = ++rig.id, .command = COMMAND_SET, .gains = gains}, flagged_invalid, 0);
    assert_false(rig.platform.request_taken);
    struct gains far = gains, none = {.value = {(double)NAN}};
    far.value[GAIN_KPF] = 1.5 * as_configured.value[GAIN_KPF];
    rig_set(&rig, &far);
    assert_false(rig.platform.request_taken);
    rig_set(&rig, &none);
    assert_false(rig.platform.request_taken);
    rig_set(&rig, &gains);
    assert_true(rig.platform.request_taken);
    rig_run(&rig, 400);
    rig_set(&rig, &as_configured); /* within the second */
    assert_false(rig.platform.request_taken);
    rig_run(&rig, 200);
    rig_set(&rig, &as_configured);
    assert_true(rig.platform.request_taken);
    rig_cycle(&rig, COMMAND_PARK); /* a park works as ever */
    assert_int_equal(rig.now.state, STATE_PARKING);
    plant_destroy(rig.plant);
}

/* Put down, the gains change for the next time; engaging begins anew with them. */
static void gains_change_where_the_platform_is_put_down(void **unused) {
    (void)unused;
    struct params params = by_hand();
    static struct rig rig;
    struct gains gains = other_gains(&params);
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_SETTLED, 10);
    rig_set(&rig, &gains);
    assert_true(rig.platform.request_taken);
    rig_bring(&rig, STATE_READY, 500);
    assert_true(gains_equal(&rig.now.gains, &gains));
    plant_destroy(rig.plant);
}

/* ---- before and after ---- */

static void init_waits_for_the_sensors_and_then_gives_up(void **unused) {
    (void)unused;
    struct params params = brisk();
    struct rig rig;
    rig_init(&rig, &params);
    spoil_cycles(&rig, flagged_io, 999);
    assert_int_equal(rig.now.state, STATE_INIT);
    rig_run(&rig, 49);
    assert_int_equal(rig.now.state, STATE_INIT);
    rig_run(&rig, 2);
    assert_int_equal(rig.now.state, STATE_PRESSURISING);
    spoil_cycles(&rig, flagged_io, 1); /* bad samples from init do not count any more */
    assert_int_equal(rig.now.state, STATE_PRESSURISING);
    plant_destroy(rig.plant);

    rig_init(&rig, &params);
    spoil_cycles(&rig, flagged_io, 1000);
    assert_int_equal(rig.now.first_fault, FAULT_IO);
    spoil_cycles(&rig, flagged_io, 3000);
    rig_cycle(&rig, COMMAND_RESET);
    rig_run(&rig, 200);
    /* the platform is not engaged again, because a fault ends the automatic run */
    assert_int_equal(rig.now.state, STATE_SETTLED);
    plant_destroy(rig.plant);
}

/* If a device spoils one sample in `apart`, there are never enough good samples in a row, but the
 * bad ones never outnumber the good ones. */
static void a_device_that_is_bad_now_and_then_does_not_hold_init_for_ever(void **unused) {
    (void)unused;
    static const int apart[] = {2, 7, 49};
    struct params params = brisk();
    for (int i = 0; i < 3; i++) {
        struct rig rig;
        char text[FAULT_LINE_SIZE];
        rig_init(&rig, &params);
        for (int n = 0; n < 2000; n++) rig_spoilt(&rig, n % apart[i] ? NULL : leg_too_short, n);
        assert_int_equal(rig.now.state, STATE_INIT);
        for (int n = 2000; n < 2000 + apart[i]; n++) rig_spoilt(&rig, n % apart[i] ? NULL : leg_too_short, n);
        fault_line(rig.now.first_fault, rig.now.faults, &rig.now.measure, text);
        assert_string_equal(text, "stroke, leg 2: 1420 mm, limit 1425 mm (limits.length_min_m)");
        plant_destroy(rig.plant);
    }
}

static void a_request_cannot_hide_a_fault_of_the_same_cycle(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    for (int command = COMMAND_NONE; command < COMMANDS; command++)
        for (int h = 0; h < HELD; h++) {
            struct rig rig;
            rig_init(&rig, &params);
            rig_bring(&rig, held[h], 10);
            spoil_cycles(&rig, flagged_io, params.limits.bad_cycles - 1);
            rig_request(&rig, (struct request){.id = ++rig.id, .command = (enum command)command}, flagged_io, 0);
            assert_int_equal(rig.now.state, STATE_FAULT);
            assert_int_equal(rig.now.faults, FAULT_IO);
            plant_destroy(rig.plant);
        }
}

static void engage_starts_where_the_platform_is(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    uint64_t seed = 5;
    struct rig rig;
    params.motion.engage_s = 4.0; /* long enough for moves from 0.4 m above neutral, and tilted
                                   * ones */
    for (int n = 0; n < 25; n++) {
        double pose[DOFS];
        struct plant_truth truth;
        rig_init(&rig, &params);
        for (int i = 0; i < DOFS; i++) pose[i] = random_unit(&seed) * (i < DOF_PHI ? 0.08 : 0.12);
        pose[DOF_Z] = n % 2 ? 0.3 * random_unit(&seed) : 0.05 * random_unit(&seed);
        plant_place(rig.plant, pose);
        rig_bring(&rig, STATE_ENGAGING, 0);
        plant_get_truth(rig.plant, &truth);
        /* tolerance: a sensor's resolution and a cycle of settling */
        assert_below(distance(rig.now.ref, truth.pose, DOFS), 1e-3);
        rig_until(&rig, STATE_READY);
        assert_below(distance(rig.now.pose, (double[DOFS]){0}, DOFS), 2e-3);
        assert_below(rig.largest_valve_step, 0.2);
        plant_destroy(rig.plant);
    }
}

static void after_a_fault_at_any_instant_it_can_be_engaged_again_and_put_down(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    uint64_t seed = 6;
    struct rig rig;
    rig_init(&rig, &params);
    for (int n = 0; n < 20; n++) {
        rig_bring(&rig, held[n % HELD], random_below(&seed, n % HELD == 1 ? 100 : 900));
        spoil_cycles(&rig, bad[n % BAD].spoil, params.limits.bad_cycles);
        rig_trip(&rig, bad[n % BAD].spoil);
        rig_run(&rig, random_below(&seed, 300)); /* the platform sinks or rises a little */
        rig_cycle(&rig, COMMAND_RESET);
        rig_until(&rig, STATE_SETTLED);
        rig_cycle(&rig, COMMAND_ENGAGE);
        rig_until(&rig, STATE_READY);
        rig_cycle(&rig, COMMAND_PARK);
        rig_until(&rig, STATE_SETTLED);
    }
    assert_below(rig.largest_valve_step, 0.2);
    plant_destroy(rig.plant);
}

/* ---- requests ---- */

static void park_at_any_instant_of_a_test_ramps_out_and_puts_down(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    uint64_t seed = 7;
    struct rig rig;
    params.tests.count = 1;
    rig_init(&rig, &params);
    /* cycles of a move down: a quarter of a second in which the acceleration ends, then the way
     * itself */
    const int down = 10 + (int)((0.25 + reference_park_s(&params.motion, params.motion.park_s)) / params.loop.period_s);
    for (int n = 0; n < 30; n++) {
        rig.params.tests.order[0] = (enum dof)(n % DOFS);
        rig_bring(&rig, STATE_TESTING, random_below(&seed, 500));
        /* already stopping */
        if (n % 3 == 0) rig_cycle(&rig, COMMAND_STOP), rig_run(&rig, random_below(&seed, 80));
        rig_cycle(&rig, COMMAND_PARK);
        for (int m = 0; rig.now.state != STATE_SETTLED; m++) {
            assert_int_equal(rig.now.state, STATE_PARKING);
            assert_true(rig.now.phase == PHASE_RAMP_OUT || rig.now.phase == PHASE_NONE);
            assert_true(m < 101 + down);
            rig_cycle(&rig, m % 7 ? COMMAND_NONE : COMMAND_PARK); /* repeated requests */
        }
        assert_close(rig.now.pose[DOF_Z], params.motion.park_z_m, 2e-3);
    }
    print_message("# largest valve step with parks during tests: %.3f\n", rig.largest_valve_step);
    assert_below(rig.largest_valve_step, 0.2);
    plant_destroy(rig.plant);
}

static void stop_ends_the_test_and_start_takes_it_up_again(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_TESTING, 1000); /* a cycle in the second test, because a test has about
                                           * 526 cycles */
    assert_int_equal(rig.now.test, 1);
    rig_cycle(&rig, COMMAND_STOP);
    rig_run(&rig, 150);
    assert_int_equal(rig.now.state, STATE_READY);
    rig_run(&rig, 500);
    assert_int_equal(rig.now.state, STATE_READY); /* the platform stays in READY until the next
                                                   * request */
    rig_cycle(&rig, COMMAND_START);
    assert_int_equal(rig.now.state, STATE_TESTING);
    assert_int_equal(rig.now.test, 1);
    rig_until(&rig, STATE_READY);
    rig_cycle(&rig, COMMAND_START); /* all tests are done, so the first one is run again */
    assert_int_equal(rig.now.test, 0);
    plant_destroy(rig.plant);
}

static void a_stop_ends_what_is_automatic(void **unused) {
    (void)unused;
    struct params params = brisk();
    struct rig rig;
    rig_init(&rig, &params);
    rig_until(&rig, STATE_TESTING);
    rig_run(&rig, 700);
    rig_cycle(&rig, COMMAND_STOP);
    rig_until(&rig, STATE_READY);
    rig_run(&rig, 1000);
    assert_int_equal(rig.now.state, STATE_READY);
    plant_destroy(rig.plant);
}

static void a_request_is_acted_upon_once(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    const struct request engage = {.id = 7, .command = COMMAND_ENGAGE}, park = {.id = 8, .command = COMMAND_PARK};
    /* this request came too early, during init, and is not taken later */
    for (int n = 0; n < 200; n++) rig_request(&rig, engage, NULL, 0);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    rig_request(&rig, park, NULL, 0);
    rig_request(&rig, engage, NULL, 0); /* the same request with a new id is taken */
    assert_int_equal(rig.now.state, STATE_PRESSURISING);
    for (int n = 0; n < 500; n++) rig_request(&rig, engage, NULL, 0);
    for (int n = 0; n < 5; n++) rig_request(&rig, engage, flagged_io, 0);
    assert_int_equal(rig.now.state, STATE_FAULT);
    rig_request(&rig, (struct request){.id = UINT32_MAX, .command = COMMAND_RESET}, NULL, 0);
    for (int n = 0; n < 200; n++) rig_request(&rig, (struct request){.id = UINT32_MAX, .command = COMMAND_ENGAGE}, NULL, 0);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    /* ids wrap around */
    rig_request(&rig, (struct request){.id = 0, .command = COMMAND_ENGAGE}, NULL, 0);
    assert_int_equal(rig.now.state, STATE_PRESSURISING);
    plant_destroy(rig.plant);
}

static void hostile_commands_do_nothing(void **unused) {
    (void)unused;
    struct params params = by_hand();
    static const uint32_t values[] = {COMMANDS, COMMANDS + 1, 77, 0x7fffffff, 0x80000000, 0xffffffff};
    for (int h = 0; h < HELD; h++) {
        struct rig rig;
        rig_init(&rig, &params);
        rig_bring(&rig, held[h], 10);
        for (unsigned n = 0; n < sizeof values / sizeof *values; n++) {
            rig_request(&rig, (struct request){.id = ++rig.id, .command = (enum command)values[n]}, NULL, 0);
            assert_int_equal(rig.now.state, held[h]);
        }
        rig_cycle(&rig, COMMAND_PARK); /* these requests do not block the next one */
        assert_int_equal(rig.now.state, STATE_PARKING);
        plant_destroy(rig.plant);
    }
}

/* Three minutes of random requests with occasional bad samples: the claims of check_always() are
 * true, and the platform never jerks. */
static void random_requests_never_bump_the_platform(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    uint64_t seed = 8;
    struct rig rig;
    int visits[STATES] = {0};
    static const enum command buttons[] = {COMMAND_ENGAGE, COMMAND_ENGAGE, COMMAND_START, COMMAND_START,
                                           COMMAND_STOP,   COMMAND_PARK,   COMMAND_RESET, COMMAND_RESET};
    rig_init(&rig, &params);
    for (int n = 0; n < 90000; n++) {
        bool push = random_below(&seed, 200) == 0;
        if (push) rig_cycle(&rig, buttons[random_below(&seed, 8)]);
        else if (random_below(&seed, 2000) == 0) spoil_cycles(&rig, bad[random_below(&seed, BAD)].spoil, 1 + random_below(&seed, 6));
        else rig_cycle(&rig, COMMAND_NONE);
        if (rig.now.state != rig.before.state) visits[rig.now.state]++;
    }
    print_message("# visits:");
    for (int s = 0; s < STATES; s++) print_message(" %s %d", state_names[s], visits[s]);
    print_message("; largest valve step %.3f\n", rig.largest_valve_step);
    for (int s = 0; s < STATES; s++) assert_true(visits[s] > 0);
    assert_below(rig.largest_valve_step, 0.2);
    plant_destroy(rig.plant);
}

/* Any bits from the sensors, mixed with good samples: the claims of check_always() are true. */
static void garbage_from_the_sensors_never_reaches_the_valves(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    uint64_t seed = 9;
    struct rig rig;
    rig_init(&rig, &params);
    for (int n = 0; n < 20000; n++) {
        struct hal_sample sample = {.time_ns = rig.cycles * PERIOD_NS};
        plant_measure(rig.plant, &sample);
        if (random_below(&seed, 20) == 0) {
            uint64_t word;
            size_t at = (size_t)random_below(&seed, (int)(sizeof sample / sizeof word)) * sizeof word;
            random_unit(&seed);
            /* also plausible exponents */
            word = random_below(&seed, 2) ? seed ^ seed << 31 : seed >> 1;
            memcpy((char *)&sample + at, &word, sizeof word);
        }
        struct request request = {.id = (uint32_t)n, .command = (enum command)(n % 50 == 0 ? random_below(&seed, COMMANDS) : 0)};
        rig_step(&rig, &sample, request);
    }
    plant_destroy(rig.plant);
}

/* Rates and accelerations of z, as differences of the reference in driven cycles. */
struct z_motion {
    double last, rate, most_mps, most_mps2, most_step_mps2, accel;
    int cycles;
};

static void watch_z(struct z_motion *m, const struct rig *rig) {
    double dt_s = rig->params.loop.period_s, z = rig->now.ref[DOF_Z], rate = (z - m->last) / dt_s, accel = (rate - m->rate) / dt_s;
    if (m->cycles == 0) rate = accel = 0.0;
    m->most_mps = fmax(m->most_mps, fabs(rate)), m->most_mps2 = fmax(m->most_mps2, fabs(accel));
    m->most_step_mps2 = fmax(m->most_step_mps2, fabs(accel - m->accel));
    m->last = z, m->rate = rate, m->accel = accel, m->cycles++;
}

/* Moving 0.46 m in a second is impossible, so the move takes as long as its limits require. A stop
 * at any instant of it turns it back without a step in rate or acceleration. */
static void a_move_keeps_its_limits_whatever_duration_is_asked_for(void **unused) {
    (void)unused;
    struct params params = by_hand();
    params.motion.park_z_m = 0.3, params.motion.engage_s = params.motion.park_s = 1.0;
    for (int stop = 0; stop <= 800; stop += 100) {
        struct rig rig;
        struct z_motion m = {0};
        double most_z = 0.0;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_ENGAGING, 0);
        for (int n = 0; rig.now.state == STATE_ENGAGING || rig.now.state == STATE_PARKING; n++) {
            watch_z(&m, &rig);
            most_z = fmin(most_z, rig.now.ref[DOF_Z]);
            rig_cycle(&rig, stop && n == stop ? COMMAND_STOP : COMMAND_NONE);
            assert_true(n < 5000);
        }
        assert_int_equal(rig.now.faults, 0);
        assert_below(m.most_mps, params.motion.rate_mps * (1 + 1e-9));
        assert_below(m.most_mps2, params.motion.accel_mps2 * (1 + 1e-6));
        /* limit: the jerk of braking within 0.25 s, 4 a0 / B + 6 v0 / B^2 */
        assert_below(m.most_step_mps2, 8 * params.motion.accel_mps2 / 0.25 * params.loop.period_s);
        assert_true(most_z >= -0.2);
        plant_destroy(rig.plant);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(automatic_run_tests_every_axis_and_ends_put_down),
        cmocka_unit_test(an_automatic_run_rests_before_the_supply),
        cmocka_unit_test(gains_change_without_a_bump),
        cmocka_unit_test(gains_do_not_change_where_something_moves_or_is_wrong),
        cmocka_unit_test(gains_change_where_the_platform_is_put_down),
        cmocka_unit_test(nothing_moves_without_engage),
        cmocka_unit_test(init_waits_for_the_sensors_and_then_gives_up),
        cmocka_unit_test(a_device_that_is_bad_now_and_then_does_not_hold_init_for_ever),
        cmocka_unit_test(a_request_cannot_hide_a_fault_of_the_same_cycle),
        cmocka_unit_test(engage_starts_where_the_platform_is),
        cmocka_unit_test(a_move_keeps_its_limits_whatever_duration_is_asked_for),
        cmocka_unit_test(after_a_fault_at_any_instant_it_can_be_engaged_again_and_put_down),
        cmocka_unit_test(park_at_any_instant_of_a_test_ramps_out_and_puts_down),
        cmocka_unit_test(stop_ends_the_test_and_start_takes_it_up_again),
        cmocka_unit_test(a_stop_ends_what_is_automatic),
        cmocka_unit_test(a_request_is_acted_upon_once),
        cmocka_unit_test(hostile_commands_do_nothing),
        cmocka_unit_test(random_requests_never_bump_the_platform),
        cmocka_unit_test(garbage_from_the_sensors_never_reaches_the_valves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
