/* One node against CiA 301: SDO, NMT, EMCY, heartbeats, SYNC, PDOs; and no message on the bus
 * switches its watchdogs off. */
#include "support.h"

#include <stdio.h>

#include "can_node.h"
#include "units.h"

enum { MS = 1000000, PERIOD_MS = 2, TOKEN = 0x1234567, OTHER = 0x7654321 };
static const struct can_tpdo latched = {.position = 1831000, .p1 = 5000, .p2 = 4000, .inputs = INPUTS_ALL};
static int node = 2; /* an axis or CAN_IO; both share one implementation, and claims that name no
                      * valve run with both */

static unsigned of_node(unsigned function) { return function + (unsigned)node; }

struct bench {
    struct can_node node;
    struct can_queue out; /* frames sent since the last say() or pass() */
    int64_t now_ns;
};

static void power_on(struct bench *b) {
    *b = (struct bench){.now_ns = NS_PER_S};
    can_node_init(&b->node, node, b->now_ns, &b->out);
}

static void say(struct bench *b, struct can_frame f) {
    b->out.count = 0;
    if (can_node_synced_by(&b->node, &f)) can_node_sync(&b->node, &f, &latched, &b->out);
    else can_node_receive(&b->node, &f, b->now_ns, &b->out);
}

/* Lets `ms` milliseconds pass and calls done() every `period` ms. */
static void pass(struct bench *b, int ms, void (*done)(struct bench *), int period) {
    struct can_queue all = {0};
    for (int i = 0; i < ms; i++) {
        b->now_ns += MS;
        if (done && i % period == 0) done(b);
        b->out.count = 0;
        can_node_tick(&b->node, b->now_ns, &b->out);
        for (int k = 0; k < b->out.count; k++) can_queue_push(&all, b->out.frame[k]);
    }
    b->out = all;
}

static struct can_frame frame(unsigned cob, int length, const char *hex) {
    struct can_frame f = {.can_id = cob, .len = (uint8_t)length};
    for (int i = 0; i < length; i++) {
        unsigned byte = 0;
        if (*hex) sscanf(hex + 2 * i, "%2x", &byte);
        f.data[i] = (uint8_t)byte;
    }
    return f;
}

static void nmt(struct bench *b, enum can_nmt command) { say(b, can_frame_nmt(command, node)); }
static void heartbeat(struct bench *b) { say(b, can_frame_heartbeat(CAN_MASTER, CAN_OPERATIONAL)); }
static void sync_node(struct bench *b) { say(b, can_frame_sync()); }
static int16_t commanded(void) { return node == CAN_IO ? 1 : 0x1000; }
static struct can_frame rpdo(unsigned cob) { return node == CAN_IO ? frame(cob, 1, "01") : frame(cob, 2, "0010"); }
static void command(struct bench *b) { say(b, rpdo(of_node(COB_RPDO))); }
static void drive(struct bench *b) {
    heartbeat(b);
    command(b);
    sync_node(b);
}

static struct can_sdo answer(struct bench *b) {
    struct can_sdo reply = {0};
    assert_true(b->out.count >= 1);
    assert_int_equal(can_frame_node(&b->out.frame[0], COB_SDO_REPLY), node);
    assert_true(can_parse_sdo_reply(&b->out.frame[0], &reply));
    return reply;
}

/* Returns the abort code, 0 if the download was accepted. */
static uint32_t download(struct bench *b, uint16_t index, uint8_t sub, int size, uint32_t value) {
    const struct can_sdo request = {SDO_DOWNLOAD, index, sub, size, value};
    say(b, can_frame_sdo(node, &request));
    struct can_sdo reply = answer(b);
    assert_int_equal(reply.index, index);
    assert_int_equal(reply.sub, sub);
    return reply.kind == SDO_ABORT ? reply.value : 0;
}

static struct can_sdo upload(struct bench *b, uint16_t index, uint8_t sub) {
    const struct can_sdo request = {SDO_UPLOAD, index, sub, 0, 0};
    say(b, can_frame_sdo(node, &request));
    return answer(b);
}

static uint32_t value_of(struct bench *b, uint16_t index, uint8_t sub) {
    struct can_sdo reply = upload(b, index, sub);
    assert_int_equal(reply.kind, SDO_UPLOAD);
    return reply.value;
}

/* Counts the emergencies with this code among the frames sent. */
static int emergencies(const struct bench *b, uint16_t code) {
    int count = 0;
    uint16_t is;
    uint8_t bits;
    for (int i = 0; i < b->out.count; i++)
        count += can_frame_node(&b->out.frame[i], COB_EMCY) == node && can_parse_emcy(&b->out.frame[i], &is, &bits) && is == code;
    return count;
}

