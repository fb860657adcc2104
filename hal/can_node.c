#include "can_node.h"

#include <string.h>

#include "can_server.h"
#include "units.h"

enum { NS_PER_MS = 1000000, BEHAVIOUR_STOPPED = 2, TYPE_SYNC_MAX = 240, ALL_ERRORS = (1 << CAN_ERRORS) - 1 };

static const struct {
    uint16_t code;
    uint8_t bits; /* of 0x1001: 0 generic, 4 communication, 7 of the maker */
} errors[CAN_ERRORS] = {
    [CAN_ERROR_SENSOR] = {EMCY_SENSOR, 0x81},
    [CAN_ERROR_HEARTBEAT] = {EMCY_HEARTBEAT, 0x11},
    [CAN_ERROR_RPDO_TIMEOUT] = {EMCY_RPDO_TIMEOUT, 0x11},
    [CAN_ERROR_RPDO_SHORT] = {EMCY_RPDO_SHORT, 0x11},
    [CAN_ERROR_RPDO_LONG] = {EMCY_RPDO_LONG, 0x11},
    [CAN_ERROR_SYNC_LENGTH] = {EMCY_SYNC_LENGTH, 0x11},
};

void can_queue_push(struct can_queue *q, struct can_frame frame) {
    if (q->count < CAN_QUEUE) q->frame[q->count++] = frame;
    else q->dropped++;
}

uint32_t can_node_get(const struct can_node *n, uint16_t index, uint8_t sub) { return n->value[can_object_find(index, sub)]; }
void can_node_set(struct can_node *n, uint16_t index, uint8_t sub, uint32_t value) { n->value[can_object_find(index, sub)] = value; }

struct can_consumer can_consumer_of(uint32_t value) {
    uint32_t node = value >> 16 & 0xff, limit_ms = value & 0xffff;
    return (struct can_consumer){.node = limit_ms && node <= 127 ? (int)node : 0, .limit_ms = limit_ms};
}

static struct can_consumer consumer(const struct can_node *n, int i) { return can_consumer_of(can_node_get(n, 0x1016, (uint8_t)(i + 1))); }

/* SAFETY: a master is watched, and every one that is watched is heard. */
static bool watched(const struct can_node *n) {
    bool any = false;
    for (int i = 0; i < CAN_CONSUMERS; i++) {
        bool used = consumer(n, i).node != 0;
        if (used && !n->heard_ns[i]) return false;
        any |= used;
    }
    return any;
}

/* The valve to its centre, and no command that came before counts. */
static void centre(struct can_node *n) {
    n->valve = 0;
    n->commanded = false;
    can_node_set(n, 0x6300, 1, 0);
    can_node_set(n, 0x6301, 1, 0);
}

static void enter(struct can_node *n, enum can_state state) {
    if (state == n->state) return;
    centre(n);
    n->syncs = 0;
    n->has_sent = false;
    n->state = state;
}

/* EMCY with the register as it is now. No emergencies in stopped. */
static void announce(struct can_node *n, uint16_t code, struct can_queue *out) {
    uint8_t bits = 0;
    for (int i = 0; i < CAN_ERRORS; i++)
        if (n->errors >> i & 1) bits |= errors[i].bits;
    can_node_set(n, 0x1001, 0, bits);
    if (n->state != CAN_STOPPED) can_queue_push(out, can_frame_emcy(n->id, code, bits));
}

/* The newest error is 0x1003:1. */
static void remember(struct can_node *n, uint16_t code) {
    uint32_t count = can_node_get(n, 0x1003, 0), *history = &n->value[can_object_find(0x1003, 1)];
    memmove(history + 1, history, (CAN_HISTORY - 1) * sizeof *history);
    history[0] = code;
    can_node_set(n, 0x1003, 0, count < CAN_HISTORY ? count + 1 : CAN_HISTORY);
}

/* Once, when it begins to stand. */
static void complain(struct can_node *n, enum can_error error, struct can_queue *out) {
    if (n->errors >> error & 1) return;
    n->errors |= 1u << error;
    remember(n, errors[error].code);
    announce(n, errors[error].code, out);
}

void can_node_clear(struct can_node *n, uint32_t which, struct can_queue *out) {
    if (!(n->errors & which)) return;
    n->errors &= ~which;
    announce(n, EMCY_NONE, out);
}

