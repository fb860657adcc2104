/* Interlocks, energy and staged reactions: pressing, opening or releasing any input stops the
 * machine and its supply in the same cycle; a dead controller loses the supply; failures that
 * control can tolerate park the platform slowly. */
#include "platform_rig.h"

#include "failure.h"
#include "interlock.h"
#include "power_unit.h"

static uint32_t opened; /* INPUT_... that open_inputs() clears */
static void open_inputs(struct hal_sample *s, int which) { (void)which, s->inputs &= ~opened; }
static void open_and_unwritten(struct hal_sample *s, int which) { open_inputs(s, which), s->flags |= SAMPLE_IO | SAMPLE_UNWRITTEN; }
static void no_pressures(struct hal_sample *s, int leg) { s->p1_pa[leg] = s->p2_pa[leg] = (double)NAN; }
static void pressure_there(struct hal_sample *s, int which) { (void)which, s->inputs |= INPUT_SUPPLY; }
static void no_length(struct hal_sample *s, int leg) { s->length_m[leg] = (double)NAN; }
static void no_pressures_and_length(struct hal_sample *s, int leg) { no_pressures(s, leg), no_length(s, leg); }

static bool pressure_of(struct rig *rig) {
    struct hal_sample sample = {0};
    plant_measure(rig->plant, &sample);
    return sample.inputs & INPUT_SUPPLY;
}

/* ---- inputs ---- */

static void an_open_input_is_a_fault_in_its_first_cycle_and_takes_the_supply_off(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    for (int k = 0; k < INPUTS; k++)
        for (int h = 0; h < HELD; h++) {
            struct rig rig;
            bool pressure = interlock_table[k].input == INPUT_SUPPLY;
            rig_init(&rig, &params);
            rig_bring(&rig, held[h], 20);
            assert_true(pressure_of(&rig));
            opened = interlock_table[k].input;
            for (int n = 1; n < (pressure ? params.limits.bad_cycles : 1); n++) rig_spoilt(&rig, open_inputs, 0);
            assert_int_equal(rig.now.state, held[h]);
            rig_spoilt(&rig, open_inputs, 0);
            assert_int_equal(rig.now.state, STATE_FAULT);
            assert_int_equal(rig.now.first_fault, interlock_table[k].fault);
            rig_run(&rig, 40); /* 80 ms: relay and accumulator keep the pressure for so long */
            assert_false(pressure_of(&rig));
            plant_destroy(rig.plant);
        }
}

static void an_open_input_refuses_engage_and_says_which(void **unused) {
    (void)unused;
    struct params params = by_hand();
    for (int k = 0; k < INPUTS; k++) {
        struct rig rig;
        /* the pressure switch is open here, because the supply is off */
        if (interlock_table[k].input == INPUT_SUPPLY) continue;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_SETTLED, 10);
        opened = interlock_table[k].input;
        rig_spoilt(&rig, open_inputs, 0);
        rig_request(&rig, (struct request){.id = ++rig.id, .command = COMMAND_ENGAGE}, open_inputs, 0);
        assert_int_equal(rig.now.state, STATE_SETTLED);
        assert_false(rig.platform.request_taken);
        assert_true(rig.now.in.flags & SAMPLE_OPEN);
        assert_string_equal(supervisor_advice(STATE_SETTLED, platform_wrong(&rig.platform), COMMAND_ENGAGE), interlock_table[k].open);
        rig_run(&rig, 10);
        assert_int_equal(rig.now.state, STATE_SETTLED); /* the command is not carried out later,
                                                         * when the input closes */
        rig_cycle(&rig, COMMAND_ENGAGE);
        assert_int_equal(rig.now.state, STATE_PRESSURISING);
        plant_destroy(rig.plant);
    }
}

/* An input is open when the automatic run would engage. If it closes later, the machine does not
 * start. */
static void an_automatic_run_that_meets_an_open_input_is_over(void **unused) {
    (void)unused;
    struct params params = brisk();
    struct rig rig;
    rig_init(&rig, &params);
    opened = INPUT_DOOR;
    while (rig.now.state != STATE_SETTLED) rig_spoilt(&rig, open_inputs, 0);
    rig_spoilt(&rig, open_inputs, 0);
    assert_false(rig.platform.automatic);
    rig_run(&rig, 1000);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    plant_destroy(rig.plant);
}

