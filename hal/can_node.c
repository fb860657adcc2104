#include "can_node.h"

#include <string.h>

#include "can_server.h"
#include "units.h"

enum { BEHAVIOUR_STOPPED = 2, TYPE_SYNC_MAX = 240, ALL_ERRORS = (1 << CAN_ERRORS) - 1 };

static const struct {
    uint16_t code;
    uint8_t bits; /* bits of 0x1001: 0 generic, 4 communication, 7 manufacturer */
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

static int place(const struct can_node *n, uint16_t index, uint8_t sub) { return can_object_find(n->dictionary, index, sub); }
uint32_t can_node_get(const struct can_node *n, uint16_t index, uint8_t sub) { return n->value[place(n, index, sub)]; }
void can_node_set(struct can_node *n, uint16_t index, uint8_t sub, uint32_t value) { n->value[place(n, index, sub)] = value; }

/* Returns the position in the dictionary's table of the object that an RPDO writes. */
static int commanded(const struct can_node *n) {
    uint32_t entry = n->dictionary->command;
    return place(n, can_entry_index(entry), can_entry_sub(entry));
}

struct can_consumer can_consumer_of(uint32_t value) {
    uint32_t node = value >> 16 & 0xff, limit_ms = value & 0xffff;
    return (struct can_consumer){.node = limit_ms && node <= 127 ? (int)node : 0, .limit_ms = limit_ms};
}

static struct can_consumer consumer(const struct can_node *n, int i) { return can_consumer_of(can_node_get(n, 0x1016, (uint8_t)(i + 1))); }

/* SAFETY: true if at least one master is watched, and the heartbeats of all watched masters
 * come. */
static bool watched(const struct can_node *n) {
    bool any = false;
    for (int i = 0; i < CAN_CONSUMERS; i++) {
        bool used = consumer(n, i).node != 0;
        if (used && !n->heard_ns[i]) return false;
        any |= used;
    }
    return any;
}

/* Sets the output to 0 and discards earlier commands. */
static void centre(struct can_node *n) {
    n->output = 0;
    n->received = 0;
    n->commanded = false;
    n->value[commanded(n)] = 0;
    can_node_set(n, n->dictionary->actual, 1, 0);
}

static void enter(struct can_node *n, enum can_state state) {
    if (state == n->state) return;
    centre(n);
    n->syncs = 0;
    n->has_sent = false;
    n->state = state;
}

/* Sends an EMCY with the current error register, except in the state stopped. */
static void announce(struct can_node *n, uint16_t code, struct can_queue *out) {
    uint8_t bits = 0;
    for (int i = 0; i < CAN_ERRORS; i++)
        if (n->errors >> i & 1) bits |= errors[i].bits;
    can_node_set(n, 0x1001, 0, bits);
    if (n->state != CAN_STOPPED) can_queue_push(out, can_frame_emcy(n->id, code, bits));
}

/* Stores an error in the history; 0x1003:1 is the newest. */
static void remember(struct can_node *n, uint16_t code) {
    uint32_t count = can_node_get(n, 0x1003, 0), *history = &n->value[place(n, 0x1003, 1)];
    memmove(history + 1, history, (CAN_HISTORY - 1) * sizeof *history);
    history[0] = code;
    can_node_set(n, 0x1003, 0, count < CAN_HISTORY ? count + 1 : CAN_HISTORY);
}

/* Reports an error once, when it becomes active. */
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

/* SAFETY: on a communication error the output goes to 0 and stays there until the daemon has set
 * the node up again. */
static void fail(struct can_node *n, enum can_error error, struct can_queue *out) {
    complain(n, error, out);
    if (n->state == CAN_OPERATIONAL) enter(n, can_node_get(n, 0x1029, 1) == BEHAVIOUR_STOPPED ? CAN_STOPPED : CAN_PREOPERATIONAL);
}

/* Resets the node to default values; keeps the owner, because anybody can send a reset. */
static void reset(struct can_node *n, int64_t now_ns, struct can_queue *out) {
    const struct can_dictionary *d = can_dictionary_of(n->id);
    *n = (struct can_node){.id = n->id, .dictionary = d, .state = CAN_PREOPERATIONAL, .heartbeat_due_ns = now_ns, .owner = n->owner};
    for (int i = 0; i < d->count; i++) n->value[i] = d->object[i].value + (d->object[i].plus_node ? (uint32_t)n->id : 0);
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
    n->heartbeat_due_ns = now_ns; /* reports the new state at once */
}

static void put_into_force(struct can_node *n) {
    int at = commanded(n);
    bool lacks = can_object_lacks(&n->dictionary->object[at], n->received);
    n->output = n->commanded && !lacks && watched(n) ? (int16_t)n->received : 0;
    n->in_force_ns = n->rpdo_ns;
    n->value[at] = n->received;
    can_node_set(n, n->dictionary->actual, 1, (uint16_t)n->output);
}

static uint32_t entry_of(const struct can_node *n, uint16_t mapping, uint32_t i) { return can_node_get(n, mapping, (uint8_t)(i + 1)); }

/* Takes the command from an RPDO: each mapped entry is the command or a dummy
 * (can_object_refuses()). */
static void rpdo(struct can_node *n, const struct can_frame *f, int64_t now_ns, struct can_queue *out) {
    const uint32_t lengths = 1u << CAN_ERROR_RPDO_SHORT | 1u << CAN_ERROR_RPDO_LONG;
    uint32_t entries = can_node_get(n, 0x1600, 0);
    int bytes = 0;
    for (uint32_t i = 0; i < entries; i++) bytes += can_entry_bytes(entry_of(n, 0x1600, i));
    /* SAFETY: a short RPDO is no command and does not restart the watchdog. */
    if (f->len < bytes) {
        complain(n, CAN_ERROR_RPDO_SHORT, out);
        return;
    }
    if (f->len > bytes) complain(n, CAN_ERROR_RPDO_LONG, out);
    else can_node_clear(n, lengths, out);
    const uint8_t *data = f->data;
    for (uint32_t i = 0; i < entries; i++) {
        uint32_t entry = entry_of(n, 0x1600, i);
        const uint8_t *at = data;
        data += can_entry_bytes(entry);
        if (entry != n->dictionary->command) continue;
        n->received = can_get(at, can_entry_bytes(entry));
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

/* Counts a SYNC. Returns true if a TPDO is due, and then records it as sent. With transmission type
 * 0 a TPDO is due if a reading has changed, with type n (1 to 240) at every n-th SYNC; it is never
 * due while the TPDO is switched off. */
static bool tpdo_due(struct can_node *n, const struct can_frame *t) {
    uint32_t type = can_node_get(n, 0x1800, 2);
    bool changed = !n->has_sent || memcmp(t->data, n->sent.data, t->len) != 0;
    if (can_node_get(n, 0x1800, 1) >> 31) return false;
    if (++n->syncs < type || (type == 0 && !changed)) return false;
    n->syncs = 0;
    n->sent = *t;
    n->has_sent = true;
    return true;
}

/* Copies the TPDO's bytes into the mapped objects. Returns true if a reading is missing. */
static bool take_readings(struct can_node *n, const struct can_frame *t) {
    const uint8_t *data = t->data;
    bool missing = false;
    for (uint32_t i = 0; i < can_node_get(n, 0x1a00, 0); i++) {
        uint32_t entry = entry_of(n, 0x1a00, i);
        int at = place(n, can_entry_index(entry), can_entry_sub(entry));
        n->value[at] = can_get(data, can_entry_bytes(entry));
        missing |= can_object_lacks(&n->dictionary->object[at], n->value[at]);
        data += can_entry_bytes(entry);
    }
    return missing;
}

void can_node_sync(struct can_node *n, const struct can_frame *sync, const struct can_tpdo *latched, struct can_queue *out) {
    struct can_frame tpdo = can_frame_tpdo(n->id, latched);
    if (n->state == CAN_STOPPED) return;
    if (sync->len != (can_node_get(n, 0x1019, 0) != 0)) {
        complain(n, CAN_ERROR_SYNC_LENGTH, out);
        return;
    }
    can_node_clear(n, 1u << CAN_ERROR_SYNC_LENGTH, out);
    bool missing = take_readings(n, &tpdo);
    if (n->state != CAN_OPERATIONAL) return;
    if (missing) complain(n, CAN_ERROR_SENSOR, out);
    else can_node_clear(n, 1u << CAN_ERROR_SENSOR, out);
    if (tpdo_due(n, &tpdo)) {
        tpdo.can_id = can_node_get(n, 0x1800, 1);
        can_queue_push(out, tpdo);
    }
    if (can_node_get(n, 0x1400, 2) <= TYPE_SYNC_MAX) put_into_force(n);
}

static bool expired(int64_t heard_ns, int64_t now_ns, uint32_t limit_ms) { return now_ns - heard_ns > limit_ms * NS_PER_MS; }

/* SAFETY: an owner whose heartbeat is late, or never came, loses the node, so that a motion that
 * the owner started does not go on without an owner. */
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
        n->heard_ns[i] = 0; /* CiA 301: the node watches this master again from its next heartbeat
                             * on */
        fail(n, CAN_ERROR_HEARTBEAT, out);
    }
    if (n->commanded && expired(n->in_force_ns, now_ns, can_node_get(n, 0x1400, 5))) fail(n, CAN_ERROR_RPDO_TIMEOUT, out);
}

void can_node_tick(struct can_node *n, int64_t now_ns, struct can_queue *out) {
    uint32_t period_ms = can_node_get(n, 0x1017, 0);
    if (period_ms && now_ns >= n->heartbeat_due_ns) {
        can_queue_push(out, can_frame_heartbeat(n->id, n->state));
        n->heartbeat_due_ns = now_ns + period_ms * NS_PER_MS;
    }
    watch(n, now_ns, out);
    watch_owner(n, now_ns, out);
}

int16_t can_node_output(const struct can_node *n) { return n->state == CAN_OPERATIONAL && watched(n) ? n->output : 0; }
