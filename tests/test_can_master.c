/* The master beside other masters and strangers on its bus. */
#include "can_bus_rig.h"

#include <linux/can/error.h>

#include "can_frames.h"

static void no_frame_upsets_nodes_or_master(void **state) {
    struct world w;
    uint64_t seed = 7;
    (void)state;
    bring_up(&w);
    for (int i = 0; i < 200000; i++) {
        struct can_frame f = {.can_id = (canid_t)random_below(&seed, 0x800), .len = (uint8_t)random_below(&seed, 9)};
        struct can_queue q = {0};
        struct hal_sample s;
        if (random_below(&seed, 50) == 0) f.can_id |= CAN_ERR_FLAG;
        for (int k = 0; k < 8; k++) f.data[k] = (uint8_t)random_below(&seed, 256);
        can_master_receive(&w.master, &f, random_below(&seed, 2), w.now_ns);
        can_node_receive(&w.node[i % CAN_NODES], &f, w.now_ns, &q);
        can_node_tick(&w.node[i % CAN_NODES], w.now_ns, &q);
        can_master_sample(&w.master, &s);
        w.now_ns += 10 * NS_PER_US;
    }
}

static void another_masters_first_frame_flags_the_next_sample(void **state) {
    const struct can_sdo read = {SDO_UPLOAD, 0x1000, 0, 0, 0};
    const struct can_frame theirs[] = {can_frame_sync(),
                                       can_frame_nmt(NMT_RESET_NODE, 3),
                                       can_frame_nmt(NMT_START, 0),
                                       can_frame_rpdo(0, (int16_t[]){0, 0, 0}),
                                       can_frame_rpdo(1, (int16_t[]){0, 0, 0}),
                                       can_frame_sdo(6, &read),
                                       can_frame_sdo(7, &read),
                                       can_frame_outputs(0),
                                       can_frame_heartbeat(CAN_MASTER, CAN_OPERATIONAL),
                                       {.can_id = 0x202},
                                       {.can_id = COB_SYNC, .len = 1}};
    const struct can_frame harmless[] = {can_frame_sdo(8, &read),     can_frame_heartbeat(9, CAN_OPERATIONAL),
                                         {.can_id = 0x100, .len = 6}, {.can_id = 0x208, .len = 6},
                                         {.can_id = 0x7ff},           {.can_id = COB_SYNC | CAN_EFF_FLAG}};
    struct world w;
    char text[200];
    (void)state;
    bring_up(&w);
    for (unsigned i = 0; i < sizeof theirs / sizeof *theirs; i++) {
        assert_int_equal(cycle(&w, centre).flags, 0);
        uint64_t syncs = w.master.syncs;
        can_master_receive(&w.master, &theirs[i], false, w.now_ns);
        assert_int_equal(w.master.syncs, syncs); /* another master's SYNC opens no window */
        assert_non_null(strstr(condition(&w, text), "another master: "));
        assert_true(cycle(&w, centre).flags & SAMPLE_FOREIGN);
        /* only one sample is flagged, because the supervisor latches the fault */
        assert_false(cycle(&w, centre).flags & SAMPLE_FOREIGN);
        can_master_receive(&w.master, &theirs[i], true, w.now_ns); /* our own frame comes back as an
                                                                    * echo */
        assert_false(cycle(&w, centre).flags & SAMPLE_FOREIGN);
        cycles(&w, 5, centre); /* one surplus SYNC has passed */
    }
    for (unsigned i = 0; i < sizeof harmless / sizeof *harmless; i++) {
        can_master_receive(&w.master, &harmless[i], false, w.now_ns);
        assert_int_equal(cycle(&w, centre).flags, 0);
    }
}

