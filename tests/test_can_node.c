/* One node against CiA 301: NMT, EMCY, heartbeats and ownership; and no message on the bus
 * switches its watchdogs off. */
#include "can_node_rig.h"

#include "can_frames.h"

static void no_value_switches_the_rpdo_watchdog_off(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(download(&b, 0x1400, 5, 2, 0), SDO_TOO_LOW);
    assert_int_equal(download(&b, 0x1400, 5, 2, CAN_WATCHDOG_MAX_MS + 1), SDO_TOO_HIGH);
    assert_int_equal(value_of(&b, 0x1400, 5), 20);
    for (uint32_t ms = 1; ms <= 3; ms++) {
        assert_int_equal(download(&b, 0x1400, 5, 2, 10 * ms), 0);
        nmt(&b, NMT_START);
        drive(&b);
        assert_int_equal(can_node_output(&b.node), commanded());
        pass(&b, 10 * (int)ms, heartbeat, 1);
        assert_int_equal(can_node_output(&b.node), commanded());
        pass(&b, 1, heartbeat, 1);
        assert_int_equal(can_node_output(&b.node), 0);
        assert_int_equal(emergencies(&b, EMCY_RPDO_TIMEOUT), 1);
        assert_int_equal(b.node.state, CAN_PREOPERATIONAL);
    }
}

static void commands_that_no_sync_puts_into_force_are_a_timeout_too(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    drive(&b);
    pass(&b, 10, heartbeat, 1);
    for (int i = 0; i < 20; i++) {
        command(&b);
        pass(&b, 1, heartbeat, 1);
    }
    assert_int_equal(can_node_output(&b.node), 0);
    assert_int_equal(b.node.state, CAN_PREOPERATIONAL);
}

static void a_node_that_a_stranger_starts_keeps_its_output_at_zero_until_it_hears_the_master(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    for (int i = 0; i < 100; i++) {
        command(&b);
        sync_node(&b);
        assert_int_equal(can_node_output(&b.node), 0);
        pass(&b, PERIOD_MS, NULL, 1);
    }
    /* CiA 301: monitoring starts with the first heartbeat */
    assert_int_equal(b.node.state, CAN_OPERATIONAL);
    assert_int_equal(value_of(&b, b.node.dictionary->actual, 1), 0);
    heartbeat(&b);
    assert_int_equal(can_node_output(&b.node), 0); /* a command from before the heartbeat does not
                                                    * count */
    drive(&b);
    assert_int_equal(can_node_output(&b.node), commanded());
    int ms = 0;
    for (; can_node_output(&b.node) && ms < 1000; ms++) {
        command(&b);
        sync_node(&b);
        pass(&b, 1, NULL, 1);
    }
    assert_int_equal(ms, 151);
    assert_int_equal(b.node.errors, 1u << CAN_ERROR_HEARTBEAT);
}

static void a_node_that_watches_no_heartbeat_keeps_its_output_at_zero(void **state) {
    static const uint32_t off[] = {0, 150, (uint32_t)CAN_MASTER << 16, 200u << 16 | 150};
    (void)state;
    for (unsigned i = 0; i < sizeof off / sizeof *off; i++) {
        struct bench b;
        power_on(&b);
        assert_int_equal(download(&b, 0x1016, 1, 4, off[i]), 0);
        nmt(&b, NMT_START);
        for (int k = 0; k < 5; k++) drive(&b);
        assert_int_equal(can_node_output(&b.node), 0);
    }
}

static void two_heartbeats_are_watched_and_the_loss_of_either_is_one(void **state) {
    (void)state;
    for (int lost = 0; lost < 2; lost++) {
        struct bench b;
        power_on(&b);
        assert_int_equal(download(&b, 0x1016, 2, 4, 10u << 16 | 100), 0);
        nmt(&b, NMT_START);
        drive(&b);
        assert_int_equal(can_node_output(&b.node), 0); /* one of the two watched heartbeats does not
                                                        * suffice */
        for (int ms = 0; ms < 99; ms++) {
            if (ms == 0 || lost == 0) say(&b, can_frame_heartbeat(10, CAN_OPERATIONAL));
            if (ms == 0 || lost == 1) heartbeat(&b);
            command(&b);
            sync_node(&b);
            assert_int_equal(can_node_output(&b.node), commanded());
            pass(&b, 1, NULL, 1);
        }
        for (int ms = 0; ms < 60; ms++) {
            say(&b, can_frame_heartbeat(lost ? CAN_MASTER : 10, CAN_OPERATIONAL));
            command(&b);
            sync_node(&b);
            pass(&b, 1, NULL, 1);
        }
        assert_int_equal(can_node_output(&b.node), 0);
    }
}