static void open_beside_a_length(struct hal_sample *s, int leg) { open_inputs(s, leg), no_length(s, leg), s->flags |= SAMPLE_STALE; }

/* An input that was open once before the supply is on has ended the run, also if it closed before
 * the platform settled, or was open in a doubtful sample alone. */
static void an_automatic_run_is_over_once_an_input_was_open(void **unused) {
    (void)unused;
    for (int k = 0; k < 4; k++) {
        struct params params = brisk();
        struct rig rig;
        params.motion.rest_s = 1.0;
        rig_init(&rig, &params);
        while (k % 2 && rig.now.state != STATE_SETTLED) rig_run(&rig, 1);
        opened = INPUT_DOOR;
        rig_spoilt(&rig, k < 2 ? open_inputs : open_beside_a_length, 0);
        assert_false(rig.platform.automatic);
        rig_run(&rig, 1000);
        assert_int_equal(rig.now.state, STATE_SETTLED);
        plant_destroy(rig.plant);
    }
}

/* A failed write makes a sample doubtful, but its inputs remain valid. */
static void an_input_opens_also_while_nothing_can_be_written(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 20);
    opened = INPUT_EMERGENCY_STOP;
    rig_spoilt(&rig, open_and_unwritten, 0);
    assert_int_equal(rig.now.state, STATE_FAULT);
    assert_int_equal(rig.now.first_fault, FAULT_EMERGENCY_STOP);
    plant_destroy(rig.plant);
}

/* A sample that was not read is not replaced by the one before. */
static void nothing_begins_on_a_doubtful_sample(void **unused) {
    (void)unused;
    static spoiler *const spoil[] = {flagged_io, flagged_invalid, length_not_a_number};
    struct params params = by_hand();
    for (int k = 0; k < 6; k++) {
        struct rig rig;
        enum state from = k < 3 ? STATE_SETTLED : STATE_READY;
        rig_init(&rig, &params);
        rig_bring(&rig, from, 20);
        rig_request(&rig, (struct request){.id = ++rig.id, .command = k < 3 ? COMMAND_ENGAGE : COMMAND_START}, spoil[k % 3], 0);
        assert_int_equal(rig.now.state, from);
        assert_false(rig.platform.request_taken);
        plant_destroy(rig.plant);
    }
}

static uint32_t contradicting; /* INPUT_... that contradict() sets */
static void contradict(struct hal_sample *s, int which) { (void)which, s->inputs &= ~contradicting, s->contradicted = contradicting; }

static void a_reset_whose_cause_stands_is_not_taken(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_SETTLED, 20);
    contradicting = INPUT_DOOR;
    while (rig.now.state != STATE_FAULT) rig_spoilt(&rig, contradict, 0);
    rig_request(&rig, (struct request){.id = ++rig.id, .command = COMMAND_RESET}, contradict, 0);
    assert_int_equal(rig.now.state, STATE_FAULT);
    assert_int_equal(rig.now.first_fault, FAULT_ANTIVALENCE);
    assert_false(rig.platform.request_taken);
    rig_run(&rig, 1);
    rig_cycle(&rig, COMMAND_RESET);
    assert_int_equal(rig.now.state, STATE_INIT);
    assert_true(rig.platform.request_taken);
    plant_destroy(rig.plant);
}

static void what_is_not_wired_is_not_watched_and_named(void **unused) {
    (void)unused;
    for (int k = 0; k < INPUTS; k++) {
        struct params params = by_hand();
        bool *keys[INPUTS] = {&params.interlocks.emergency_stop, &params.interlocks.enable, &params.interlocks.door,
                              &params.interlocks.pressure};
        struct rig rig;
        char text[200];
        *keys[k] = false;
        params.interlocks.pressure_s = 0.5;
        rig_init(&rig, &params);
        opened = interlock_table[k].input;
        while (rig.now.state != STATE_SETTLED) rig_spoilt(&rig, open_inputs, 0);
        rig_request(&rig, (struct request){.id = ++rig.id, .command = COMMAND_ENGAGE}, open_inputs, 0);
        for (int n = 0; n < 3000 && rig.now.state != STATE_READY; n++) rig_spoilt(&rig, open_inputs, 0);
        assert_int_equal(rig.now.state, STATE_READY);
        interlock_describe(&params.interlocks, text, sizeof text);
        const char *missing = strstr(text, "NOT WIRED");
        assert_non_null(missing);
        assert_non_null(strstr(missing, interlock_table[k].name));
        plant_destroy(rig.plant);
    }
}