static void a_node_of_another_master_is_left_alone_until_that_one_is_gone(void **state) {
    struct world w;
    char text[200];
    struct can_queue q = {0};
    const struct can_sdo theirs = {SDO_DOWNLOAD, 0x2000, 1, 4, TOKEN + 1};
    const struct can_frame claim = can_frame_sdo(5, &theirs), beat = can_frame_heartbeat(CAN_MASTER, CAN_OPERATIONAL);
    (void)state;
    power_on(&w);
    can_node_receive(&w.node[4], &claim, w.now_ns, &q);
    w.wire.lose_heartbeat = true; /* otherwise our heartbeat would keep the other master's claim
                                   * alive */
    for (int i = 0; i < 2 * CYCLES_TO_RUN; i++) {
        can_node_receive(&w.node[4], &beat, w.now_ns, &q);
        cycle(&w, centre);
        q.count = 0;
        assert_false(can_master_claimed(&w.master));
        assert_false(can_master_misfit(&w.master));
        assert_int_equal(w.node[4].state, CAN_PREOPERATIONAL);
    }
    assert_non_null(strstr(condition(&w, text), "node 5 owned by another master"));
    /* no heartbeat time was written to the node */
    assert_int_equal(w.node[4].value[can_object_find(w.node[4].dictionary, 0x1017, 0)], 0);
    cycles(&w, CYCLES_TO_RUN, centre);
    w.wire.lose_heartbeat = false;
    cycles(&w, 2 * CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
    assert_true(can_master_claimed(&w.master));
    assert_int_equal(w.node[4].owner.token, TOKEN);
}

static void a_master_that_leaves_centres_the_valves_and_gives_the_nodes_free(void **state) {
    struct world w;
    struct can_queue q = {0};
    (void)state;
    bring_up(&w);
    cycle(&w, some);
    can_master_leave(&w.master, &q);
    assert_int_equal(q.count, 1 + CAN_NODES);
    to_nodes(&w, &q);
    for (int i = 0; i < CAN_NODES; i++) {
        assert_int_equal(w.node[i].state, CAN_PREOPERATIONAL);
        assert_int_equal(can_node_output(&w.node[i]), 0);
        assert_int_equal(w.node[i].owner.token, 0);
    }
    can_master_init(&w.master, &w.params, TOKEN + 1);
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
}

static uint32_t write_object(struct can_node *n, uint16_t index, uint8_t sub, int size, uint32_t value) {
    const struct can_sdo request = {SDO_DOWNLOAD, index, sub, size, value};
    struct can_frame f = can_frame_sdo(n->id, &request);
    struct can_queue q = {0};
    struct can_sdo reply = {0};
    can_node_receive(n, &f, 1, &q);
    assert_int_equal(q.count, 1);
    assert_true(can_parse_sdo_reply(&q.frame[0], &reply));
    return reply.kind == SDO_ABORT ? reply.value : 0;
}

static void sdo_cannot_move_a_valve_nor_break_the_mapping(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    assert_int_equal(write_object(&w.node[0], 0x6300, 1, 2, 20000), SDO_DENIED);
    /* refused because the PDO is switched on */
    assert_int_equal(write_object(&w.node[0], 0x1600, 1, 4, MAP_DUMMY), SDO_DENIED);
    assert_int_equal(write_object(&w.node[0], 0x1400, 5, 4, 20), SDO_SIZE);
    assert_int_equal(write_object(&w.node[0], 0x1000, 0, 4, 1), SDO_READ_ONLY);
    assert_int_equal(write_object(&w.node[0], 0x2f00, 0, 4, 1), SDO_NO_OBJECT);
    assert_int_equal(write_object(&w.node[0], 0x1018, 9, 4, 1), SDO_NO_SUB);
    assert_int_equal(can_node_output(&w.node[0]), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_frame_upsets_nodes_or_master),
        cmocka_unit_test(another_masters_first_frame_flags_the_next_sample),
        cmocka_unit_test(a_node_of_another_master_is_left_alone_until_that_one_is_gone),
        cmocka_unit_test(a_master_that_leaves_centres_the_valves_and_gives_the_nodes_free),
        cmocka_unit_test(sdo_cannot_move_a_valve_nor_break_the_mapping),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
