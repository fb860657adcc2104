/* The master's samples and commands: which cycle they belong to, and when they are valid. */
#include "can_bus_rig.h"

#include "can_frames.h"

static void every_command_reaches_its_own_leg_with_the_sync(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    /* tolerance: half a step of 16 bits */
    for (int i = 0; i < LEGS; i++) assert_close(can_node_output(&w.node[i]) / 32767.0, some[i], 0.5 / 32767);
    struct can_frame rpdo = can_frame_rpdo(0, (int16_t[]){1, 2, 3});
    struct can_queue q = {0};
    can_node_receive(&w.node[0], &rpdo, w.now_ns, &q);
    /* the new command takes effect only at the next SYNC */
    assert_close(can_node_output(&w.node[0]) / 32767.0, some[0], 0.5 / 32767);
}

static void the_sample_is_what_was_latched_at_the_sync_before(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    cycle(&w, centre);
    int64_t sync_ns = w.now_ns;
    w.reading[3].position = 1900000; /* the position changes after the SYNC */
    struct hal_sample s = cycle(&w, centre);
    assert_int_equal(s.flags, 0);
    assert_int_equal(s.time_ns, sync_ns);
    for (int i = 0; i < LEGS; i++) {
        assert_close(s.length_m[i], 1.831 + 1e-6 * i, 1e-12); /* rounding */
        assert_close(s.p1_pa[i], 5e6 + 1e3 * i, 1e-6);
        assert_close(s.p2_pa[i], 4e6 - 1e3 * i, 1e-6);
    }
    s = cycle(&w, centre);
    assert_close(s.length_m[3], 1.9, 1e-12);
}

static void a_lost_tpdo_makes_the_sample_stale_and_the_next_one_says_so(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    struct hal_sample before = cycle(&w, centre);
    w.wire.lose_tpdo_of = 4;
    cycle(&w, centre);
    w.wire.lose_tpdo_of = 0;
    w.reading[0].position += 100;
    for (int i = 0; i < 3; i++) { /* each of the next two SYNCs is followed by a pause of a cycle */
        struct hal_sample s = cycle(&w, centre);
        assert_int_equal(s.flags, SAMPLE_STALE | SAMPLE_LATE);
        assert_int_equal(s.device_seq, before.device_seq + 1);
    }
    assert_int_equal(cycle(&w, centre).flags, SAMPLE_DROPPED | SAMPLE_LATE);
    assert_int_equal(cycle(&w, centre).flags, SAMPLE_LATE);
    assert_int_equal(cycle(&w, centre).flags, 0);
    assert_int_equal(w.master.lost, 1);
}

/* All legs move by the same amount every cycle, so a difference beyond the legs' own offsets
 * reveals readings of different cycles. Returns true if all are of one cycle. */
static bool of_one_instant(struct world *w, const double valve[LEGS], struct hal_sample *s) {
    for (int k = 0; k < CAN_NODES; k++) w->reading[k].position += 1000;
    *s = cycle(w, valve);
    for (int k = 0; k < LEGS; k++)        /* tolerance for rounding; in one cycle the legs move by 1
                                           * mm */
        if (!(fabs(s->length_m[k] - s->length_m[0] - 1e-6 * k) < 1e-9)) return false;
    return true;
}

static void a_tpdo_a_cycle_late_is_of_its_own_sync_or_left_out_whatever_is_commanded(void **state) {
    struct world w;
    struct hal_sample s;
    uint64_t seed = 11;
    (void)state;
    bring_up(&w);
    for (int i = 0; i < 20000; i++) {
        /* alternates between occasionally late and always late */
        w.wire.late_by = i / 100 % 2 ? 1 : (int)random_below(&seed, 2);
        w.wire.lose_tpdo_of = random_below(&seed, 50) ? 0 : 1 + (int)random_below(&seed, CAN_NODES);
        bool one = of_one_instant(&w, random_below(&seed, 3) ? some : centre, &s);
        assert_true(one || s.flags & (SAMPLE_STALE | SAMPLE_LATE));
    }
}