/* Faults that follow in the same cycle do not become the headline. */
static void the_emergency_stop_is_the_headline(void **unused) {
    (void)unused;
    struct supervisor s = {0};
    assert_int_equal(supervisor_judge(&s, FAULT_FOLLOWING | FAULT_SUPPLY | FAULT_EMERGENCY_STOP | FAULT_SENSOR_INVALID, 1), REACTION_STOP);
    assert_int_equal(s.first_fault, FAULT_EMERGENCY_STOP);
}

/* ---- two contacts ---- */

static void what_is_sent_is_read_as_it_was_and_one_wrong_bit_is_open_and_contradicts(void **unused) {
    (void)unused;
    struct params params = by_hand();
    assert_true(params.interlocks.antivalent);
    for (uint32_t closed = 0; closed <= INPUTS_ALL; closed++) {
        struct interlock_reading r = interlock_read(&params.interlocks, interlock_bits(&params.interlocks, closed));
        assert_int_equal(r.closed, closed);
        assert_int_equal(r.contradicted, 0);
        for (int bit = 0; bit < 2 * INPUTS; bit++) {
            r = interlock_read(&params.interlocks, interlock_bits(&params.interlocks, closed) ^ 1u << bit);
            assert_int_equal(r.contradicted, 1u << bit % INPUTS);
            assert_int_equal(r.closed, closed & ~(1u << bit % INPUTS));
        }
    }
    assert_int_equal(interlock_read(&params.interlocks, 0).closed, 0);
    assert_int_equal(interlock_read(&params.interlocks, 0xff).closed, 0);
    params.interlocks.antivalent = false;
    assert_int_equal(interlock_read(&params.interlocks, 0xff).closed, INPUTS_ALL);
}

static void assert_line(const struct cycle *c, const char *input) {
    char line[FAULT_LINE_SIZE], expected[FAULT_LINE_SIZE];
    fault_line(c->first_fault, c->faults, &c->measure, line);
    snprintf(expected, sizeof expected, "input_contradiction: %s", input);
    assert_string_equal(line, expected);
}

/* The fault comes in every state, whether the platform is driven or not, and does not come if one
 * contact switches shortly after the other. */
static void contacts_that_contradict_each_other_are_a_fault_after_the_discrepancy_time(void **unused) {
    (void)unused;
    static const enum state resting[] = {STATE_SETTLED, STATE_READY, STATE_TESTING};
    struct params params = by_hand();
    int most = (int)lround(params.interlocks.discrepancy_s / params.loop.period_s);
    for (int k = 0; k < INPUTS; k++)
        for (unsigned h = 0; h < sizeof resting / sizeof *resting; h++) {
            struct rig rig;
            bool driven = resting[h] != STATE_SETTLED;
            rig_init(&rig, &params);
            rig_bring(&rig, resting[h], 20);
            contradicting = interlock_table[k].input;
            for (int n = 0; n < most; n++) rig_spoilt(&rig, contradict, 0);
            /* an open contact counts at once */
            assert_int_equal(rig.now.state, driven ? STATE_FAULT : STATE_SETTLED);
            assert_false(rig.now.faults & FAULT_ANTIVALENCE);
            rig_run(&rig, 1); /* the other contact follows */
            for (int n = 0; n < most; n++) rig_spoilt(&rig, contradict, 0);
            assert_false(rig.now.faults & FAULT_ANTIVALENCE);
            rig_spoilt(&rig, contradict, 0);
            assert_true(rig.now.faults & FAULT_ANTIVALENCE);
            assert_int_equal(rig.now.state, STATE_FAULT);
            if (!driven) assert_int_equal(rig.now.first_fault, FAULT_ANTIVALENCE);
            if (!driven) assert_line(&rig.now, interlock_table[k].name);
            plant_destroy(rig.plant);
        }
}

static void contacts_of_inputs_that_are_not_wired_may_say_what_they_like(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    params.interlocks.door = false;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 20);
    contradicting = INPUT_DOOR;
    for (int n = 0; n < 1000; n++) rig_spoilt(&rig, contradict, 0);
    assert_int_equal(rig.now.state, STATE_READY);
    plant_destroy(rig.plant);
}

