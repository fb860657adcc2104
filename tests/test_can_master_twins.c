/* Two devices with one number. */
#include "can_bus_rig.h"

#include <stdio.h>

#include "can_frames.h"

static void twin(struct world *w, int node, int um, unsigned inputs) {
    bring_up(w);
    w->wire.twin_of = node, w->wire.twin_percent = 100;
    w->wire.twin_adds = (struct can_tpdo){.position = um, .inputs = (uint8_t)inputs};
}

static void two_answers_of_a_leg_in_one_cycle_are_no_length_and_name_it(void **state) {
    (void)state;
    for (int node = 1; node <= LEGS; node++) {
        struct world w;
        twin(&w, node, node == 1 ? 700 : 1, 0);
        cycle(&w, some);
        for (int i = 0; i < 100; i++) {
            struct hal_sample s = cycle(&w, some);
            assert_true(s.flags & SAMPLE_TWIN);
            assert_int_equal(s.twins, 1u << (node - 1));
        }
        w.wire.twin_of = 0; /* without the twin, nothing is reported any more */
        assert_int_equal(cycles(&w, 300, some).flags, 0);
    }
}

/* The twin's TPDO shows the input closed; it comes before or after the node's, which shows it
 * open. */
static void an_input_is_open_if_any_answer_says_so(void **state) {
    static const uint8_t open[] = {0xe1, 0xd2, 0xb4, 0x78};
    (void)state;
    for (int antivalent = 0; antivalent < 2; antivalent++)
        for (unsigned k = 0; k < 4; k++)
            for (int first = 0; first < 2; first++) {
                struct world w;
                const uint8_t closed = 0x0f, says = antivalent ? open[k] : open[k] & 0x0f;
                twin(&w, CAN_IO, 0, first ? says : closed);
                w.params.interlocks.antivalent = antivalent;
                w.reading[CAN_IO - 1].inputs = first ? closed : says;
                struct hal_sample s = cycles(&w, 2, some);
                assert_int_equal(s.inputs, says & 0x0f);
                assert_true(s.flags & SAMPLE_TWIN);
                assert_int_equal(s.twins, 0);
            }
}

/* The twin must be found before its readings differ. Otherwise an emergency stop that one of the
 * two devices does not show would be its first sign. */
static void a_twin_that_says_the_same_is_found_within_a_tenth_of_a_second(void **state) {
    (void)state;
    for (int node = 1; node <= CAN_NODES; node++) {
        struct world w;
        char text[200];
        int cycle_count = 0;
        twin(&w, node, 0, 0);
        while (!(cycle(&w, some).flags & SAMPLE_TWIN)) cycle_count++;
        assert_in_range(cycle_count, 40, 52);
        condition(&w, text);
        char named[32];
        snprintf(named, sizeof named, "node %d answers twice", node);
        assert_non_null(strstr(text, named));
    }
}

static void a_bus_that_repeats_every_fifth_frame_is_no_twin(void **state) {
    struct world w;
    (void)state;
    twin(&w, 3, 0, 0);
    w.wire.twin_percent = 20;
    for (int i = 0; i < 50000; i++) assert_int_equal(cycle(&w, some).flags, 0);
    assert_true(w.master.twice > 9000);
}

static void one_frame_that_comes_twice_is_ridden_out(void **state) {
    struct world w;
    struct can_frame again;
    (void)state;
    bring_up(&w);
    for (int node = 1; node <= CAN_NODES; node++) {
        again = can_frame_tpdo(node, &w.reading[node - 1]);
        can_master_receive(&w.master, &again, false, w.now_ns);
        assert_int_equal(cycle(&w, some).flags, 0);
        again = can_frame_heartbeat(node, CAN_OPERATIONAL);
        can_master_receive(&w.master, &again, false, w.now_ns);
        assert_int_equal(cycle(&w, some).flags, 0);
    }
}

/* The twin receives no SYNC, or its TPDO is off, so only its heartbeats show it. */
static void a_twins_heartbeats_are_too_many_and_a_nodes_own_are_not(void **state) {
    (void)state;
    for (int twins = 0; twins < 2; twins++) {
        struct world w;
        int beat = 0, flagged = 0;
        bring_up(&w);
        int cycles_a_beat = (int)lround(w.params.can.heartbeat_s / w.params.loop.period_s);
        for (int i = 0; i < 40 * cycles_a_beat; i++) {
            const struct can_frame f = can_frame_heartbeat(4, CAN_OPERATIONAL);
            if (twins && i % cycles_a_beat == 7) can_master_receive(&w.master, &f, false, w.now_ns), beat++;
            struct hal_sample s = cycle(&w, some);
            flagged += (s.flags & SAMPLE_TWIN) != 0;
            if (s.flags & SAMPLE_TWIN) assert_int_equal(s.twins, 1u << 3);
        }
        assert_int_equal(flagged > 0, twins);
    }
}

static void a_twin_that_answers_the_set_up_is_found_in_it(void **state) {
    struct world w;
    (void)state;
    power_on(&w);
    w.wire.twin_of = 5, w.wire.twin_percent = 100;
    for (int i = 0; i < CYCLES_TO_RUN && !can_master_twin(&w.master); i++) cycle(&w, centre);
    assert_int_equal(can_master_twin(&w.master), 5);
}

static void frames_of_another_length_are_no_sign_of_life_and_are_judged(void **state) {
    struct world w;
    (void)state;
    twin(&w, 2, 0, 0);
    w.wire.twin_is_short = true;
    cycle(&w, some);
    for (int i = 0; i < 20; i++) assert_int_equal(cycle(&w, some).twins, 1u << 1);
    bring_up(&w);
    w.wire.dead_node = 6; /* another device sends two-byte heartbeats in its place */
    const struct can_frame strange = {.can_id = COB_HEARTBEAT + 6, .len = 2, .data = {CAN_OPERATIONAL}};
    for (int i = 0; i < 400; i++) {
        if (i % 50 == 0) can_master_receive(&w.master, &strange, false, w.now_ns);
        cycle(&w, some);
    }
    assert_int_equal(w.master.peer[5].phase, CAN_LOST);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_answers_of_a_leg_in_one_cycle_are_no_length_and_name_it),
        cmocka_unit_test(an_input_is_open_if_any_answer_says_so),
        cmocka_unit_test(a_twin_that_says_the_same_is_found_within_a_tenth_of_a_second),
        cmocka_unit_test(a_bus_that_repeats_every_fifth_frame_is_no_twin),
        cmocka_unit_test(one_frame_that_comes_twice_is_ridden_out),
        cmocka_unit_test(a_twins_heartbeats_are_too_many_and_a_nodes_own_are_not),
        cmocka_unit_test(a_twin_that_answers_the_set_up_is_found_in_it),
        cmocka_unit_test(frames_of_another_length_are_no_sign_of_life_and_are_judged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
