/* Nodes that are lost, reset or in error, and a bus that fails: what the master reports and
 * does. */
#include "can_bus_rig.h"

#include <linux/can/error.h>

#include "can_frames.h"

static void a_silent_bus_is_set_up_again_when_it_speaks(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.wire.lose_rpdo = true;
    cycles(&w, 15, some);
    assert_false(can_master_ready(&w.master));
    w.wire.lose_rpdo = false;
    struct hal_sample s = cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
    assert_int_equal(s.flags, 0);
}

static void without_the_daemons_heartbeat_the_valves_are_centred(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.wire.lose_heartbeat = true;
    int left = 0;
    for (; left < 200 && can_node_output(&w.node[0]) != 0; left++) cycle(&w, some);
    cycle(&w, some);
    left = 0;
    while (left < 200 && w.node[0].state == CAN_OPERATIONAL) cycle(&w, some), left++;
    assert_true(left < 80); /* limit: the heartbeat's time-out, 150 ms, and some cycles */
    assert_int_equal(can_node_output(&w.node[0]), 0);
}

static void a_lost_node_invalidates_samples_and_commands(void **state) {
    struct world w;
    struct hal_sample s;
    (void)state;
    bring_up(&w);
    w.wire.dead_node = 3;
    s = cycles(&w, 2, centre);
    assert_true(s.flags & SAMPLE_STALE);
    s = cycles(&w, 80, centre);
    assert_true(s.flags & SAMPLE_INVALID);
    assert_false(can_master_ready(&w.master));
    char text[200];
    can_condition_describe(can_master_condition(&w.master), &w.params, text, sizeof text);
    assert_non_null(strstr(text, "node 3 lost"));
}

static void a_node_that_was_reset_is_set_up_again_and_meanwhile_nothing_is_valid(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    can_node_init(&w.node[4], 5, w.now_ns, &q);
    to_master(&w, &q);
    assert_false(can_master_ready(&w.master));
    assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
    struct hal_sample s = cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
    assert_int_equal(s.flags, 0);
    assert_int_equal(w.master.boots, CAN_NODES + 1);
}

/* The node's boot-up is lost, and then the node stays silent, because its heartbeat is off until
 * set-up. */
static void a_lost_node_that_keeps_silent_is_asked_and_set_up_again(void **state) {
    struct world w;
    struct can_queue unheard = {0};
    (void)state;
    bring_up(&w);
    w.wire.dead_node = 3;
    can_node_init(&w.node[2], 3, w.now_ns, &unheard);
    cycles(&w, 500, centre);
    assert_int_equal(w.master.peer[2].phase, CAN_LOST);
    w.wire.dead_node = 0;
    struct hal_sample s = cycles(&w, 500, centre); /* the master asks a lost node twice a second */
    assert_true(can_master_ready(&w.master));
    assert_int_equal(s.flags, 0);
}

/* The platform handles a missing pressure; the node's EMCY 0x5000 does not make the sample
 * invalid. */
static void a_pressure_that_is_missing_is_no_number_and_the_sample_is_good_for_the_rest(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    struct can_tpdo good = w.reading[1];
    w.reading[1].p1 = INT16_MIN; /* the sensor's wire is broken */
    for (int i = 0; i < 5; i++) {
        cycle(&w, centre);
        struct hal_sample s = cycle(&w, centre);
        assert_int_equal(w.master.peer[1].emcy, EMCY_SENSOR);
        assert_int_equal(s.flags, 0);
        assert_true(isnan(s.p1_pa[1]) && isfinite(s.p2_pa[1]) && isfinite(s.length_m[1]) && isfinite(s.p1_pa[0]));
    }
    w.reading[1] = good;
    w.reading[2].position = INT32_MIN;
    cycle(&w, centre);
    assert_true(isnan(cycle(&w, centre).length_m[2]));
}

static void an_emergency_invalidates_the_sample_until_it_is_over(void **state) {
    static const uint16_t codes[] = {EMCY_SENSOR, EMCY_RPDO_SHORT, EMCY_RPDO_LONG, EMCY_SYNC_LENGTH, 0xff00};
    (void)state;
    for (int node = 1; node <= CAN_NODES; node++)
        for (unsigned i = 0; i < sizeof codes / sizeof *codes; i++) {
            struct world w;
            const struct can_frame stands = can_frame_emcy(node, codes[i], 0x81), over = can_frame_emcy(node, EMCY_NONE, 0);
            bring_up(&w);
            can_master_receive(&w.master, &stands, false, w.now_ns);
            assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
            assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
            can_master_receive(&w.master, &over, false, w.now_ns);
            assert_int_equal(cycle(&w, centre).flags, 0);
        }
}