/* ---- energy ---- */

static void without_pressure_in_time_there_is_a_fault_and_no_motion(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    params.interlocks.pressure_s = 1.0;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_PRESSURISING, 0);
    opened = INPUT_SUPPLY;
    int waited = 0;
    for (; rig.now.state == STATE_PRESSURISING; waited++) rig_spoilt(&rig, open_inputs, 0);
    assert_int_equal(rig.now.first_fault, FAULT_SUPPLY);
    assert_true(waited >= 500 && waited <= 500 + params.limits.bad_cycles);
    plant_destroy(rig.plant);
}

/* A welded relay or a stuck dump valve is found when the platform is to be engaged, not only in an
 * emergency. */
static void pressure_that_does_not_go_with_the_supply_refuses_engage(void **unused) {
    (void)unused;
    for (int output = 0; output < 2; output++) {
        struct params params = by_hand();
        struct rig rig;
        params.interlocks.supply = output;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_SETTLED, 20);
        rig_request(&rig, (struct request){.id = ++rig.id, .command = COMMAND_ENGAGE}, pressure_there, 0);
        /* without a supply output, another controller may have put the supply on */
        assert_int_equal(rig.platform.request_taken, !output);
        if (output) assert_non_null(strstr(supervisor_advice(STATE_SETTLED, platform_wrong(&rig.platform), COMMAND_ENGAGE), "although"));
        plant_destroy(rig.plant);
    }
}

/* A stuck spool is found while the supply is on and nothing is driven yet. */
static void a_spool_that_is_stuck_is_found_out_while_the_supply_comes(void **unused) {
    (void)unused;
    static const double stuck[] = {0.02, 0.1, 0.3};
    for (int k = 0; k < 3; k++) {
        struct params params = by_hand();
        struct plant_truth before, after;
        struct rig rig;
        params.interlocks.pressure = false;
        rig_init(&rig, &params);
        rig.stuck_valve = stuck[k];
        rig_bring(&rig, STATE_SETTLED, 0);
        plant_get_truth(rig.plant, &before);
        rig_cycle(&rig, COMMAND_ENGAGE);
        while (rig.now.state == STATE_PRESSURISING) rig_cycle(&rig, COMMAND_NONE);
        assert_int_equal(rig.now.first_fault, FAULT_FOLLOWING);
        rig_run(&rig, 100);
        plant_get_truth(rig.plant, &after);
        assert_close(before.pose[DOF_Z], after.pose[DOF_Z], 0.04);
        plant_destroy(rig.plant);
    }
}

/* The pressure switch of an earlier sample does not confirm the pressure. */
static void a_sample_that_was_not_read_is_no_pressure(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    params.limits.bad_cycles = 200;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_PRESSURISING, 0);
    spoil_cycles(&rig, flagged_io, 99);
    assert_int_equal(rig.now.state, STATE_PRESSURISING);
    /* pressure has built up by then, but doubtful samples do not confirm it */
    spoil_cycles(&rig, flagged_invalid, 50);
    assert_int_equal(rig.now.state, STATE_PRESSURISING);
    for (int n = 0; n < 50 && rig.now.state == STATE_PRESSURISING; n++) rig_cycle(&rig, COMMAND_NONE);
    assert_int_equal(rig.now.state, STATE_ENGAGING);
    plant_destroy(rig.plant);
}

static void without_the_pressure_input_it_waits_for_the_time_and_without_the_output_not_at_all(void **unused) {
    (void)unused;
    for (int output = 0; output < 2; output++) {
        struct params params = by_hand();
        struct rig rig;
        int waited = 0;
        params.interlocks.pressure = false, params.interlocks.supply = output, params.interlocks.pressure_s = 0.7;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_SETTLED, 0);
        rig_cycle(&rig, COMMAND_ENGAGE);
        for (; rig.now.state == STATE_PRESSURISING; waited++) rig_cycle(&rig, COMMAND_NONE);
        assert_int_equal(rig.now.state, STATE_ENGAGING);
        assert_int_equal(waited, output ? 350 : 0);
        plant_destroy(rig.plant);
    }
}

