#include "can_node.h"

#include <string.h>

#include "units.h"

#define CONST(index, sub, size, value, name) {index, sub, size, false, false, false, value, name}
#define OF_NODE(index, sub, size, value, name) {index, sub, size, false, false, true, value, name}
#define OF_NODE_SETTING(index, sub, size, value, name) {index, sub, size, true, false, true, value, name}
#define SETTING(index, sub, size, value, name) {index, sub, size, true, false, false, value, name}
#define READING(index, sub, size, name) {index, sub, size, false, true, false, 0, name}

/* Sorted by index and sub. */
const struct can_object can_objects[CAN_OBJECTS] = {
    CONST(0x1000, 0, 4, 0x00000198, "Device type"), /* CiA 408 */
    CONST(0x1001, 0, 1, 0, "Error register"),
    SETTING(0x1005, 0, 4, COB_SYNC, "COB-ID SYNC"),
    OF_NODE(0x1014, 0, 4, COB_EMCY, "COB-ID EMCY"),
    CONST(0x1016, 0, 1, 1, "Highest sub-index supported"),
    SETTING(0x1016, 1, 4, 0, "Consumer heartbeat time 1"),
    SETTING(0x1017, 0, 2, 0, "Producer heartbeat time"),
    CONST(0x1018, 0, 1, 4, "Highest sub-index supported"),
    CONST(0x1018, 1, 4, 0, "Vendor-ID"),
    CONST(0x1018, 2, 4, 0x48584944, "Product code"), /* "HXID" */
    CONST(0x1018, 3, 4, 0x00010000, "Revision number"),
    OF_NODE(0x1018, 4, 4, 0, "Serial number"),
    CONST(0x1029, 0, 1, 1, "Highest sub-index supported"),
    CONST(0x1029, 1, 1, 0, "Communication error"), /* 0: to pre-operational */
    CONST(0x1200, 0, 1, 2, "Highest sub-index supported"),
    OF_NODE(0x1200, 1, 4, COB_SDO, "COB-ID client to server"),
    OF_NODE(0x1200, 2, 4, COB_SDO_REPLY, "COB-ID server to client"),
    CONST(0x1400, 0, 1, 5, "Highest sub-index supported"),
    OF_NODE_SETTING(0x1400, 1, 4, COB_RPDO, "COB-ID used by RPDO"),
    SETTING(0x1400, 2, 1, 1, "Transmission type"),
    SETTING(0x1400, 5, 2, 20, "Event timer"),
    SETTING(0x1600, 0, 1, 1, "Number of mapped objects"),
    SETTING(0x1600, 1, 4, MAP_VALVE, "Mapped object 1"),
    SETTING(0x1600, 2, 4, MAP_DUMMY, "Mapped object 2"),
    SETTING(0x1600, 3, 4, MAP_DUMMY, "Mapped object 3"),
    CONST(0x1800, 0, 1, 2, "Highest sub-index supported"),
    OF_NODE_SETTING(0x1800, 1, 4, COB_TPDO, "COB-ID used by TPDO"),
    SETTING(0x1800, 2, 1, 1, "Transmission type"),
    CONST(0x1a00, 0, 1, 3, "Number of mapped objects"),
    CONST(0x1a00, 1, 4, MAP_POSITION, "Mapped object 1"),
    CONST(0x1a00, 2, 4, MAP_P1, "Mapped object 2"),
    CONST(0x1a00, 3, 4, MAP_P2, "Mapped object 3"),
    CONST(0x6020, 0, 1, 1, "Highest sub-index supported"),
    READING(0x6020, 1, 4, "Position value"),
    CONST(0x6300, 0, 1, 1, "Highest sub-index supported"),
    {0x6300, 1, 2, true, true, false, 0, "vpoc_set_point"},
    CONST(0x6301, 0, 1, 1, "Highest sub-index supported"),
    READING(0x6301, 1, 2, "vpoc_actual_value"),
    CONST(0x7130, 0, 1, 2, "Highest sub-index supported"),
    READING(0x7130, 1, 2, "AI input PV P1"),
    READING(0x7130, 2, 2, "AI input PV P2"),
};

void can_queue_push(struct can_queue *q, struct can_frame frame) {
    if (q->count < CAN_QUEUE) q->frame[q->count++] = frame;
    else q->dropped++;
}

