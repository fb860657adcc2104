/* The master sets its nodes up: which nodes it starts, and which it refuses and why. */
#include "can_bus_rig.h"

#include <stdio.h>

#include "can_frames.h"

static void all_nodes_are_set_up_and_started(void **state) {
    struct world w;
    (void)state;
    bring_up(&w);
    for (int i = 0; i < CAN_NODES; i++) {
        assert_int_equal(w.node[i].state, CAN_OPERATIONAL);
        assert_int_equal(w.node[i].value[can_object_find(w.node[i].dictionary, 0x1400, 1)], can_rpdo_cob(can_group(i + 1)));
        assert_int_equal(w.node[i].value[can_object_find(w.node[i].dictionary, 0x1400, 5)], 20);
    }
}

static void a_node_with_another_mapping_is_not_started(void **state) {
    struct world w;
    (void)state;
    power_on(&w);
    w.node[2].value[can_object_find(w.node[2].dictionary, 0x1a00, 2)] = MAP_P2;
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_false(can_master_ready(&w.master));
    assert_int_not_equal(w.node[2].state, CAN_OPERATIONAL);
}

/* Covers every object that the set-up reads, found by its requests. */
static void a_node_that_answers_otherwise_is_not_started_whatever_it_is(void **state) {
    static const uint32_t asked[] = {0x100000, 0x101801, 0x101802, 0x101601, 0x101700, 0x102901, 0x100500, 0x140001, 0x140002, 0x140005,
                                     0x160000, 0x160001, 0x160002, 0x160003, 0x180001, 0x180002, 0x1a0000, 0x1a0001, 0x1a0002, 0x1a0003};
    (void)state;
    for (unsigned i = 0; i < sizeof asked / sizeof *asked; i++) {
        struct world w;
        char text[200], object[32];
        uint16_t index = (uint16_t)(asked[i] >> 8);
        uint8_t sub = (uint8_t)asked[i];
        power_on(&w);
        w.wire.lying_node = 4;
        w.wire.lie = (struct can_sdo){SDO_UPLOAD, index, sub, can_axis.object[can_object_find(&can_axis, index, sub)].size, 77};
        cycles(&w, CYCLES_TO_RUN, centre);
        assert_false(can_master_ready(&w.master));
        assert_int_equal(w.node[3].state, CAN_PREOPERATIONAL);
        assert_int_equal(w.node[4].state, CAN_OPERATIONAL);
        assert_true(can_master_misfit(&w.master));
        snprintf(object, sizeof object, "0x%04x:%u", index, sub);
        if (!strstr(condition(&w, text), "node 4") || !strstr(text, object) || !strstr(text, "0x4d")) fail_msg("%s: %s", object, text);
        w.wire.lying_node = 0; /* the node was replaced */
        cycles(&w, 2 * CYCLES_TO_RUN, centre);
        assert_true(can_master_ready(&w.master));
    }
}

static void a_node_of_another_vendor_runs_when_it_is_configured(void **state) {
    static const uint32_t objects[] = {0x100000, 0x101801, 0x101802};
    (void)state;
    for (int k = 0; k < 3; k++)
        for (int any = 0; any < 2; any++) {
            struct world w;
            power_on(&w);
            double *keys[] = {&w.params.can.device_type, &w.params.can.vendor_id, &w.params.can.product_code};
            *keys[k] = any ? -1.0 : 4294967295.0;
            w.wire.lying_node = 1;
            w.wire.lie = (struct can_sdo){SDO_UPLOAD, (uint16_t)(objects[k] >> 8), (uint8_t)objects[k], any ? 4 : 0, 0xffffffff};
            int place = can_object_find(&can_axis, w.wire.lie.index, w.wire.lie.sub);
            for (int i = 1; i < LEGS; i++) w.node[i].value[place] = 0xffffffff;
            cycles(&w, CYCLES_TO_RUN, centre);
            assert_true(can_master_ready(&w.master));
        }
}

/* A rebooted module may have other inputs than before; a module that only lost the daemon has the
 * same ones. */
static void an_io_module_that_boots_closes_nothing_until_it_is_set_up(void **state) {
    for (int boots = 0; boots < 2; boots++) {
        struct world w;
        struct can_queue q = {0};
        (void)state;
        bring_up(&w);
        if (boots) can_node_init(&w.node[CAN_IO - 1], CAN_IO, w.now_ns, &q);
        to_master(&w, &q);
        w.wire.lose_outputs = !boots;
        while (w.master.peer[CAN_IO - 1].phase == CAN_RUNNING) cycle(&w, centre);
        w.wire.lose_outputs = false;
        struct hal_sample s = cycle(&w, centre);
        assert_true(s.flags & SAMPLE_INVALID);
        assert_int_equal(s.inputs, boots ? 0 : INPUTS_ALL);
        for (int i = 0; s.flags & (SAMPLE_INVALID | SAMPLE_STALE); i++) {
            assert_true(i < CYCLES_TO_RUN);
            assert_int_equal(s.inputs, boots ? 0 : INPUTS_ALL);
            s = cycle(&w, centre);
        }
        assert_int_equal(s.inputs, INPUTS_ALL);
    }
}