static void the_consumers_rules_are_the_standards(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    /* the same node twice */
    assert_int_equal(download(&b, 0x1016, 2, 4, (uint32_t)CAN_MASTER << 16 | 100), SDO_INCOMPATIBLE);
    /* an unused entry is no duplicate */
    assert_int_equal(download(&b, 0x1016, 2, 4, (uint32_t)CAN_MASTER << 16), 0);
    /* reserved value */
    assert_int_equal(download(&b, 0x1016, 2, 4, 0x01000000), SDO_VALUE);
    /* its own number */
    assert_int_equal(download(&b, 0x1016, 2, 4, (uint32_t)node << 16 | 100), SDO_VALUE);
    /* the same entry rewritten */
    assert_int_equal(download(&b, 0x1016, 1, 4, (uint32_t)CAN_MASTER << 16 | 40), 0);
    pass(&b, 100, NULL, 1);
    assert_int_equal(emergencies(&b, EMCY_HEARTBEAT), 0); /* no heartbeat was received yet */
    say(&b, can_frame_heartbeat(CAN_MASTER, CAN_BOOTUP)); /* a boot-up is no heartbeat */
    pass(&b, 100, NULL, 1);
    assert_int_equal(emergencies(&b, EMCY_HEARTBEAT), 0);
    heartbeat(&b);
    pass(&b, 100, NULL, 1);
    assert_int_equal(emergencies(&b, EMCY_HEARTBEAT), 1); /* only once */
    assert_int_equal(value_of(&b, 0x1001, 0), 0x11);
    heartbeat(&b);
    assert_int_equal(emergencies(&b, EMCY_NONE), 1);
    assert_int_equal(value_of(&b, 0x1001, 0), 0);
}

static void nmt_commands_do_what_they_say_to_whom_they_say(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(b.out.count, 1); /* boot-up */
    assert_int_equal(b.out.frame[0].can_id, of_node(COB_HEARTBEAT));
    assert_int_equal(b.out.frame[0].len, 1);
    assert_int_equal(b.out.frame[0].data[0], 0);
    static const struct {
        enum can_nmt command;
        enum can_state state;
    } steps[] = {{NMT_START, CAN_OPERATIONAL}, {NMT_STOP, CAN_STOPPED},
                 {NMT_START, CAN_OPERATIONAL}, {NMT_PREOPERATIONAL, CAN_PREOPERATIONAL},
                 {NMT_STOP, CAN_STOPPED},      {NMT_PREOPERATIONAL, CAN_PREOPERATIONAL},
                 {NMT_START, CAN_OPERATIONAL}, {NMT_RESET_NODE, CAN_PREOPERATIONAL},
                 {NMT_STOP, CAN_STOPPED},      {NMT_RESET_COMMUNICATION, CAN_PREOPERATIONAL}};
    for (int all = 0; all < 2; all++)
        for (unsigned i = 0; i < sizeof steps / sizeof *steps; i++) {
            say(&b, can_frame_nmt(steps[i].command, all ? 0 : node));
            assert_int_equal(b.node.state, steps[i].state);
            /* only a reset sends a boot-up */
            assert_int_equal(sent(&b, COB_HEARTBEAT), steps[i].command >= NMT_RESET_NODE);
        }
    enum can_state before = b.node.state;
    say(&b, can_frame_nmt(NMT_START, node + 1));
    for (int code = 0; code < 256; code++)
        if (code != 1 && code != 2 && code < 128) say(&b, can_frame_nmt((enum can_nmt)code, node));
    for (int code = 131; code < 256; code++) say(&b, can_frame_nmt((enum can_nmt)code, 0));
    for (int length = 0; length <= 8; length++)
        if (length != 2) say(&b, frame(COB_NMT, length, "0102000000000000"));
    assert_int_equal(b.node.state, before);
    assert_int_equal(b.out.count, 0);
}

static void stopped_answers_nothing_but_nmt_and_goes_on_with_heartbeats(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(download(&b, 0x1017, 0, 2, 10), 0);
    nmt(&b, NMT_STOP);
    say(&b, frame(of_node(COB_SDO), 8, "4000100000000000"));
    assert_int_equal(b.out.count, 0);
    drive(&b);
    assert_int_equal(b.out.count, 0);
    pass(&b, 300, NULL, 1); /* the master's heartbeat is lost */
    assert_int_equal(sent(&b, COB_HEARTBEAT), 30);
    assert_int_equal(b.out.frame[0].data[0], CAN_STOPPED);
    assert_int_equal(sent(&b, COB_EMCY), 0);
}