int can_object_find(uint16_t index, uint8_t sub) {
    for (int i = 0; i < CAN_OBJECTS; i++)
        if (can_objects[i].index == index && can_objects[i].sub == sub) return i;
    return -1;
}

/* For objects that are in the table. */
static uint32_t *object(struct can_node *n, uint16_t index, uint8_t sub) { return &n->value[can_object_find(index, sub)]; }
static uint32_t get(const struct can_node *n, uint16_t index, uint8_t sub) { return n->value[can_object_find(index, sub)]; }

/* The valve to its centre, and no command that came before counts. */
static void centre(struct can_node *n) {
    n->valve = 0;
    n->commanded = false;
    *object(n, 0x6300, 1) = *object(n, 0x6301, 1) = 0;
}

static void enter(struct can_node *n, enum can_state state) {
    if (state != n->state) centre(n);
    n->state = state;
}

/* SAFETY: on a communication error the valve is centred and stays so until the daemon has set the node up again. */
static void fail(struct can_node *n, uint16_t code, struct can_queue *out) {
    centre(n);
    n->state = CAN_PREOPERATIONAL;
    n->emcy = code;
    *object(n, 0x1001, 0) = 0x11; /* generic, communication */
    can_queue_push(out, can_frame_emcy(n->id, code, 0x11));
}

static void recover(struct can_node *n, struct can_queue *out) {
    if (n->emcy) can_queue_push(out, can_frame_emcy(n->id, EMCY_NONE, 0));
    n->emcy = EMCY_NONE;
    *object(n, 0x1001, 0) = 0;
}

void can_node_reset(struct can_node *n, int id, int64_t now_ns, struct can_queue *out) {
    *n = (struct can_node){.id = id, .state = CAN_PREOPERATIONAL, .heartbeat_due_ns = now_ns};
    for (int i = 0; i < CAN_OBJECTS; i++) n->value[i] = can_objects[i].value + (can_objects[i].plus_node ? (uint32_t)id : 0);
    can_queue_push(out, can_frame_heartbeat(id, CAN_BOOTUP));
}

static void nmt(struct can_node *n, enum can_nmt command, int64_t now_ns, struct can_queue *out) {
    switch (command) {
    case NMT_START:
        if (n->state != CAN_OPERATIONAL) recover(n, out);
        enter(n, CAN_OPERATIONAL);
        break;
    case NMT_STOP: enter(n, CAN_STOPPED); break;
    case NMT_PREOPERATIONAL: enter(n, CAN_PREOPERATIONAL); break;
    case NMT_RESET_NODE:
    case NMT_RESET_COMMUNICATION: can_node_reset(n, n->id, now_ns, out); return;
    default: return;
    }
    n->heartbeat_due_ns = now_ns; /* says at once what it is now */
}

/* Walks the mapping: entries that are neither the valve nor a dummy cannot be written (sdo_write). */
static void rpdo(struct can_node *n, const struct can_frame *f, int64_t now_ns) {
    int at = 0;
    for (uint8_t i = 1; i <= get(n, 0x1600, 0); i++, at += 2)
        if (at + 2 <= f->len && get(n, 0x1600, i) == MAP_VALVE) {
            *object(n, 0x6300, 1) = can_get(f->data + at, 2);
            n->commanded = true;
            n->rpdo_heard_ns = now_ns;
        }
}

/* Abort code, 0 when the value may be written. */
static uint32_t refuse(const struct can_node *n, const struct can_object *o, const struct can_sdo *sdo) {
    if (!o->writable) return SDO_READ_ONLY;
    if (sdo->size != o->size) return SDO_SIZE;
    bool mapping = o->index == 0x1600, enabled = !(get(n, 0x1400, 1) >> 31);
    if (mapping && enabled) return SDO_DENIED; /* CiA 301, 7.5.2.36: only while the PDO is off */
    if (mapping && (o->sub ? sdo->value != MAP_VALVE && sdo->value != MAP_DUMMY : sdo->value > 3)) return SDO_DENIED;
    /* SAFETY: a valve moves by RPDO and SYNC only, under the watchdog. */
    if (o->index == 0x6300 && n->state == CAN_OPERATIONAL) return SDO_DENIED;
    return 0;
}

