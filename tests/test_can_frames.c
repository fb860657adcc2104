/* Frames agree with the standard, and so does the time that they take on the bus. */
#include "can_bus_rig.h"

#include "can_frames.h"

static void tpdo_comes_back_as_it_was(void **state) {
    uint64_t seed = 1;
    (void)state;
    for (int i = 0; i < 1000; i++) {
        struct can_tpdo in = {.position = (int32_t)(random_unit(&seed) * 2147483647.0),
                              .p1 = (int16_t)(random_unit(&seed) * 32767.0),
                              .p2 = (int16_t)(random_unit(&seed) * 32767.0),
                              .inputs = (uint8_t)random_below(&seed, 256)},
                        out;
        struct can_frame f = can_frame_tpdo(1 + i % CAN_NODES, &in);
        assert_int_equal(can_frame_node(&f, COB_TPDO), 1 + i % CAN_NODES);
        assert_true(can_parse_tpdo(&f, &out));
        if (1 + i % CAN_NODES == CAN_IO) {
            assert_int_equal(f.len, 1);
            assert_int_equal(in.inputs, out.inputs);
            continue;
        }
        assert_int_equal(in.position, out.position);
        assert_int_equal(in.p1, out.p1);
        assert_int_equal(in.p2, out.p2);
    }
}

/* The expected bytes are from CiA 301, 7.2.4.3.3 and 7.2.4.3.6. */
static void sdo_frames_are_the_standards(void **state) {
    static const uint8_t write_1017[8] = {0x2b, 0x17, 0x10, 0x00, 0xe8, 0x03, 0, 0}, read_1000[8] = {0x40, 0x00, 0x10, 0x00},
                         written[8] = {0x60, 0x17, 0x10, 0x00}, is_198[8] = {0x43, 0x00, 0x10, 0x00, 0x98, 0x01},
                         aborted[8] = {0x80, 0x17, 0x10, 0x00, 0x02, 0x00, 0x01, 0x06};
    const struct can_sdo download = {SDO_DOWNLOAD, 0x1017, 0, 2, 1000}, upload = {SDO_UPLOAD, 0x1000, 0, 4, 0x198},
                         abort = {SDO_ABORT, 0x1017, 0, 0, SDO_READ_ONLY};
    (void)state;
    assert_memory_equal(can_frame_sdo(1, &download).data, write_1017, 8);
    assert_memory_equal(can_frame_sdo(1, &upload).data, read_1000, 8);
    assert_memory_equal(can_frame_sdo_reply(1, &download).data, written, 8);
    assert_memory_equal(can_frame_sdo_reply(1, &upload).data, is_198, 8);
    assert_memory_equal(can_frame_sdo_reply(1, &abort).data, aborted, 8);
}

static int stuffed_bits(const uint8_t *bit, int count) {
    int stuffed = 0, run = 0, last = -1;
    for (int i = 0; i < count; i++) {
        run = bit[i] == last ? run + 1 : 1;
        last = bit[i];
        if (run == 5) stuffed++, last = !last, run = 1;
    }
    return stuffed;
}

/* The worst case is 11111 0000 1111 ...: each stuff bit is the first of the next five. */
static void frame_bits_are_the_worst_that_stuffing_can_do(void **state) {
    (void)state;
    for (int n = 0; n <= 8; n++) {
        uint8_t bit[34 + 64];
        int count = 34 + 8 * n;
        for (int i = 0; i < count; i++) bit[i] = i < 5 || (i - 5) / 4 % 2;
        /* 13 bits: delimiters, acknowledge, end of frame, interframe space */
        assert_int_equal(can_frame_bits(n), count + stuffed_bits(bit, count) + 13);
    }
}

static void bus_load_at_a_megabit_and_two_milliseconds_is_sixty_three_percent_or_less(void **state) {
    struct params p = not_wired();
    (void)state;
    assert_int_equal(can_load(&p).cycle_bits, can_frame_bits(0) + 6 * can_frame_bits(8) + 2 * can_frame_bits(6));
    config_default(&p);
    struct can_load l = can_load(&p);
    assert_int_equal(l.cycle_bits, can_frame_bits(0) + 6 * can_frame_bits(8) + 2 * can_frame_bits(6) + 2 * can_frame_bits(1));
    assert_true(l.share > 0.6 && l.share < 0.63 && l.share < l.limit);
    p.can.bitrate_bps = 500e3;
    assert_true(can_load(&p).share > can_load(&p).limit);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tpdo_comes_back_as_it_was),
        cmocka_unit_test(sdo_frames_are_the_standards),
        cmocka_unit_test(frame_bits_are_the_worst_that_stuffing_can_do),
        cmocka_unit_test(bus_load_at_a_megabit_and_two_milliseconds_is_sixty_three_percent_or_less),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