static void a_reset_restores_the_defaults(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    struct can_node fresh = b.node;
    assert_int_equal(download(&b, 0x1017, 0, 2, 10), 0);
    assert_int_equal(download(&b, 0x1400, 5, 2, 7), 0);
    assert_int_equal(download(&b, 0x1005, 0, 4, 0x90), 0);
    nmt(&b, NMT_RESET_COMMUNICATION);
    assert_memory_equal(&fresh, &b.node, sizeof fresh);
}

static void the_history_keeps_the_newest_first_and_is_cleared_by_zero_only(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    for (int i = 0; i < 2 * CAN_HISTORY; i++) {
        say(&b, frame(of_node(COB_RPDO), i % 2 ? 1 : 4, "00000000"));
        command(&b);
        assert_int_equal(value_of(&b, 0x1003, 0), i < CAN_HISTORY ? i + 1 : CAN_HISTORY);
        assert_int_equal(value_of(&b, 0x1003, 1), i % 2 ? EMCY_RPDO_SHORT : EMCY_RPDO_LONG);
        if (i) assert_int_equal(value_of(&b, 0x1003, 2), i % 2 ? EMCY_RPDO_LONG : EMCY_RPDO_SHORT);
    }
    assert_int_equal(download(&b, 0x1003, 0, 1, 1), SDO_VALUE);
    assert_int_equal(download(&b, 0x1003, 1, 4, 0), SDO_READ_ONLY);
    assert_int_equal(download(&b, 0x1003, 0, 1, 0), 0);
    assert_int_equal(value_of(&b, 0x1003, 0), 0);
    assert_int_equal(upload(&b, 0x1003, 1).value, SDO_NO_DATA);
}

static void two_errors_stand_side_by_side_in_the_register(void **state) {
    struct bench b;
    struct can_tpdo broken = latched;
    const struct can_frame sync = can_frame_sync();
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    broken.p1 = INT16_MIN;
    b.out.count = 0;
    can_node_sync(&b.node, &sync, &broken, &b.out);
    assert_int_equal(emergencies(&b, EMCY_SENSOR), 1);
    assert_int_equal(value_of(&b, 0x1001, 0), 0x81);
    say(&b, frame(of_node(COB_RPDO), 1, "00"));
    assert_int_equal(b.out.frame[0].data[2], 0x91);
    command(&b);
    /* one error is over, one persists */
    assert_memory_equal(b.out.frame[0].data, frame(0, 8, "0000810000000000").data, 8);
    sync_node(&b);
    assert_memory_equal(b.out.frame[0].data, frame(0, 8, "0000000000000000").data, 8);
}

static void the_error_behaviour_is_preoperational_or_stopped_never_operational(void **state) {
    (void)state;
    for (uint32_t behaviour = 0; behaviour < 4; behaviour++) {
        struct bench b;
        power_on(&b);
        uint32_t abort = download(&b, 0x1029, 1, 1, behaviour);
        assert_int_equal(abort, behaviour % 2 ? SDO_VALUE : 0);
        nmt(&b, NMT_START);
        drive(&b);
        pass(&b, 30, NULL, 1);
        assert_int_equal(b.node.state, behaviour == 2 ? CAN_STOPPED : CAN_PREOPERATIONAL);
        assert_int_equal(emergencies(&b, EMCY_RPDO_TIMEOUT), 1);
        assert_int_equal(can_node_output(&b.node), 0);
    }
}

static void the_producer_time_takes_effect_at_once_and_zero_stops_it(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    pass(&b, 200, NULL, 1);
    assert_int_equal(b.out.count, 0);
    assert_int_equal(download(&b, 0x1017, 0, 2, 1000), 0);
    pass(&b, 10, NULL, 1);
    assert_int_equal(sent(&b, COB_HEARTBEAT), 1);
    assert_int_equal(download(&b, 0x1017, 0, 2, 10), 0); /* the new rate is in force at once, not a
                                                          * second later */
    pass(&b, 100, NULL, 1);
    assert_int_equal(sent(&b, COB_HEARTBEAT), 10);
    assert_int_equal(download(&b, 0x1017, 0, 2, 0), 0);
    pass(&b, 200, NULL, 1);
    assert_int_equal(b.out.count, 0);
}