static void a_stop_while_the_supply_comes_takes_it_off_again(void **unused) {
    (void)unused;
    static const enum command stops[] = {COMMAND_STOP, COMMAND_PARK};
    struct params params = by_hand();
    for (int k = 0; k < 2; k++) {
        struct rig rig;
        rig_init(&rig, &params);
        rig_bring(&rig, STATE_PRESSURISING, 50);
        rig_cycle(&rig, stops[k]);
        assert_int_equal(rig.now.state, STATE_SETTLED);
        rig_run(&rig, 100);
        assert_false(pressure_of(&rig));
        plant_destroy(rig.plant);
    }
}

/* Returns how far the platform rises after the daemon has died during a move, on a device that does
 * not centre its valves because a spool sticks. */
static double risen_after_death(bool has_power_unit) {
    struct params params = by_hand();
    struct error error;
    struct plant_truth before, after;
    static const double stuck[LEGS] = {0.3, 0.3, 0.3, 0.3, 0.3, 0.3};
    struct plant *plant = plant_create(&params, 1, &error);
    assert_non_null(plant);
    if (has_power_unit) plant_add_power_unit(plant, params.device.watchdog_s);
    for (int n = 0; n < 400; n++) plant_life_sign(plant, n % 2), plant_step(plant, (const double[LEGS]){0});
    for (int n = 0; n < 150; n++) plant_life_sign(plant, n % 2), plant_step(plant, stuck);
    plant_get_truth(plant, &before);
    for (int n = 0; n < 500; n++) plant_step(plant, stuck);
    plant_get_truth(plant, &after);
    plant_destroy(plant);
    return before.pose[DOF_Z] - after.pose[DOF_Z];
}

static void a_stuck_spool_and_a_dead_daemon_drive_the_platform_no_further(void **unused) {
    (void)unused;
    double driven_m = risen_after_death(false), dumped_m = risen_after_death(true);
    print_message("# risen in the second after the daemon's death: %.0f mm with the supply on, %.0f mm with it lost\n", 1e3 * driven_m,
                  1e3 * dumped_m);
    assert_true(driven_m > 0.1);
    assert_true(dumped_m < 0.02);
}

static void the_relay_holds_while_the_level_changes_and_no_longer(void **unused) {
    (void)unused;
    static const double dt_s = 0.002, hold_s = 0.02;
    for (int every = 1; every <= 12; every++) {
        struct power_unit u;
        bool level = false, ever = false;
        power_unit_init(&u, hold_s);
        for (int n = 0; n < 500; n++) {
            if (n % every == 0) level = !level;
            power_unit_step(&u, level, dt_s);
            ever |= u.pressure;
        }
        assert_int_equal(ever, every <= 11); /* the relay stays closed for 20 ms without a change */
        double share = u.share;
        int lost = 0;
        for (; u.pressure; lost++) power_unit_step(&u, level, dt_s);
        if (every == 1) assert_true(share == 1.0);
        assert_true(lost <= 20);
        for (int n = 0; n < 1000; n++) power_unit_step(&u, level, dt_s);
        assert_true(u.share < 1e-9);
    }
}

/* ---- staged reactions ---- */

static void without_its_pressures_the_platform_is_put_down_slowly_and_then_latched(void **unused) {
    (void)unused;
    slow_case();
    struct params params = by_hand();
    for (int leg = 0; leg < LEGS; leg++)
        for (int h = 0; h < HELD; h++) {
            struct rig rig;
            struct plant_truth truth;
            rig_init(&rig, &params);
            rig_bring(&rig, held[h], 20);
            rig.largest_valve_step = 0.0;
            for (int n = 0; n < params.limits.bad_cycles; n++) rig_spoilt(&rig, no_pressures, leg);
            assert_int_equal(rig.now.state, STATE_PARKING);
            assert_int_equal(rig.now.faults, FAULT_PRESSURE_SENSOR | fault_leg(leg));
            int parking = 0;
            for (; rig.now.state == STATE_PARKING; parking++)
                rig_request(&rig, (struct request){.id = ++rig.id, .command = COMMAND_ENGAGE},
                                                                         /* parking takes its full
                                                                          * time */
                            no_pressures, leg);
            assert_int_equal(rig.now.state, STATE_FAULT);
            assert_int_equal(rig.now.first_fault, FAULT_PRESSURE_SENSOR);
            if (held[h] != STATE_PARKING) assert_true(parking >= 990);
            plant_get_truth(rig.plant, &truth);
            assert_close(truth.pose[DOF_Z], params.motion.park_z_m, 5e-3);
            assert_below(rig.largest_valve_step, 0.2);
            plant_destroy(rig.plant);
        }
}