/* SAFETY: on a communication error the valve is centred and stays so until the daemon has set the node up again. */
static void fail(struct can_node *n, enum can_error error, struct can_queue *out) {
    complain(n, error, out);
    if (n->state == CAN_OPERATIONAL) enter(n, can_node_get(n, 0x1029, 1) == BEHAVIOUR_STOPPED ? CAN_STOPPED : CAN_PREOPERATIONAL);
}

/* The owner stays: anybody can send a reset. */
static void reset(struct can_node *n, int64_t now_ns, struct can_queue *out) {
    *n = (struct can_node){.id = n->id, .state = CAN_PREOPERATIONAL, .heartbeat_due_ns = now_ns, .owner = n->owner};
    for (int i = 0; i < CAN_OBJECTS; i++) n->value[i] = can_objects[i].value + (can_objects[i].plus_node ? (uint32_t)n->id : 0);
    can_node_set(n, 0x2000, 3, n->owner.token != 0);
    can_queue_push(out, can_frame_heartbeat(n->id, CAN_BOOTUP));
}

void can_node_init(struct can_node *n, int id, int64_t now_ns, struct can_queue *out) {
    *n = (struct can_node){.id = id};
    reset(n, now_ns, out);
}

static void nmt(struct can_node *n, enum can_nmt command, int64_t now_ns, struct can_queue *out) {
    bool started = command == NMT_START && n->state != CAN_OPERATIONAL;
    switch (command) {
    case NMT_START: enter(n, CAN_OPERATIONAL); break;
    case NMT_STOP: enter(n, CAN_STOPPED); break;
    case NMT_PREOPERATIONAL: enter(n, CAN_PREOPERATIONAL); break;
    case NMT_RESET_NODE:
    case NMT_RESET_COMMUNICATION: reset(n, now_ns, out); return;
    default: return;
    }
    if (started) can_node_clear(n, ALL_ERRORS, out);
    n->heartbeat_due_ns = now_ns; /* says at once what it is now */
}

static void put_into_force(struct can_node *n) {
    int16_t command = (int16_t)can_node_get(n, 0x6300, 1);
    n->valve = n->commanded && command != INT16_MIN && watched(n) ? command : 0;
    n->in_force_ns = n->rpdo_ns;
    can_node_set(n, 0x6301, 1, (uint16_t)n->valve);
}

/* Walks the mapping: each entry has 16 bit and is the valve or a dummy (can_mapping_refuses). */
static void rpdo(struct can_node *n, const struct can_frame *f, int64_t now_ns, struct can_queue *out) {
    const uint32_t lengths = 1u << CAN_ERROR_RPDO_SHORT | 1u << CAN_ERROR_RPDO_LONG;
    uint32_t entries = can_node_get(n, 0x1600, 0), bytes = 2 * entries;
    /* SAFETY: a short RPDO is neither a command nor a sign of life. */
    if (f->len < bytes) {
        complain(n, CAN_ERROR_RPDO_SHORT, out);
        return;
    }
    if (f->len > bytes) complain(n, CAN_ERROR_RPDO_LONG, out);
    else can_node_clear(n, lengths, out);
    for (uint32_t i = 0; i < entries; i++) {
        if (can_node_get(n, 0x1600, (uint8_t)(i + 1)) != MAP_VALVE) continue;
        can_node_set(n, 0x6300, 1, can_get(f->data + 2 * i, 2));
        n->rpdo_ns = now_ns;
        if (!n->commanded) n->in_force_ns = now_ns;
        n->commanded = true;
    }
    if (can_node_get(n, 0x1400, 2) > TYPE_SYNC_MAX) put_into_force(n);
}

static void hear(struct can_node *n, int producer, int64_t now_ns, struct can_queue *out) {
    for (int i = 0; i < CAN_CONSUMERS; i++) {
        if (consumer(n, i).node != producer) continue;
        n->heard_ns[i] = now_ns;
        if (i == 0) n->owner.heard_ns = now_ns;
    }
    if (watched(n)) can_node_clear(n, 1u << CAN_ERROR_HEARTBEAT, out);
}

void can_node_receive(struct can_node *n, const struct can_frame *f, int64_t now_ns, struct can_queue *out) {
    enum can_state state;
    int producer = can_frame_node(f, COB_HEARTBEAT);
    if (f->can_id == COB_NMT) {
        if (f->len == 2 && (f->data[1] == 0 || f->data[1] == n->id)) nmt(n, (enum can_nmt)f->data[0], now_ns, out);
    } else if (f->can_id == can_node_get(n, 0x1400, 1)) {
        if (n->state == CAN_OPERATIONAL) rpdo(n, f, now_ns, out);
    } else if (can_frame_node(f, COB_SDO) == n->id) {
        if (n->state != CAN_STOPPED) can_server_receive(n, f, now_ns, out);
    } else if (producer && can_parse_heartbeat(f, &state) && state != CAN_BOOTUP) {
        hear(n, producer, now_ns, out);
    }
}

