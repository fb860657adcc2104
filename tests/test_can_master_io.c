/* The I/O module behind the master: interlocks, and the life sign for the supply. */
#include "can_bus_rig.h"

static void inputs_are_what_was_latched_at_the_sync_before(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.params.interlocks.antivalent = false;
    for (unsigned inputs = 0; inputs <= 0xff; inputs++) {
        w.reading[CAN_IO - 1].inputs = (uint8_t)inputs;
        cycle(&w, centre);
        w.reading[CAN_IO - 1].inputs = (uint8_t)~inputs; /* the inputs change after the SYNC */
        struct hal_sample s = cycle(&w, centre);
        assert_int_equal(s.flags, 0);
        assert_int_equal(s.inputs, inputs & INPUTS_ALL);
        assert_int_equal(s.contradicted, 0);
    }
}

static void an_input_is_closed_where_both_of_its_contacts_say_so_and_told_where_they_contradict(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    for (unsigned bits = 0; bits <= 0xff; bits++) {
        w.reading[CAN_IO - 1].inputs = (uint8_t)bits;
        struct hal_sample s = cycles(&w, 2, centre);
        assert_int_equal(s.flags, 0);
        for (int i = 0; i < INPUTS; i++) {
            bool plain = bits >> i & 1, inverse = bits >> (i + 4) & 1;
            assert_int_equal(s.inputs >> i & 1, plain && !inverse);
            assert_int_equal(s.contradicted >> i & 1, plain == inverse);
        }
    }
}

/* In the cycle in which the door opens or its contacts contradict, a leg's TPDO is lost. */
static void what_opens_or_contradicts_does_not_wait_for_the_sample_to_be_whole(void **state) {
    (void)state;
    for (int inverse = 0; inverse < 2; inverse++) {
        struct world w;
        bring_up(&w);
        assert_int_equal(cycle(&w, centre).inputs, INPUTS_ALL);
        w.wire.lose_tpdo_of = 4;
        w.reading[CAN_IO - 1].inputs = (uint8_t)((INPUTS_ALL & ~INPUT_DOOR) | (inverse ? INPUT_DOOR << 4 : 0));
        cycle(&w, centre);
        struct hal_sample s = cycle(&w, centre);
        assert_true(s.flags & SAMPLE_STALE);
        assert_int_equal(s.inputs, INPUTS_ALL & ~INPUT_DOOR);
        assert_int_equal(s.contradicted, inverse ? 0 : INPUT_DOOR);
    }
}

static void what_contradicts_does_so_until_its_module_says_otherwise(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.reading[CAN_IO - 1].inputs = INPUTS_ALL & ~INPUT_DOOR;
    assert_int_equal(cycles(&w, 2, centre).contradicted, INPUT_DOOR);
    w.wire.lose_tpdo_of = CAN_IO;
    assert_int_equal(cycles(&w, 2, centre).contradicted, INPUT_DOOR);
}

static void without_node_7_nothing_is_closed_and_no_sample_is_whole(void **state) {
    struct world w;
    char text[200];
    (void)state;
    bring_up(&w);
    assert_int_equal(cycle(&w, centre).inputs, INPUTS_ALL);
    w.wire.lose_tpdo_of = CAN_IO;
    assert_true(cycles(&w, 2, centre).flags & SAMPLE_STALE);
    w.wire.lose_tpdo_of = 0;
    assert_int_equal(cycles(&w, 10, centre).flags, 0);
    w.wire.dead_node = CAN_IO;
    assert_true(cycles(&w, 2, centre).flags & SAMPLE_STALE);
    struct hal_sample s = cycles(&w, 80, centre);
    assert_true(s.flags & SAMPLE_INVALID);
    assert_int_equal(s.inputs, 0);
    assert_false(can_master_ready(&w.master));
    assert_string_equal(condition(&w, text), "node 7 lost");
    w.wire.dead_node = 0;
    s = cycles(&w, 500, centre); /* the master asks a lost node twice a second */
    assert_int_equal(s.flags, 0);
    assert_int_equal(s.inputs, INPUTS_ALL);
}

