/* One node, an axis or the I/O module, and the frames that it sends. */
#ifndef HEXID_TESTS_CAN_NODE_RIG_H
#define HEXID_TESTS_CAN_NODE_RIG_H

#include "support.h"

#include <stdio.h>

#include "can_node.h"
#include "units.h"

enum { MS = 1000000, PERIOD_MS = 2, TOKEN = 0x1234567, OTHER = 0x7654321 };

static const struct can_tpdo latched = {.position = 1831000, .p1 = 5000, .p2 = 4000, .inputs = INPUTS_ALL};

static int node = 2; /* an axis or CAN_IO; both kinds share one implementation, and tests that need
                      * no valve run with both */

static unsigned of_node(unsigned function) { return function + (unsigned)node; }

struct bench {
    struct can_node node;
    struct can_queue out; /* frames sent since the last say() or pass() */
    int64_t now_ns;
};

static inline void power_on(struct bench *b) {
    *b = (struct bench){.now_ns = NS_PER_S};
    can_node_init(&b->node, node, b->now_ns, &b->out);
}

static inline void say(struct bench *b, struct can_frame f) {
    b->out.count = 0;
    if (can_node_synced_by(&b->node, &f)) can_node_sync(&b->node, &f, &latched, &b->out);
    else can_node_receive(&b->node, &f, b->now_ns, &b->out);
}

/* Lets `ms` milliseconds pass and calls done() every `period` ms. */
static inline void pass(struct bench *b, int ms, void (*done)(struct bench *), int period) {
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

static inline struct can_frame frame(unsigned cob, int length, const char *hex) {
    struct can_frame f = {.can_id = cob, .len = (uint8_t)length};
    for (int i = 0; i < length; i++) {
        unsigned byte = 0;
        if (*hex) sscanf(hex + 2 * i, "%2x", &byte);
        f.data[i] = (uint8_t)byte;
    }
    return f;
}

static inline void nmt(struct bench *b, enum can_nmt command) { say(b, can_frame_nmt(command, node)); }

static inline void heartbeat(struct bench *b) { say(b, can_frame_heartbeat(CAN_MASTER, CAN_OPERATIONAL)); }

static inline void sync_node(struct bench *b) { say(b, can_frame_sync()); }

static inline int16_t commanded(void) { return node == CAN_IO ? 1 : 0x1000; }

static inline struct can_frame rpdo(unsigned cob) { return node == CAN_IO ? frame(cob, 1, "01") : frame(cob, 2, "0010"); }

static inline void command(struct bench *b) { say(b, rpdo(of_node(COB_RPDO))); }

static inline void drive(struct bench *b) {
    heartbeat(b);
    command(b);
    sync_node(b);
}

static inline struct can_sdo answer(struct bench *b) {
    struct can_sdo reply = {0};
    assert_true(b->out.count >= 1);
    assert_int_equal(can_frame_node(&b->out.frame[0], COB_SDO_REPLY), node);
    assert_true(can_parse_sdo_reply(&b->out.frame[0], &reply));
    return reply;
}

/* Writes an object. Returns the abort code, 0 if the node accepted the value. */
static inline uint32_t download(struct bench *b, uint16_t index, uint8_t sub, int size, uint32_t value) {
    const struct can_sdo request = {SDO_DOWNLOAD, index, sub, size, value};
    say(b, can_frame_sdo(node, &request));
    struct can_sdo reply = answer(b);
    assert_int_equal(reply.index, index);
    assert_int_equal(reply.sub, sub);
    return reply.kind == SDO_ABORT ? reply.value : 0;
}

static inline struct can_sdo upload(struct bench *b, uint16_t index, uint8_t sub) {
    const struct can_sdo request = {SDO_UPLOAD, index, sub, 0, 0};
    say(b, can_frame_sdo(node, &request));
    return answer(b);
}

static inline uint32_t value_of(struct bench *b, uint16_t index, uint8_t sub) {
    struct can_sdo reply = upload(b, index, sub);
    assert_int_equal(reply.kind, SDO_UPLOAD);
    return reply.value;
}

/* Counts the emergencies with this code among the frames sent. */
static inline int emergencies(const struct bench *b, uint16_t code) {
    int count = 0;
    uint16_t is;
    uint8_t bits;
    for (int i = 0; i < b->out.count; i++)
        count += can_frame_node(&b->out.frame[i], COB_EMCY) == node && can_parse_emcy(&b->out.frame[i], &is, &bits) && is == code;
    return count;
}

static inline int sent(const struct bench *b, unsigned function) {
    int count = 0;
    for (int i = 0; i < b->out.count; i++) count += can_frame_node(&b->out.frame[i], function) == node;
    return count;
}

static inline int is_axis(void **state) {
    (void)state;
    node = 2;
    return 0;
}

static inline int is_io(void **state) {
    (void)state;
    node = CAN_IO;
    return 0;
}

#endif