bool can_node_synced_by(const struct can_node *n, const struct can_frame *f) {
    return f->can_id == (can_node_get(n, 0x1005, 0) & CAN_SFF_MASK);
}

/* Transmission type 0: when a reading has changed; 1 to 240: with every so many SYNCs. */
static bool tpdo_due(struct can_node *n, const struct can_tpdo *t) {
    uint32_t type = can_node_get(n, 0x1800, 2);
    bool changed = !n->has_sent || t->position != n->sent.position || t->p1 != n->sent.p1 || t->p2 != n->sent.p2;
    if (can_node_get(n, 0x1800, 1) >> 31) return false;
    if (++n->syncs < type || (type == 0 && !changed)) return false;
    n->syncs = 0;
    n->sent = *t;
    n->has_sent = true;
    return true;
}

void can_node_sync(struct can_node *n, const struct can_frame *sync, const struct can_tpdo *latched, struct can_queue *out) {
    bool missing = latched->position == INT32_MIN || latched->p1 == INT16_MIN || latched->p2 == INT16_MIN;
    if (n->state == CAN_STOPPED) return;
    if (sync->len != (can_node_get(n, 0x1019, 0) != 0)) {
        complain(n, CAN_ERROR_SYNC_LENGTH, out);
        return;
    }
    can_node_clear(n, 1u << CAN_ERROR_SYNC_LENGTH, out);
    can_node_set(n, 0x6020, 1, (uint32_t)latched->position);
    can_node_set(n, 0x7130, 1, (uint16_t)latched->p1);
    can_node_set(n, 0x7130, 2, (uint16_t)latched->p2);
    if (n->state != CAN_OPERATIONAL) return;
    if (missing) complain(n, CAN_ERROR_SENSOR, out);
    else can_node_clear(n, 1u << CAN_ERROR_SENSOR, out);
    if (tpdo_due(n, latched)) {
        struct can_frame tpdo = can_frame_tpdo(n->id, latched);
        tpdo.can_id = can_node_get(n, 0x1800, 1);
        can_queue_push(out, tpdo);
    }
    if (can_node_get(n, 0x1400, 2) <= TYPE_SYNC_MAX) put_into_force(n);
}

static bool expired(int64_t heard_ns, int64_t now_ns, uint32_t limit_ms) { return now_ns - heard_ns > (int64_t)limit_ms * NS_PER_MS; }

/* SAFETY: an owner that is not heard is lost, also one that never was: what it started does not run on as nobody's. */
static void watch_owner(struct can_node *n, int64_t now_ns, struct can_queue *out) {
    if (!n->owner.token || !expired(n->owner.heard_ns, now_ns, n->owner.limit_ms)) return;
    n->owner = (struct can_owner){0};
    can_node_set(n, 0x2000, 3, 0);
    fail(n, CAN_ERROR_HEARTBEAT, out);
}

static void watch(struct can_node *n, int64_t now_ns, struct can_queue *out) {
    for (int i = 0; i < CAN_CONSUMERS; i++) {
        struct can_consumer c = consumer(n, i);
        if (!c.node || !n->heard_ns[i] || !expired(n->heard_ns[i], now_ns, c.limit_ms)) continue;
        n->heard_ns[i] = 0; /* CiA 301: watched again from the next one on */
        fail(n, CAN_ERROR_HEARTBEAT, out);
    }
    if (n->commanded && expired(n->in_force_ns, now_ns, can_node_get(n, 0x1400, 5))) fail(n, CAN_ERROR_RPDO_TIMEOUT, out);
}

void can_node_tick(struct can_node *n, int64_t now_ns, struct can_queue *out) {
    uint32_t period_ms = can_node_get(n, 0x1017, 0);
    if (period_ms && now_ns >= n->heartbeat_due_ns) {
        can_queue_push(out, can_frame_heartbeat(n->id, n->state));
        n->heartbeat_due_ns = now_ns + (int64_t)period_ms * NS_PER_MS;
    }
    watch(n, now_ns, out);
    watch_owner(n, now_ns, out);
}

int16_t can_node_valve(const struct can_node *n) { return n->state == CAN_OPERATIONAL && watched(n) ? n->valve : 0; }
