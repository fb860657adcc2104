/* SYNC and PDOs of one node against CiA 301, and the I/O module's inputs and outputs. */
#include "can_node_rig.h"

#include "can_frames.h"

static void a_short_rpdo_is_an_emergency_and_no_command(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    drive(&b);
    say(&b, frame(of_node(COB_RPDO), 1, "70"));
    assert_int_equal(emergencies(&b, EMCY_RPDO_SHORT), 1);
    assert_int_equal(value_of(&b, 0x1001, 0), 0x11);
    say(&b, frame(of_node(COB_RPDO), 0, ""));
    assert_int_equal(b.out.count, 0); /* only once */
    assert_int_equal(value_of(&b, 0x6300, 1), 0x1000);
    command(&b);
    assert_int_equal(emergencies(&b, EMCY_NONE), 1);
    assert_int_equal(value_of(&b, 0x1003, 0), 1);
    assert_int_equal(value_of(&b, 0x1003, 1), EMCY_RPDO_SHORT);
    for (int i = 0; i < 21; i++) { /* without any heartbeat */
        say(&b, frame(of_node(COB_RPDO), 1, "70"));
        sync_node(&b);
        pass(&b, 1, heartbeat, 1);
    }
    assert_int_equal(b.node.state, CAN_PREOPERATIONAL);
}

static void a_long_rpdo_is_processed_and_told(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    heartbeat(&b);
    say(&b, frame(of_node(COB_RPDO), 4, "34120000"));
    assert_int_equal(emergencies(&b, EMCY_RPDO_LONG), 1);
    sync_node(&b);
    assert_int_equal(can_node_output(&b.node), 0x1234);
    command(&b);
    assert_int_equal(emergencies(&b, EMCY_NONE), 1);
}

static void sync_comes_with_the_identifier_and_length_that_are_set(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    const uint32_t refused[] = {0x000,
                                0x07f,
                                0x101,
                                0x180,
                                0x581,
                                0x67f,
                                0x6e0,
                                0x702,
                                0x7ff,
                                0x800,
                                0x40000080,
                                0x20000080,
                                of_node(COB_EMCY),
                                of_node(COB_RPDO),
                                of_node(COB_TPDO)};
    for (unsigned i = 0; i < sizeof refused / sizeof *refused; i++) assert_int_equal(download(&b, 0x1005, 0, 4, refused[i]), SDO_VALUE);
    assert_int_equal(download(&b, 0x1005, 0, 4, 0x90), 0);
    assert_int_equal(download(&b, 0x1019, 0, 1, 1), SDO_VALUE);
    assert_int_equal(download(&b, 0x1019, 0, 1, 241), SDO_VALUE);
    nmt(&b, NMT_START);
    say(&b, can_frame_sync());
    assert_int_equal(b.out.count, 0);
    say(&b, frame(0x90, 0, ""));
    assert_int_equal(sent(&b, COB_TPDO), 1);
    say(&b, frame(0x90, 1, "01"));
    assert_int_equal(sent(&b, COB_TPDO), 0);
    assert_int_equal(emergencies(&b, EMCY_SYNC_LENGTH), 1);
    nmt(&b, NMT_PREOPERATIONAL);
    assert_int_equal(download(&b, 0x1019, 0, 1, 240), 0);
    nmt(&b, NMT_START);
    say(&b, frame(0x90, 1, "01"));
    assert_int_equal(sent(&b, COB_TPDO), 1);
    say(&b, frame(0x90, 0, ""));
    assert_int_equal(emergencies(&b, EMCY_SYNC_LENGTH), 1);
}

static void every_transmission_type_that_is_taken_acts(void **state) {
    (void)state;
    for (uint32_t type = 0; type < 256; type++) {
        struct bench b;
        power_on(&b);
        uint32_t abort = download(&b, 0x1800, 2, 1, type);
        assert_int_equal(abort, type <= 240 ? 0 : SDO_VALUE);
        abort = download(&b, 0x1400, 2, 1, type);
        assert_int_equal(abort, type <= 240 || type >= 254 ? 0 : SDO_VALUE);
        nmt(&b, NMT_START);
        heartbeat(&b);
        command(&b);
        /* effective at once */
        assert_int_equal(can_node_output(&b.node), type >= 254 ? commanded() : 0);
        int tpdos = 0;
        for (int i = 0; i < 480; i++) {
            sync_node(&b);
            tpdos += sent(&b, COB_TPDO);
        }
        assert_int_equal(can_node_output(&b.node), commanded());
        /* type 0 is sent only when a reading has changed */
        assert_int_equal(tpdos, type == 0 ? 1 : type <= 240 ? (int)(480 / type) : 480);
    }
}