static struct can_sdo sdo_serve(struct can_node *n, const struct can_sdo *request) {
    struct can_sdo reply = *request;
    int place = can_object_find(request->index, request->sub);
    uint32_t abort = 0;
    if (place < 0) abort = can_object_find(request->index, 0) < 0 ? SDO_NO_OBJECT : SDO_NO_SUB;
    else if (request->kind == SDO_DOWNLOAD && !(abort = refuse(n, &can_objects[place], request))) n->value[place] = request->value;
    else if (request->kind == SDO_UPLOAD) reply.value = n->value[place], reply.size = can_objects[place].size;
    if (abort) reply = (struct can_sdo){.kind = SDO_ABORT, .index = request->index, .sub = request->sub, .value = abort};
    return reply;
}

static void sdo(struct can_node *n, const struct can_frame *f, struct can_queue *out) {
    struct can_sdo request, reply;
    if (can_parse_sdo(f, &request)) {
        if (request.kind == SDO_ABORT) return;
        reply = sdo_serve(n, &request);
    } else if (f->len == 8) {
        reply = (struct can_sdo){.kind = SDO_ABORT, .index = (uint16_t)can_get(f->data + 1, 2), .sub = f->data[3], .value = SDO_COMMAND};
    } else {
        return;
    }
    can_queue_push(out, can_frame_sdo_reply(n->id, &reply));
}

void can_node_receive(struct can_node *n, const struct can_frame *f, int64_t now_ns, struct can_queue *out) {
    enum can_state state;
    int master = (int)(get(n, 0x1016, 1) >> 16 & 0x7f);
    if (f->can_id == COB_NMT && f->len == 2 && (f->data[1] == 0 || f->data[1] == n->id)) nmt(n, (enum can_nmt)f->data[0], now_ns, out);
    else if (f->can_id == get(n, 0x1400, 1) && n->state == CAN_OPERATIONAL) rpdo(n, f, now_ns);
    else if (can_frame_node(f, COB_SDO) == n->id && n->state != CAN_STOPPED) sdo(n, f, out);
    else if (can_frame_node(f, COB_HEARTBEAT) == master && can_parse_heartbeat(f, &state)) n->master_heard_ns = now_ns;
}

void can_node_sync(struct can_node *n, const struct can_tpdo *latched, struct can_queue *out) {
    bool missing = latched->position == INT32_MIN || latched->p1 == INT16_MIN || latched->p2 == INT16_MIN;
    *object(n, 0x6020, 1) = (uint32_t)latched->position;
    *object(n, 0x7130, 1) = (uint16_t)latched->p1;
    *object(n, 0x7130, 2) = (uint16_t)latched->p2;
    if (n->state != CAN_OPERATIONAL) return;
    if (missing != (n->emcy == EMCY_SENSOR)) {
        n->emcy = missing ? EMCY_SENSOR : EMCY_NONE;
        *object(n, 0x1001, 0) = missing ? 0x81 : 0; /* generic, of the maker */
        can_queue_push(out, can_frame_emcy(n->id, n->emcy, missing ? 0x81 : 0));
    }
    if (get(n, 0x1800, 1) >> 31 == 0) can_queue_push(out, can_frame_tpdo(n->id, latched));
    int16_t command = (int16_t)get(n, 0x6300, 1);
    n->valve = !n->commanded || command == INT16_MIN ? 0 : command;
    *object(n, 0x6301, 1) = (uint16_t)n->valve;
}

static bool expired(int64_t heard_ns, int64_t now_ns, uint32_t limit_ms) {
    return limit_ms > 0 && heard_ns > 0 && now_ns - heard_ns > (int64_t)limit_ms * 1000 * NS_PER_US;
}

void can_node_tick(struct can_node *n, int64_t now_ns, struct can_queue *out) {
    uint32_t period_ms = get(n, 0x1017, 0);
    if (period_ms && now_ns >= n->heartbeat_due_ns) {
        can_queue_push(out, can_frame_heartbeat(n->id, n->state));
        n->heartbeat_due_ns = now_ns + (int64_t)period_ms * 1000 * NS_PER_US;
    }
    if (n->state != CAN_OPERATIONAL) return;
    if (n->commanded && expired(n->rpdo_heard_ns, now_ns, get(n, 0x1400, 5))) fail(n, EMCY_RPDO_TIMEOUT, out);
    else if (expired(n->master_heard_ns, now_ns, get(n, 0x1016, 1) & 0xffff)) {
        fail(n, EMCY_HEARTBEAT, out);
        n->master_heard_ns = 0; /* CiA 301: watched again from the next one on */
    }
}

int16_t can_node_valve(const struct can_node *n) { return n->state == CAN_OPERATIONAL ? n->valve : 0; }