static void only_its_owner_has_a_node_for_as_long_as_it_lives(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(value_of(&b, 0x2000, 3), 0);
    assert_int_equal(download(&b, 0x2000, 1, 4, 0), SDO_VALUE);
    assert_int_equal(download(&b, 0x2000, 1, 4, TOKEN), 0);
    assert_int_equal(value_of(&b, 0x2000, 3), 1);
    assert_int_equal(download(&b, 0x2000, 1, 4, TOKEN), 0); /* claims again, as after a lost
                                                             * answer */
    assert_int_equal(download(&b, 0x2000, 1, 4, OTHER), SDO_DENIED);
    assert_int_equal(download(&b, 0x2000, 2, 4, OTHER), SDO_DENIED);
    assert_int_equal(download(&b, 0x2000, 2, 4, 0), SDO_VALUE);
    assert_int_equal(upload(&b, 0x2000, 1).value, SDO_WRITE_ONLY);
    pass(&b, 1000, heartbeat, 50);
    assert_int_equal(download(&b, 0x2000, 1, 4, OTHER), SDO_DENIED);
    pass(&b, 101, NULL, 1);
    assert_int_equal(download(&b, 0x2000, 1, 4, OTHER), SDO_DENIED);
    pass(&b, 100, NULL, 1); /* the owner's heartbeat is lost */
    assert_int_equal(value_of(&b, 0x2000, 3), 0);
    assert_int_equal(download(&b, 0x2000, 1, 4, OTHER), 0);
}

static void an_nmt_reset_does_not_disown_and_power_does(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(download(&b, 0x2000, 1, 4, TOKEN), 0);
    assert_int_equal(download(&b, 0x1016, 1, 4, (uint32_t)CAN_MASTER << 16 | 3000), 0);
    nmt(&b, NMT_RESET_NODE);
    nmt(&b, NMT_RESET_COMMUNICATION);
    assert_int_equal(value_of(&b, 0x2000, 3), 1);
    pass(&b, 2900, NULL, 1); /* the owner's own time-out is in force, not the default */
    assert_int_equal(download(&b, 0x2000, 1, 4, OTHER), SDO_DENIED);
    struct can_queue q = {0};
    can_node_init(&b.node, node, b.now_ns, &q);
    assert_int_equal(download(&b, 0x2000, 1, 4, OTHER), 0);
}

static void a_node_whose_owner_never_speaks_leaves_operational(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(download(&b, 0x2000, 1, 4, TOKEN), 0);
    nmt(&b, NMT_START);
    pass(&b, 150, sync_node, 1);
    assert_int_equal(b.node.state, CAN_OPERATIONAL);
    pass(&b, 1, NULL, 1);
    assert_int_equal(b.node.state, CAN_PREOPERATIONAL);
    assert_int_equal(emergencies(&b, EMCY_HEARTBEAT), 1);
}

static void an_owner_that_leaves_is_no_error(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(download(&b, 0x2000, 1, 4, TOKEN), 0);
    heartbeat(&b);
    assert_int_equal(download(&b, 0x2000, 2, 4, TOKEN), 0);
    assert_int_equal(value_of(&b, 0x2000, 3), 0);
    pass(&b, 1000, NULL, 1);
    assert_int_equal(b.out.count, 0);
    assert_int_equal(download(&b, 0x2000, 2, 4, TOKEN), SDO_DENIED); /* no longer anybody's */
    assert_int_equal(download(&b, 0x2000, 1, 4, OTHER), 0);
}

int main(void) {
    const struct CMUnitTest common[] = {
        cmocka_unit_test(no_value_switches_the_rpdo_watchdog_off),
        cmocka_unit_test(commands_that_no_sync_puts_into_force_are_a_timeout_too),
        cmocka_unit_test(a_node_that_a_stranger_starts_keeps_its_output_at_zero_until_it_hears_the_master),
        cmocka_unit_test(a_node_that_watches_no_heartbeat_keeps_its_output_at_zero),
        cmocka_unit_test(two_heartbeats_are_watched_and_the_loss_of_either_is_one),
        cmocka_unit_test(the_consumers_rules_are_the_standards),
        cmocka_unit_test(nmt_commands_do_what_they_say_to_whom_they_say),
        cmocka_unit_test(stopped_answers_nothing_but_nmt_and_goes_on_with_heartbeats),
        cmocka_unit_test(a_reset_restores_the_defaults),
        cmocka_unit_test(the_error_behaviour_is_preoperational_or_stopped_never_operational),
        cmocka_unit_test(the_producer_time_takes_effect_at_once_and_zero_stops_it),
        cmocka_unit_test(only_its_owner_has_a_node_for_as_long_as_it_lives),
        cmocka_unit_test(an_nmt_reset_does_not_disown_and_power_does),
        cmocka_unit_test(a_node_whose_owner_never_speaks_leaves_operational),
        cmocka_unit_test(an_owner_that_leaves_is_no_error),
    };
    const struct CMUnitTest axis[] = {
        cmocka_unit_test(the_history_keeps_the_newest_first_and_is_cleared_by_zero_only),
        cmocka_unit_test(two_errors_stand_side_by_side_in_the_register),
    };
    int failed = cmocka_run_group_tests_name("axis", common, is_axis, NULL);
    failed += cmocka_run_group_tests_name("io", common, is_io, NULL);
    failed += cmocka_run_group_tests_name("axis, valve", axis, is_axis, NULL);
    return failed;
}