static void a_missing_reading_hides_no_other_error_of_its_node(void **state) {
    (void)state;
    for (int first = 0; first < 2; first++) {
        struct world w;
        const struct can_frame other = can_frame_emcy(2, EMCY_RPDO_SHORT, 0x91);
        bring_up(&w);
        if (first) can_master_receive(&w.master, &other, false, w.now_ns);
        w.reading[1].p1 = INT16_MIN;
        cycle(&w, centre);
        cycle(&w, centre);
        if (!first) can_master_receive(&w.master, &other, false, w.now_ns);
        assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
    }
}

static void one_error_that_is_over_is_not_all_of_them(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    const struct can_frame both[] = {can_frame_emcy(2, EMCY_SENSOR, 0x81), can_frame_emcy(2, EMCY_RPDO_SHORT, 0x91),
                                     can_frame_emcy(2, EMCY_NONE, 0x81)};
    for (int i = 0; i < 3; i++) {
        can_master_receive(&w.master, &both[i], false, w.now_ns);
        assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
    }
    const struct can_frame over = can_frame_emcy(2, EMCY_NONE, 0);
    can_master_receive(&w.master, &over, false, w.now_ns);
    assert_int_equal(cycle(&w, centre).flags, 0);
}

static void bus_off_lets_no_command_through_until_the_bus_is_restarted(void **state) {
    struct world w;
    struct can_frame off = {.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF, .len = 8};
    struct can_frame restarted = {.can_id = CAN_ERR_FLAG | CAN_ERR_RESTARTED, .len = 8};
    struct hal_sample s;
    (void)state;
    bring_up(&w);
    can_master_receive(&w.master, &off, false, w.now_ns);
    assert_false(can_master_ready(&w.master));
    can_master_sample(&w.master, &s);
    assert_true(s.flags & SAMPLE_INVALID);
    can_master_receive(&w.master, &restarted, false, w.now_ns);
    assert_true(can_master_ready(&w.master));
}

static void error_passive_is_told_but_moves_on(void **state) {
    struct world w;
    struct can_frame passive = {.can_id = CAN_ERR_FLAG | CAN_ERR_CRTL, .len = 8, .data = {0, CAN_ERR_CRTL_TX_PASSIVE}};
    char text[200];
    (void)state;
    bring_up(&w);
    can_master_receive(&w.master, &passive, false, w.now_ns);
    assert_true(can_master_ready(&w.master));
    can_condition_describe(can_master_condition(&w.master), &w.params, text, sizeof text);
    assert_non_null(strstr(text, "error-passive"));
}

static void all_nodes_lost_are_told_as_all_and_one_as_one(void **state) {
    struct world w;
    char text[200];
    (void)state;
    bring_up(&w);
    for (int i = 0; i < CAN_NODES; i++) w.master.peer[i].phase = CAN_LOST;
    assert_string_equal(condition(&w, text), "all nodes lost");
    w.master.peer[CAN_IO - 1].phase = CAN_RUNNING;
    assert_string_equal(condition(&w, text), "node 1 lost, node 2 lost, node 3 lost, node 4 lost, node 5 lost, node 6 lost");
    bring_up(&w);
    w.master.peer[CAN_IO - 1].emcy = 0xff00;
    w.master.foreign = 0x7ff | FOREIGN_HEARD;
    assert_string_equal(condition(&w, text), "another master: frame (0x7ff), node 7 EMCY 0xff00");
}

/* The node is still operational, and an operational node refuses to have its watchdogs set. */
static void a_lost_node_that_is_still_operational_is_halted_and_set_up(void **state) {
    struct world w;
    (void)state;
    for (int stopped = 0; stopped < 2; stopped++) {
        bring_up(&w);
        w.master.peer[2].phase = CAN_LOST;
        if (stopped) w.node[2].state = CAN_STOPPED;
        cycles(&w, 2 * CYCLES_TO_RUN, centre);
        assert_true(can_master_ready(&w.master));
        assert_int_equal(w.node[2].state, CAN_OPERATIONAL);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_silent_bus_is_set_up_again_when_it_speaks),
        cmocka_unit_test(without_the_daemons_heartbeat_the_valves_are_centred),
        cmocka_unit_test(a_lost_node_invalidates_samples_and_commands),
        cmocka_unit_test(a_node_that_was_reset_is_set_up_again_and_meanwhile_nothing_is_valid),
        cmocka_unit_test(a_lost_node_that_keeps_silent_is_asked_and_set_up_again),
        cmocka_unit_test(a_pressure_that_is_missing_is_no_number_and_the_sample_is_good_for_the_rest),
        cmocka_unit_test(an_emergency_invalidates_the_sample_until_it_is_over),
        cmocka_unit_test(a_missing_reading_hides_no_other_error_of_its_node),
        cmocka_unit_test(one_error_that_is_over_is_not_all_of_them),
        cmocka_unit_test(bus_off_lets_no_command_through_until_the_bus_is_restarted),
        cmocka_unit_test(error_passive_is_told_but_moves_on),
        cmocka_unit_test(all_nodes_lost_are_told_as_all_and_one_as_one),
        cmocka_unit_test(a_lost_node_that_is_still_operational_is_halted_and_set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