static void a_pdo_is_switched_off_before_its_identifier_changes(void **state) {
    (void)state;
    for (unsigned k = 0; k < 2; k++) {
        struct bench b;
        uint16_t index = k ? 0x1800 : 0x1400;
        uint32_t is = of_node(k ? COB_TPDO : COB_RPDO), off = 0x80000000u;
        power_on(&b);
        assert_int_equal(download(&b, index, 1, 4, 0x301), SDO_DENIED);
        assert_int_equal(download(&b, index, 1, 4, 0), SDO_VALUE);
        assert_int_equal(download(&b, index, 1, 4, is), 0); /* unchanged value */
        assert_int_equal(download(&b, index, 1, 4, off | is), 0);
        const uint32_t refused[] = {0x000, 0x07f, 0x080, of_node(COB_EMCY), 0x101, 0x180, 0x5ff, 0x601, 0x6ff, 0x77f, 0x800, 0x40000201};
        for (unsigned i = 0; i < sizeof refused / sizeof *refused; i++) assert_int_equal(download(&b, index, 1, 4, refused[i]), SDO_VALUE);
        /* the identifier of the node's other PDO */
        assert_int_equal(download(&b, index, 1, 4, of_node(k ? COB_RPDO : COB_TPDO)), SDO_VALUE);
        assert_int_equal(download(&b, index, 1, 4, 0x301), 0);
        nmt(&b, NMT_START);
        heartbeat(&b);
        say(&b, rpdo(k ? of_node(COB_RPDO) : 0x301));
        sync_node(&b);
        assert_int_equal(b.out.frame[0].can_id, k ? 0x301 : of_node(COB_TPDO));
        assert_int_equal(can_node_output(&b.node), commanded());
    }
}

static void a_pdo_that_is_off_neither_moves_nor_speaks(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(download(&b, 0x1400, 1, 4, 0x80000000u | of_node(COB_RPDO)), 0);
    assert_int_equal(download(&b, 0x1800, 1, 4, 0x80000000u | of_node(COB_TPDO)), 0);
    nmt(&b, NMT_START);
    drive(&b);
    assert_int_equal(b.out.count, 0);
    assert_int_equal(can_node_output(&b.node), 0);
}

static void the_mapping_is_changed_in_the_standards_order_only(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(download(&b, 0x1600, 0, 1, 0), SDO_DENIED); /* the PDO is valid */
    assert_int_equal(download(&b, 0x1400, 1, 4, 0x80000202), 0);
    /* its entries are in use */
    assert_int_equal(download(&b, 0x1600, 1, 4, MAP_DUMMY), SDO_DENIED);
    assert_int_equal(download(&b, 0x1600, 0, 1, 0), 0);
    assert_int_equal(download(&b, 0x1400, 1, 4, 0x202), SDO_DENIED); /* nothing is mapped */
    /* a reading is not writable */
    assert_int_equal(download(&b, 0x1600, 1, 4, 0x60200120), SDO_NOT_MAPPABLE);
    /* 32 bits of a 16-bit object */
    assert_int_equal(download(&b, 0x1600, 1, 4, 0x63000120), SDO_NOT_MAPPABLE);
    /* the watchdog is not mappable */
    assert_int_equal(download(&b, 0x1600, 1, 4, 0x14000510), SDO_NOT_MAPPABLE);
    /* dummy of the wrong type */
    assert_int_equal(download(&b, 0x1600, 1, 4, 0x00050008), SDO_NOT_MAPPABLE);
    assert_int_equal(download(&b, 0x1600, 1, 4, 0x50000010), SDO_NO_OBJECT);
    assert_int_equal(download(&b, 0x1600, 1, 4, 0x63000210), SDO_NO_SUB);
    assert_int_equal(download(&b, 0x1600, 4, 4, MAP_DUMMY), SDO_NO_SUB);
    assert_int_equal(download(&b, 0x1600, 1, 4, MAP_DUMMY), 0);
    assert_int_equal(download(&b, 0x1600, 2, 4, MAP_VALVE), 0);
    assert_int_equal(download(&b, 0x1600, 0, 1, 4), SDO_MAPPING_LENGTH);
    assert_int_equal(download(&b, 0x1600, 0, 1, 2), 0);
    assert_int_equal(download(&b, 0x1400, 1, 4, 0x202), 0);
    assert_int_equal(download(&b, 0x1a00, 0, 1, 0), SDO_READ_ONLY);
    nmt(&b, NMT_START);
    heartbeat(&b);
    say(&b, frame(0x202, 4, "11112222"));
    sync_node(&b);
    assert_int_equal(can_node_output(&b.node), 0x2222);
}

static void the_io_modules_mapping_and_error_values_are_fixed(void **state) {
    static const struct {
        uint16_t index;
        uint8_t sub;
        int size;
        uint32_t value;
    } fixed[] = {{0x1000, 0, 4, 0x00030191}, {0x1018, 2, 4, 0x4858494f}, {0x1600, 0, 1, 1},    {0x1600, 1, 4, 0x62000108},
                 {0x1a00, 0, 1, 1},          {0x1a00, 1, 4, 0x60000108}, {0x6206, 1, 1, 0xff}, {0x6207, 1, 1, 0}};
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(download(&b, 0x1400, 1, 4, 0x80000207), 0);
    for (unsigned i = 0; i < sizeof fixed / sizeof *fixed; i++) {
        assert_int_equal(value_of(&b, fixed[i].index, fixed[i].sub), fixed[i].value);
        assert_int_equal(download(&b, fixed[i].index, fixed[i].sub, fixed[i].size, 0), SDO_READ_ONLY);
    }
    assert_int_equal(download(&b, 0x6000, 1, 1, 0), SDO_READ_ONLY);
    assert_int_equal(download(&b, 0x6200, 1, 1, 1), SDO_DENIED); /* writable by RPDO only */
    assert_int_equal(upload(&b, 0x6300, 1).value, SDO_NO_OBJECT);
}