static void a_leg_that_becomes_late_for_good_is_never_taken_for_punctual(void **state) {
    (void)state;
    for (int i = 0; i < LATE_MAX * LATE_MAX; i++) {
        struct world w;
        struct hal_sample s;
        int first = i / LATE_MAX, then = i % LATE_MAX;
        if (then == 0) continue;
        bring_up(&w);
        cycles(&w, 2, some);
        w.wire.late_by = first;
        cycle(&w, some);
        w.wire.late_by = then;
        cycle(&w, some);
        for (int k = 0; k < 1000; k++)
            if (!of_one_instant(&w, some, &s)) assert_true(s.flags & (SAMPLE_STALE | SAMPLE_LATE));
        w.wire.late_by = 0;
        cycles(&w, 2 * LATE_MAX, some);
        assert_true(of_one_instant(&w, some, &s));
        assert_int_equal(s.flags, 0);
    }
}

/* The pause that a missing TPDO causes is put off for a command that centres. */
static void the_command_that_centres_waits_for_no_tpdo(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    w.wire.lose_tpdo_of = 4;
    cycle(&w, some);
    assert_true(can_node_output(&w.node[5]) < -32000);
    cycle(&w, centre);
    for (int i = 0; i < LEGS; i++) assert_int_equal(can_node_output(&w.node[i]), 0);
}

static void without_commands_a_node_centres_its_valve_and_takes_no_late_one(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    w.wire.lose_rpdo = true;
    cycles(&w, 9, some);
    assert_true(can_node_output(&w.node[5]) < -32000); /* 18 ms without commands do not centre the
                                                        * valve */
    cycles(&w, 2, some);
    for (int i = 0; i < CAN_NODES; i++) {
        assert_int_equal(can_node_output(&w.node[i]), 0);
        assert_int_equal(w.node[i].state, CAN_PREOPERATIONAL);
        assert_int_equal(w.node[i].errors, 1u << CAN_ERROR_RPDO_TIMEOUT);
    }
    struct can_frame late = can_frame_rpdo(0, (int16_t[]){20000, 20000, 20000});
    struct can_queue q = {0};
    can_node_receive(&w.node[0], &late, w.now_ns, &q);
    can_node_sync(&w.node[0], &(struct can_frame){.can_id = COB_SYNC}, &w.reading[0], &q);
    assert_int_equal(can_node_output(&w.node[0]), 0);
    assert_false(can_master_ready(&w.master));
}

static void a_sync_that_the_bus_does_not_carry_yields_no_new_sample(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.wire.lose_echo = true;
    cycle(&w, centre);
    struct hal_sample s = cycle(&w, centre);
    assert_int_equal(w.master.unechoed, 2);
    assert_true(s.flags & SAMPLE_STALE);
}

static void what_is_not_enabled_is_the_centre(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    struct hal_command off = commands(&w, some);
    off.enable = false;
    can_master_command(&w.master, &off, &q);
    to_nodes(&w, &q);
    for (int i = 0; i < LEGS; i++) assert_int_equal(can_node_output(&w.node[i]), 0);
}

/* A controller's transmit queue has room for ten frames by default. */
static void no_cycle_sends_more_than_ten_frames(void **state) {
    struct world w;
    (void)state;
    power_on(&w);
    for (int i = 0; i < 2 * CYCLES_TO_RUN; i++) {
        struct can_queue q = {0};
        if (i == CYCLES_TO_RUN)
            for (int k = 0; k < CAN_NODES; k++) can_node_init(&w.node[k], k + 1, w.now_ns, &q);
        to_master(&w, &q);
        w.now_ns += ns_from_seconds(w.params.loop.period_s);
        can_master_poll(&w.master, w.now_ns, true, &q);
        struct hal_command command = commands(&w, some);
        can_master_command(&w.master, &command, &q);
        assert_true(q.count <= 10);
        to_nodes(&w, &q);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_command_reaches_its_own_leg_with_the_sync),
        cmocka_unit_test(the_sample_is_what_was_latched_at_the_sync_before),
        cmocka_unit_test(a_lost_tpdo_makes_the_sample_stale_and_the_next_one_says_so),
        cmocka_unit_test(a_tpdo_a_cycle_late_is_of_its_own_sync_or_left_out_whatever_is_commanded),
        cmocka_unit_test(a_leg_that_becomes_late_for_good_is_never_taken_for_punctual),
        cmocka_unit_test(the_command_that_centres_waits_for_no_tpdo),
        cmocka_unit_test(without_commands_a_node_centres_its_valve_and_takes_no_late_one),
        cmocka_unit_test(a_sync_that_the_bus_does_not_carry_yields_no_new_sample),
        cmocka_unit_test(what_is_not_enabled_is_the_centre),
        cmocka_unit_test(no_cycle_sends_more_than_ten_frames),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
