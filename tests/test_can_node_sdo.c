/* SDO of one node against CiA 301: every object, requests and refusals. */
#include "can_node_rig.h"

#include "can_frames.h"

static void nothing_is_written_in_operational_but_the_end_of_the_error_history(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    for (int i = 0; i < b.node.dictionary->count; i++) {
        const struct can_object *o = &b.node.dictionary->object[i];
        if (o->access == CAN_CONST || o->access == CAN_RO) continue;
        struct can_node before = b.node;
        uint32_t value = o->access == CAN_WO ? TOKEN : o->value + (o->plus_node ? (uint32_t)node : 0);
        uint32_t abort = download(&b, o->index, o->sub, o->size, value);
        assert_int_equal(abort, o->index == 0x1003 ? 0 : SDO_DENIED);
        assert_memory_equal(&before, &b.node, sizeof before);
    }
}

static void a_download_that_does_not_say_its_size_is_taken(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    say(&b, frame(of_node(COB_SDO), 8, "22171000e8030000"));
    assert_memory_equal(b.out.frame[0].data, frame(0, 8, "6017100000000000").data, 8);
    assert_int_equal(value_of(&b, 0x1017, 0), 1000);
    say(&b, frame(of_node(COB_SDO), 8, "22190010aaaaaa00")); /* no such object */
    assert_int_equal(answer(&b).value, SDO_NO_OBJECT);
    /* the bytes after a one-byte value are ignored */
    say(&b, frame(of_node(COB_SDO), 8, "2219100005ffffff"));
    assert_int_equal(answer(&b).kind, SDO_DOWNLOAD);
    assert_int_equal(value_of(&b, 0x1019, 0), 5);
}

static void what_is_no_expedited_request_is_aborted_and_an_abort_is_not_answered(void **state) {
    static const char *const aborted[] = {        /* these begin a segmented download, or are its
                                                   * segments */
                                          "2117100002000000", "2017100002000000", "0000000000000000", "1000000000000000",
        /* these are segments of an upload, or begin a block upload */
                                          "6000000000000000", "7000000000000000", "a017100000000000",
        /* these begin a block download, or are unknown commands */
                                          "c017100000000000", "e017100000000000", "2617100001020304", "3317100001020304",
                                          "4117100000000000"};
    struct bench b;
    (void)state;
    power_on(&b);
    for (unsigned i = 0; i < sizeof aborted / sizeof *aborted; i++) {
        say(&b, frame(of_node(COB_SDO), 8, aborted[i]));
        assert_int_equal(answer(&b).kind, SDO_ABORT);
        assert_int_equal(answer(&b).value, SDO_COMMAND);
        bool named = aborted[i][3] == '7';
        assert_int_equal(answer(&b).index, named ? 0x1017 : 0);
    }
    say(&b, frame(of_node(COB_SDO), 8, "8017100000000405"));
    assert_int_equal(b.out.count, 0);
    for (int length = 0; length < 8; length++) {
        say(&b, frame(of_node(COB_SDO), length, "2b171000e803"));
        assert_int_equal(b.out.count, 0);
    }
    say(&b, frame(of_node(COB_SDO) + 1, 8, "4000100000000000")); /* another node's */
    assert_int_equal(b.out.count, 0);
}

static void every_object_is_read_and_refused_as_its_access_says(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    for (int i = 0; i < b.node.dictionary->count; i++) {
        const struct can_object *o = &b.node.dictionary->object[i];
        assert_non_null(o->name);
        assert_true(i == 0 || o->index > o[-1].index || (o->index == o[-1].index && o->sub > o[-1].sub));
        struct can_sdo reply = upload(&b, o->index, o->sub);
        bool empty = o->index == 0x1003 && o->sub;
        if (o->access == CAN_WO || empty) {
            assert_int_equal(reply.kind, SDO_ABORT);
            assert_int_equal(reply.value, empty ? SDO_NO_DATA : SDO_WRITE_ONLY);
        } else {
            assert_int_equal(reply.kind, SDO_UPLOAD);
            assert_int_equal(reply.size, o->size);
            assert_int_equal(reply.value, o->value + (o->plus_node ? (uint32_t)node : 0));
        }
        bool fixed = o->access == CAN_CONST || o->access == CAN_RO;
        if (fixed) assert_int_equal(download(&b, o->index, o->sub, o->size, 1), SDO_READ_ONLY);
        else assert_int_equal(download(&b, o->index, o->sub, o->size == 4 ? 2 : 4, 1), SDO_SIZE);
    }
    assert_int_equal(upload(&b, 0x1018, 5).value, SDO_NO_SUB);
    assert_int_equal(upload(&b, 0x5000, 0).value, SDO_NO_OBJECT);
    assert_int_equal(download(&b, 0x1400, 3, 2, 0), SDO_NO_SUB);
}

static void preoperational_answers_sdo_but_no_pdo(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    drive(&b);
    assert_int_equal(b.out.count, 0);
    assert_int_equal(can_node_output(&b.node), 0);
    assert_int_equal(value_of(&b, 0x6020, 1), 1831000); /* latched by the SYNC */
    assert_int_equal(value_of(&b, 0x6300, 1), 0);
}

int main(void) {
    const struct CMUnitTest common[] = {
        cmocka_unit_test(nothing_is_written_in_operational_but_the_end_of_the_error_history),
        cmocka_unit_test(a_download_that_does_not_say_its_size_is_taken),
        cmocka_unit_test(what_is_no_expedited_request_is_aborted_and_an_abort_is_not_answered),
        cmocka_unit_test(every_object_is_read_and_refused_as_its_access_says),
    };
    const struct CMUnitTest axis[] = {
        cmocka_unit_test(preoperational_answers_sdo_but_no_pdo),
    };
    int failed = cmocka_run_group_tests_name("axis", common, is_axis, NULL);
    failed += cmocka_run_group_tests_name("io", common, is_io, NULL);
    failed += cmocka_run_group_tests_name("axis, valve", axis, is_axis, NULL);
    return failed;
}