static int sent(const struct bench *b, unsigned function) {
    int count = 0;
    for (int i = 0; i < b->out.count; i++) count += can_frame_node(&b->out.frame[i], function) == node;
    return count;
}

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
    assert_int_equal(can_node_output(&b.node), 0); /* an earlier command does not count */
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
        assert_int_equal(can_node_output(&b.node), 0); /* a single error is ignored */
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
    static const char *const aborted[] = {        /* segmented download and its segments */
                                          "2117100002000000", "2017100002000000", "0000000000000000", "1000000000000000",
        /* segments of an upload, block upload */
                                          "6000000000000000", "7000000000000000", "a017100000000000",
        /* block download and unknown commands */
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
    assert_int_equal(download(&b, 0x1017, 0, 2, 10), 0); /* effective at once, not a second later */
    pass(&b, 100, NULL, 1);
    assert_int_equal(sent(&b, COB_HEARTBEAT), 10);
    assert_int_equal(download(&b, 0x1017, 0, 2, 0), 0);
    pass(&b, 200, NULL, 1);
    assert_int_equal(b.out.count, 0);
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
        /* type 0: sent when a reading has changed */
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
        /* the other PDO's number */
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

static void only_its_owner_has_a_node_for_as_long_as_it_lives(void **state) {
    struct bench b;
    (void)state;
    power_on(&b);
    assert_int_equal(value_of(&b, 0x2000, 3), 0);
    assert_int_equal(download(&b, 0x2000, 1, 4, 0), SDO_VALUE);
    assert_int_equal(download(&b, 0x2000, 1, 4, TOKEN), 0);
    assert_int_equal(value_of(&b, 0x2000, 3), 1);
    assert_int_equal(download(&b, 0x2000, 1, 4, TOKEN), 0); /* retry after a lost answer */
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
    pass(&b, 2900, NULL, 1); /* the owner's own timeout, not the default */
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
        assert_int_equal(b.out.count, 1); /* no error value is set */
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

static int is_axis(void **state) {
    (void)state;
    node = 2;
    return 0;
}

static int is_io(void **state) {
    (void)state;
    node = CAN_IO;
    return 0;
}

int main(void) {
    const struct CMUnitTest common[] = {
        cmocka_unit_test(nothing_is_written_in_operational_but_the_end_of_the_error_history),
        cmocka_unit_test(no_value_switches_the_rpdo_watchdog_off),
        cmocka_unit_test(commands_that_no_sync_puts_into_force_are_a_timeout_too),
        cmocka_unit_test(a_node_that_a_stranger_starts_keeps_its_output_at_zero_until_it_hears_the_master),
        cmocka_unit_test(a_node_that_watches_no_heartbeat_keeps_its_output_at_zero),
        cmocka_unit_test(two_heartbeats_are_watched_and_the_loss_of_either_is_one),
        cmocka_unit_test(the_consumers_rules_are_the_standards),
        cmocka_unit_test(a_download_that_does_not_say_its_size_is_taken),
        cmocka_unit_test(what_is_no_expedited_request_is_aborted_and_an_abort_is_not_answered),
        cmocka_unit_test(every_object_is_read_and_refused_as_its_access_says),
        cmocka_unit_test(nmt_commands_do_what_they_say_to_whom_they_say),
        cmocka_unit_test(stopped_answers_nothing_but_nmt_and_goes_on_with_heartbeats),
        cmocka_unit_test(a_reset_restores_the_defaults),
        cmocka_unit_test(the_error_behaviour_is_preoperational_or_stopped_never_operational),
        cmocka_unit_test(the_producer_time_takes_effect_at_once_and_zero_stops_it),
        cmocka_unit_test(sync_comes_with_the_identifier_and_length_that_are_set),
        cmocka_unit_test(every_transmission_type_that_is_taken_acts),
        cmocka_unit_test(a_pdo_is_switched_off_before_its_identifier_changes),
        cmocka_unit_test(a_pdo_that_is_off_neither_moves_nor_speaks),
        cmocka_unit_test(only_its_owner_has_a_node_for_as_long_as_it_lives),
        cmocka_unit_test(an_nmt_reset_does_not_disown_and_power_does),
        cmocka_unit_test(a_node_whose_owner_never_speaks_leaves_operational),
        cmocka_unit_test(an_owner_that_leaves_is_no_error),
    };
    const struct CMUnitTest axis[] = {
        cmocka_unit_test(a_short_rpdo_is_an_emergency_and_no_command),
        cmocka_unit_test(a_long_rpdo_is_processed_and_told),
        cmocka_unit_test(the_history_keeps_the_newest_first_and_is_cleared_by_zero_only),
        cmocka_unit_test(two_errors_stand_side_by_side_in_the_register),
        cmocka_unit_test(the_mapping_is_changed_in_the_standards_order_only),
        cmocka_unit_test(preoperational_answers_sdo_but_no_pdo),
    };
    const struct CMUnitTest io[] = {
        cmocka_unit_test(the_io_modules_mapping_and_error_values_are_fixed),
        cmocka_unit_test(inputs_are_latched_by_sync_and_sent_as_they_are),
        cmocka_unit_test(outputs_are_in_force_with_the_sync_and_zero_without_a_master),
        cmocka_unit_test(an_rpdo_without_its_byte_is_no_command),
        cmocka_unit_test(in_preoperational_inputs_are_read_and_no_output_is_set),
    };
    int failed = cmocka_run_group_tests_name("axis", common, is_axis, NULL) + cmocka_run_group_tests_name("io", common, is_io, NULL);
    failed += cmocka_run_group_tests_name("axis, valve", axis, is_axis, NULL);
    return failed + cmocka_run_group_tests_name("io, inputs and outputs", io, is_io, NULL);
}