static void inputs_are_latched_by_sync_and_sent_as_they_are(void **state) {
    const struct can_frame sync = can_frame_sync();
    struct bench b;
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    for (unsigned inputs = 0; inputs <= 0xff; inputs++) {
        b.out.count = 0;
        can_node_sync(&b.node, &sync, &(struct can_tpdo){.inputs = (uint8_t)inputs}, &b.out);
        assert_int_equal(b.out.count, 1); /* the TPDO alone, because no value of the inputs means an
                                           * error */
        assert_int_equal(b.out.frame[0].can_id, 0x187);
        assert_int_equal(b.out.frame[0].len, 1);
        assert_int_equal(b.out.frame[0].data[0], inputs);
        assert_int_equal(value_of(&b, 0x6000, 1), inputs);
    }
}

static void outputs_are_in_force_with_the_sync_and_zero_without_a_master(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    say(&b, frame(0x207, 1, "ff"));
    sync_node(&b);
    assert_int_equal(value_of(&b, 0x6200, 1), 0); /* no heartbeat was received */
    heartbeat(&b);
    for (unsigned outputs = 0; outputs <= 0xff; outputs++) {
        say(&b, can_frame_outputs((uint8_t)outputs));
        assert_int_equal(value_of(&b, 0x6200, 1), outputs ? outputs - 1 : 0); /* not yet */
        sync_node(&b);
        assert_int_equal(can_node_output(&b.node), outputs);
        assert_int_equal(value_of(&b, 0x6200, 1), outputs);
    }
    pass(&b, 21, heartbeat, 1);
    assert_int_equal(can_node_output(&b.node), 0);
    assert_int_equal(value_of(&b, 0x6200, 1), 0);
    assert_int_equal(value_of(&b, 0x1003, 1), EMCY_RPDO_TIMEOUT);
}

static void an_rpdo_without_its_byte_is_no_command(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    nmt(&b, NMT_START);
    drive(&b);
    say(&b, frame(0x207, 0, ""));
    assert_int_equal(emergencies(&b, EMCY_RPDO_SHORT), 1);
    sync_node(&b);
    assert_int_equal(can_node_output(&b.node), 1);
    say(&b, frame(0x207, 2, "02ff"));
    assert_int_equal(emergencies(&b, EMCY_RPDO_LONG), 1);
    sync_node(&b);
    assert_int_equal(can_node_output(&b.node), 2);
}

static void in_preoperational_inputs_are_read_and_no_output_is_set(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    drive(&b);
    assert_int_equal(b.out.count, 0);
    assert_int_equal(can_node_output(&b.node), 0);
    assert_int_equal(value_of(&b, 0x6000, 1), INPUTS_ALL);
    assert_int_equal(value_of(&b, 0x6200, 1), 0);
}

int main(void) {
    const struct CMUnitTest common[] = {
        cmocka_unit_test(sync_comes_with_the_identifier_and_length_that_are_set),
        cmocka_unit_test(every_transmission_type_that_is_taken_acts),
        cmocka_unit_test(a_pdo_is_switched_off_before_its_identifier_changes),
        cmocka_unit_test(a_pdo_that_is_off_neither_moves_nor_speaks),
    };
    const struct CMUnitTest axis[] = {
        cmocka_unit_test(a_short_rpdo_is_an_emergency_and_no_command),
        cmocka_unit_test(a_long_rpdo_is_processed_and_told),
        cmocka_unit_test(the_mapping_is_changed_in_the_standards_order_only),
    };
    const struct CMUnitTest io[] = {
        cmocka_unit_test(the_io_modules_mapping_and_error_values_are_fixed),
        cmocka_unit_test(inputs_are_latched_by_sync_and_sent_as_they_are),
        cmocka_unit_test(outputs_are_in_force_with_the_sync_and_zero_without_a_master),
        cmocka_unit_test(an_rpdo_without_its_byte_is_no_command),
        cmocka_unit_test(in_preoperational_inputs_are_read_and_no_output_is_set),
    };
    int failed = cmocka_run_group_tests_name("axis", common, is_axis, NULL);
    failed += cmocka_run_group_tests_name("io", common, is_io, NULL);
    failed += cmocka_run_group_tests_name("axis, valve", axis, is_axis, NULL);
    failed += cmocka_run_group_tests_name("io, inputs and outputs", io, is_io, NULL);
    return failed;
}