/* Counts the cycles in which the output changed. */
static int changes(struct world *w, int count) {
    int changed = 0;
    for (int i = 0; i < count; i++) {
        bool before = supply(w);
        cycle(w, some);
        changed += supply(w) != before;
    }
    return changed;
}

static void the_supply_output_changes_with_every_command_and_not_without(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    assert_int_equal(changes(&w, 100), 100);
    w.hangs = true;
    assert_int_equal(changes(&w, 100), 0);
    w.hangs = false;
    assert_int_equal(changes(&w, 10), 10);
    for (int i = 0; i < 20; i++) {
        bool before = supply(&w);
        w.now_ns += ns_from_seconds(w.params.loop.period_s);
        can_master_safe(&w.master, &q);
        to_nodes(&w, &q);
        assert_int_equal(supply(&w), before);
    }
    assert_int_equal(can_node_output(&w.node[5]), 0);
    assert_int_equal(changes(&w, 100), 100);
}

/* Every second cycle waits for the late leg, so an output that follows the commands would seem
 * constant. */
static void the_supply_output_changes_where_every_second_cycle_waits(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    w.wire.late_by = 1;
    cycles(&w, 10, some);
    int changed = changes(&w, 100);
    assert_in_range(changed, 45, 55);
    for (int i = 0; i < 20; i++) assert_true(changes(&w, 4) >= 1);
    w.hangs = true;
    cycles(&w, 2, some);
    assert_int_equal(changes(&w, 100), 0);
}

static void a_change_that_waits_is_not_made_up_for_by_safe(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    w.wire.late_by = 1;
    for (int tries = 0; w.master.pause != CAN_PAUSED || !w.master.due; tries++) {
        assert_true(tries < 20);
        cycle(&w, some);
    }
    bool before = supply(&w);
    for (int i = 0; i < 10; i++) {
        can_master_safe(&w.master, &q);
        to_nodes(&w, &q);
        assert_int_equal(supply(&w), before);
    }
}

static void without_its_rpdo_or_the_heartbeat_the_supply_output_is_off(void **state) {
    (void)state;
    for (int lost = 0; lost < 2; lost++) {
        struct world w;
        bring_up(&w);
        while (!supply(&w)) cycle(&w, some);
        w.wire.lose_outputs = lost == 0;
        w.wire.lose_heartbeat = lost == 1;
        int left = 0;
        for (; w.node[CAN_IO - 1].state == CAN_OPERATIONAL; left++) cycle(&w, some);
        assert_in_range(left, lost ? 48 : 9, lost ? 80 : 12); /* time-out of the heartbeat, 150 ms,
                                                               * or of the RPDO, 20 ms */
        assert_int_equal(can_node_output(&w.node[CAN_IO - 1]), 0);
        assert_int_equal(w.node[CAN_IO - 1].errors, 1u << (lost ? CAN_ERROR_HEARTBEAT : CAN_ERROR_RPDO_TIMEOUT));
        assert_true(cycle(&w, centre).flags & SAMPLE_INVALID);
        assert_int_equal(can_node_output(&w.node[0]), 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inputs_are_what_was_latched_at_the_sync_before),
        cmocka_unit_test(an_input_is_closed_where_both_of_its_contacts_say_so_and_told_where_they_contradict),
        cmocka_unit_test(what_opens_or_contradicts_does_not_wait_for_the_sample_to_be_whole),
        cmocka_unit_test(what_contradicts_does_so_until_its_module_says_otherwise),
        cmocka_unit_test(without_node_7_nothing_is_closed_and_no_sample_is_whole),
        cmocka_unit_test(the_supply_output_changes_with_every_command_and_not_without),
        cmocka_unit_test(the_supply_output_changes_where_every_second_cycle_waits),
        cmocka_unit_test(a_change_that_waits_is_not_made_up_for_by_safe),
        cmocka_unit_test(without_its_rpdo_or_the_heartbeat_the_supply_output_is_off),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