static void an_io_module_that_answers_otherwise_is_not_started_whatever_it_is(void **state) {
    static const uint32_t asked[] = {0x100000, 0x101801, 0x101802, 0x101601, 0x101700, 0x102901, 0x100500, 0x140001, 0x140002,
                                     0x140005, 0x160000, 0x160001, 0x180001, 0x180002, 0x1a0000, 0x1a0001, 0x620601, 0x620701};
    (void)state;
    for (unsigned i = 0; i < sizeof asked / sizeof *asked; i++) {
        struct world w;
        char text[200], object[32];
        uint16_t index = (uint16_t)(asked[i] >> 8);
        uint8_t sub = (uint8_t)asked[i];
        power_on(&w);
        w.wire.lying_node = CAN_IO;
        w.wire.lie = (struct can_sdo){SDO_UPLOAD, index, sub, can_io.object[can_object_find(&can_io, index, sub)].size, 77};
        cycles(&w, CYCLES_TO_RUN, centre);
        assert_false(can_master_ready(&w.master));
        assert_int_equal(w.node[CAN_IO - 1].state, CAN_PREOPERATIONAL);
        assert_true(can_master_misfit(&w.master));
        snprintf(object, sizeof object, "0x%04x:%u", index, sub);
        if (!strstr(condition(&w, text), "node 7") || !strstr(text, object) || !strstr(text, "0x4d")) fail_msg("%s: %s", object, text);
        if (asked[i] == 0x101802)
            assert_string_equal(text, "node 7: another device, 0x1018:2 is 0x4d, not 0x4858494f (can.io_product_code)");
    }
}

static void an_io_module_of_another_vendor_runs_when_it_is_configured(void **state) {
    struct world w;
    struct params p;
    (void)state;
    config_default(&p);
    p.can.io_device_type = p.can.io_vendor_id = -1.0, p.can.io_product_code = 77.0;
    power_on_with(&w, &p);
    struct can_node *n = &w.node[CAN_IO - 1];
    for (int i = 0; i < n->dictionary->count; i++)
        if (n->dictionary->object[i].index == 0x1000 || n->dictionary->object[i].index == 0x1018) n->value[i] = 77;
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
}

static void where_nothing_is_wired_there_are_six_nodes_and_no_frame_for_a_seventh(void **state) {
    for (int there = 0; there < 2; there++) {
        struct world w;
        struct params p = not_wired();
        char text[200];
        (void)state;
        power_on_with(&w, &p);
        w.wire.dead_node = there ? 0 : CAN_IO;
        struct hal_sample s = cycles(&w, CYCLES_TO_RUN, some);
        assert_true(can_master_ready(&w.master));
        assert_int_equal(s.flags, 0);
        assert_int_equal(s.inputs, 0);
        assert_int_equal(w.to_node_7, 0);
        assert_int_equal(w.node[CAN_IO - 1].state, CAN_PREOPERATIONAL);
        assert_string_equal(condition(&w, text), "");
        can_master_init(&w.master, &p, TOKEN);
        assert_string_equal(condition(&w, text), "all nodes lost");
    }
}

static void an_abort_is_told_as_what_it_is(void **state) {
    struct world w;
    char text[200];
    (void)state;
    power_on(&w);
    w.wire.lying_node = 3;
    w.wire.lie = (struct can_sdo){SDO_ABORT, 0x1400, 5, 0, SDO_VALUE};
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_string_equal(condition(&w, text), "node 3 refused 0x1400:5: abort 0x06090030, value out of range");
    w.wire.lie = (struct can_sdo){SDO_ABORT, 0x1017, 0, 0, 0x08000000};
    cycles(&w, 2 * CYCLES_TO_RUN, centre);
    assert_string_equal(condition(&w, text), "node 3 refused 0x1017:0: abort 0x08000000");
    assert_int_equal(w.node[2].state, CAN_PREOPERATIONAL);
}

static void a_node_without_ownership_is_driven_all_the_same(void **state) {
    struct world w;
    (void)state;
    power_on(&w);
    w.wire.lying_node = 2;
    w.wire.lie = (struct can_sdo){SDO_ABORT, 0x2000, 1, 0, SDO_NO_OBJECT};
    cycles(&w, CYCLES_TO_RUN, centre);
    assert_true(can_master_ready(&w.master));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_nodes_are_set_up_and_started),
        cmocka_unit_test(a_node_with_another_mapping_is_not_started),
        cmocka_unit_test(a_node_that_answers_otherwise_is_not_started_whatever_it_is),
        cmocka_unit_test(a_node_of_another_vendor_runs_when_it_is_configured),
        cmocka_unit_test(an_io_module_that_boots_closes_nothing_until_it_is_set_up),
        cmocka_unit_test(an_io_module_that_answers_otherwise_is_not_started_whatever_it_is),
        cmocka_unit_test(an_io_module_of_another_vendor_runs_when_it_is_configured),
        cmocka_unit_test(where_nothing_is_wired_there_are_six_nodes_and_no_frame_for_a_seventh),
        cmocka_unit_test(an_abort_is_told_as_what_it_is),
        cmocka_unit_test(a_node_without_ownership_is_driven_all_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