static void while_it_is_put_down_what_control_needs_still_stops_it_and_one_bad_sample_does_not(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_READY, 20);
    for (int n = 0; n < params.limits.bad_cycles; n++) rig_spoilt(&rig, no_pressures, 2);
    for (int n = 0; n < 50; n++) rig_spoilt(&rig, n % 10 ? no_pressures : no_pressures_and_length, 2);
    assert_int_equal(rig.now.state, STATE_PARKING);
    for (int n = 1; n < params.limits.bad_cycles; n++) rig_spoilt(&rig, no_pressures_and_length, 2);
    assert_int_equal(rig.now.state, STATE_PARKING);
    rig_spoilt(&rig, no_pressures_and_length, 2);
    assert_int_equal(rig.now.state, STATE_FAULT);
    /* the headline names the cause of the stop */
    assert_int_equal(rig.now.first_fault, FAULT_SENSOR_INVALID);
    assert_true(rig.now.faults & FAULT_PRESSURE_SENSOR);
    plant_destroy(rig.plant);
}

static void pressures_that_come_back_do_not_undo_it(void **unused) {
    (void)unused;
    struct params params = by_hand();
    struct rig rig;
    rig_init(&rig, &params);
    rig_bring(&rig, STATE_TESTING, 20);
    for (int n = 0; n < params.limits.bad_cycles; n++) rig_spoilt(&rig, no_pressures, 4);
    rig_until(&rig, STATE_FAULT);
    assert_int_equal(rig.now.first_fault, FAULT_PRESSURE_SENSOR);
    rig_cycle(&rig, COMMAND_RESET);
    rig_until(&rig, STATE_SETTLED);
    rig_cycle(&rig, COMMAND_ENGAGE);
    rig_until(&rig, STATE_READY);
    plant_destroy(rig.plant);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_open_input_is_a_fault_in_its_first_cycle_and_takes_the_supply_off),
        cmocka_unit_test(an_open_input_refuses_engage_and_says_which),
        cmocka_unit_test(an_automatic_run_that_meets_an_open_input_is_over),
        cmocka_unit_test(an_automatic_run_is_over_once_an_input_was_open),
        cmocka_unit_test(an_input_opens_also_while_nothing_can_be_written),
        cmocka_unit_test(nothing_begins_on_a_doubtful_sample),
        cmocka_unit_test(a_reset_whose_cause_stands_is_not_taken),
        cmocka_unit_test(what_is_not_wired_is_not_watched_and_named),
        cmocka_unit_test(the_emergency_stop_is_the_headline),
        cmocka_unit_test(what_is_sent_is_read_as_it_was_and_one_wrong_bit_is_open_and_contradicts),
        cmocka_unit_test(contacts_that_contradict_each_other_are_a_fault_after_the_discrepancy_time),
        cmocka_unit_test(contacts_of_inputs_that_are_not_wired_may_say_what_they_like),
        cmocka_unit_test(without_pressure_in_time_there_is_a_fault_and_no_motion),
        cmocka_unit_test(pressure_that_does_not_go_with_the_supply_refuses_engage),
        cmocka_unit_test(a_spool_that_is_stuck_is_found_out_while_the_supply_comes),
        cmocka_unit_test(a_sample_that_was_not_read_is_no_pressure),
        cmocka_unit_test(without_the_pressure_input_it_waits_for_the_time_and_without_the_output_not_at_all),
        cmocka_unit_test(a_stop_while_the_supply_comes_takes_it_off_again),
        cmocka_unit_test(a_stuck_spool_and_a_dead_daemon_drive_the_platform_no_further),
        cmocka_unit_test(the_relay_holds_while_the_level_changes_and_no_longer),
        cmocka_unit_test(without_its_pressures_the_platform_is_put_down_slowly_and_then_latched),
        cmocka_unit_test(while_it_is_put_down_what_control_needs_still_stops_it_and_one_bad_sample_does_not),
        cmocka_unit_test(pressures_that_come_back_do_not_undo_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
