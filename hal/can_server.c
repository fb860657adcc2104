#include "can_server.h"

/* OWNER_MS: time after which an owner without a heartbeat loses the node, if 0x1016:1 sets no
 * time */
enum { OWNER_MS = 150 };
#define PDO_OFF 0x80000000u

static bool pdo_on(uint32_t cob) { return !(cob & PDO_OFF); }

/* True if an object other than `index` (EMCY, SYNC or a PDO) already uses this identifier. */
static bool taken(const struct can_node *n, uint16_t index, uint32_t cob) {
    uint32_t sync = can_node_get(n, 0x1005, 0) & CAN_SFF_MASK, rpdo = can_node_get(n, 0x1400, 1), tpdo = can_node_get(n, 0x1800, 1);
    return cob == can_node_get(n, 0x1014, 0) || (index != 0x1005 && cob == sync) || (index != 0x1400 && cob == rpdo) ||
           (index != 0x1800 && cob == tpdo);
}

/* Returns the abort code for a PDO's new COB-ID; 0 if it is accepted. CiA 301, 7.5.2.35: a PDO must
 * be off before its identifier changes. */
static uint32_t refuse_pdo(const struct can_node *n, uint16_t index, uint32_t cob) {
    uint32_t before = can_node_get(n, index, 1);
    if (!pdo_on(cob)) return 0;
    if (pdo_on(before) && cob != before) return SDO_DENIED;
    /* an RPDO that maps nothing cannot be switched on */
    if (index == 0x1400 && can_node_get(n, 0x1600, 0) == 0) return SDO_DENIED;
    return taken(n, index, cob) ? SDO_VALUE : 0;
}

/* Returns the abort code for a write to the mapping at the wrong time; 0 if the time is right. CiA
 * 301, 7.5.2.36, has this order: switch the PDO off, set the number of entries to 0, write the
 * entries, then set their number. */
static uint32_t refuse_mapping(const struct can_node *n, uint8_t sub) {
    bool in_use = pdo_on(can_node_get(n, 0x1400, 1)) || (sub && can_node_get(n, 0x1600, 0));
    return in_use ? SDO_DENIED : 0;
}

static uint32_t refuse_consumer(const struct can_node *n, uint8_t sub, uint32_t value) {
    struct can_consumer wanted = can_consumer_of(value);
    if (!wanted.node) return 0;
    if (wanted.node == n->id) return SDO_VALUE;
    for (uint8_t i = 1; i <= CAN_CONSUMERS; i++)
        if (i != sub && can_consumer_of(can_node_get(n, 0x1016, i)).node == wanted.node) return SDO_INCOMPATIBLE;
    return 0;
}

/* SAFETY: one master. Refuses a claim (sub 1) while the node has another owner, and a release (sub
 * 2) with any token but the owner's. A token of 0 is refused, too. */
static uint32_t refuse_owner(const struct can_node *n, uint8_t sub, uint32_t token) {
    if (token == 0) return SDO_VALUE;
    bool owners = token == n->owner.token;
    return owners || (sub == 1 && n->owner.token == 0) ? 0 : SDO_DENIED;
}

/* Returns the abort code; 0 if the node accepts the value in its current state. */
static uint32_t refuse_now(const struct can_node *n, const struct can_object *o, uint32_t value) {
    /* SAFETY: in operational no SDO write can weaken a watchdog or redirect a command; and only
     * RPDOs, which the watchdogs supervise, move an output. */
    if ((n->state == CAN_OPERATIONAL && o->index != 0x1003) || o->access == CAN_RWW) return SDO_DENIED;
    switch (o->index) {
    case 0x1005: return taken(n, o->index, value & CAN_SFF_MASK) ? SDO_VALUE : 0;
    case 0x1016: return refuse_consumer(n, o->sub, value);
    case 0x1400:
    case 0x1800: return o->sub == 1 ? refuse_pdo(n, o->index, value) : 0;
    case 0x1600: return refuse_mapping(n, o->sub);
    case 0x2000: return refuse_owner(n, o->sub, value);
    default: return 0;
    }
}

static void watch_anew(struct can_node *n, uint8_t sub, uint32_t value, int64_t now_ns, struct can_queue *out) {
    struct can_consumer consumer = can_consumer_of(value);
    n->heard_ns[sub - 1] = 0; /* the node watches this master from its next heartbeat on (CiA 301,
                               * 0x1016) */
    can_node_clear(n, 1u << CAN_ERROR_HEARTBEAT, out);
    if (sub != 1 || !n->owner.token || !consumer.node) return;
    n->owner.limit_ms = consumer.limit_ms;
    n->owner.heard_ns = now_ns;
}

static void own(struct can_node *n, uint32_t token, int64_t now_ns) {
    struct can_consumer consumer = can_consumer_of(can_node_get(n, 0x1016, 1));
    n->owner = (struct can_owner){.token = token, .limit_ms = consumer.node ? consumer.limit_ms : OWNER_MS, .heard_ns = now_ns};
    can_node_set(n, 0x2000, 3, 1);
}

/* Ends the ownership on the owner's request; the owner's silence is then no error. */
static void disown(struct can_node *n) {
    n->owner = (struct can_owner){0};
    n->heard_ns[0] = 0;
    can_node_set(n, 0x2000, 3, 0);
}

static void store(struct can_node *n, const struct can_object *o, uint32_t value, int64_t now_ns, struct can_queue *out) {
    if (o->access != CAN_WO) can_node_set(n, o->index, o->sub, value);
    switch (o->index) {
    case 0x1016: watch_anew(n, o->sub, value, now_ns, out); break;
    case 0x1017: n->heartbeat_due_ns = now_ns; break;
    case 0x1800: n->syncs = 0, n->has_sent = false; break;
    case 0x2000:
        if (o->sub == 1) own(n, value, now_ns);
        else disown(n);
        break;
    default: break;
    }
}

/* Returns the value to write, cut to the object's size if the client does not indicate a size. */
static uint32_t fitted(const struct can_object *o, const struct can_sdo *request) {
    return request->size || o->size == 4 ? request->value : request->value & ((1u << 8 * o->size) - 1);
}

static uint32_t download(struct can_node *n, const struct can_object *o, const struct can_sdo *request, int64_t now_ns,
                         struct can_queue *out) {
    uint32_t value = fitted(o, request), abort = can_object_refuses(n->dictionary, o, request->size, value);
    if (!abort) abort = refuse_now(n, o, value);
    if (!abort) store(n, o, value, now_ns, out);
    return abort;
}

static uint32_t upload(const struct can_node *n, const struct can_object *o, struct can_sdo *reply) {
    if (o->access == CAN_WO) return SDO_WRITE_ONLY;
    if (o->index == 0x1003 && o->sub > can_node_get(n, 0x1003, 0)) return SDO_NO_DATA;
    reply->value = can_node_get(n, o->index, o->sub);
    reply->size = o->size;
    return 0;
}

static uint32_t serve(struct can_node *n, const struct can_sdo *request, struct can_sdo *reply, int64_t now_ns, struct can_queue *out) {
    const struct can_dictionary *d = n->dictionary;
    int place = can_object_find(d, request->index, request->sub);
    if (place < 0) return can_object_find(d, request->index, 0) < 0 ? SDO_NO_OBJECT : SDO_NO_SUB;
    if (request->kind == SDO_UPLOAD) return upload(n, &d->object[place], reply);
    return download(n, &d->object[place], request, now_ns, out);
}

void can_server_receive(struct can_node *n, const struct can_frame *f, int64_t now_ns, struct can_queue *out) {
    struct can_sdo request = {0}, reply;
    struct can_queue first = {0}; /* frames that the request causes; they are sent after its
                                   * answer */
    enum { SEGMENT_DOWNLOAD = 0, SEGMENT_UPLOAD = 3, ABORT = 4 };
    int specifier = f->data[0] >> 5;
    if (f->len != 8 || specifier == ABORT) return;
    bool known = can_parse_sdo(f, &request);
    reply = request;
    uint32_t abort = known ? serve(n, &request, &reply, now_ns, &first) : SDO_COMMAND;
    if (abort) reply = (struct can_sdo){.kind = SDO_ABORT, .index = request.index, .sub = request.sub, .value = abort};
    /* a request for a segment names no object, so the abort has index 0 */
    if (!known && (specifier == SEGMENT_DOWNLOAD || specifier == SEGMENT_UPLOAD)) reply.index = 0, reply.sub = 0;
    can_queue_push(out, can_frame_sdo_reply(n->id, &reply));
    for (int i = 0; i < first.count; i++) can_queue_push(out, first.frame[i]);
}
