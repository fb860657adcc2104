#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "can_master.h"

/* Layout of can_condition.state, from bit 0 up: 2 bits for the bus; 4 bits for each of 7 nodes (3
 * for CAN_RUNNING - phase, 1 for an active EMCY); 16 for the code of the first node's EMCY; 12 for
 * the identifier of another master's frame (can_master.foreign); 3 for the node with a twin; 2
 * unused; 1 for the caller. */
enum {
    CONDITION_NODES = 2,
    CONDITION_NODE_BITS = 4,
    CONDITION_EMCY = CONDITION_NODES + CAN_NODES * CONDITION_NODE_BITS,
    CONDITION_FOREIGN = CONDITION_EMCY + 16,
    CONDITION_TWIN = CONDITION_FOREIGN + 12,
    CONDITION_END = CONDITION_TWIN + 3
};
_Static_assert((int)CONDITION_END <= 63, "there is no room for so many nodes");
/* Layout of can_condition.refusal, from bit 0 up: 32 bits for the value, 8 for the sub-index, 16
 * for the index, 3 for the node, 2 for the kind. */
enum { REFUSAL_SUB = 32, REFUSAL_INDEX = 40, REFUSAL_NODE = 56, REFUSAL_KIND = 59 };

static uint64_t pack(int node, const struct can_refusal *r) {
    return (uint64_t)r->kind << REFUSAL_KIND | (uint64_t)node << REFUSAL_NODE | (uint64_t)r->index << REFUSAL_INDEX |
           (uint64_t)r->sub << REFUSAL_SUB | r->value;
}

struct can_condition can_master_condition(const struct can_master *m) {
    struct can_condition c = {.state = (uint64_t)m->bus | (uint64_t)m->foreign << CONDITION_FOREIGN |
                                       (uint64_t)can_master_twin(m) << CONDITION_TWIN};
    for (int i = m->nodes - 1; i >= 0; i--) {
        const struct can_peer *p = &m->peer[i];
        int at = CONDITION_NODES + i * CONDITION_NODE_BITS;
        c.state |= (uint64_t)(CAN_RUNNING - p->phase) << at;
        if (p->phase == CAN_REFUSED) c.refusal = pack(i + 1, &p->refusal);
        if (!p->emcy) continue;
        c.state |= 8ull << at;
        c.state = (c.state & ~(0xffffull << CONDITION_EMCY)) | (uint64_t)p->emcy << CONDITION_EMCY;
    }
    return c;
}

__attribute__((format(printf, 3, 4))) static void append(char *text, size_t size, const char *format, ...) {
    size_t used = strlen(text);
    va_list args;
    va_start(args, format);
    vsnprintf(text + used, size - used, format, args);
    va_end(args);
}

static void describe_refusal(uint64_t word, const struct params *params, char *text, size_t size) {
    const struct can_refusal r = {.kind = (enum can_refusal_kind)(word >> REFUSAL_KIND),
                                  .index = (uint16_t)(word >> REFUSAL_INDEX),
                                  .sub = (uint8_t)(word >> REFUSAL_SUB),
                                  .value = (uint32_t)word};
    const char *key, *why = can_abort_text(r.value), *comma = *why ? ", " : "";
    double configured = can_identity(params, word >> REFUSAL_NODE & 7, r.index, r.sub, &key);
    if (can_refused_by_owner(&r)) append(text, size, " owned by another master");
    else if (r.kind == CAN_ABORTED) append(text, size, " refused 0x%04x:%u: abort 0x%08x%s%s", r.index, r.sub, r.value, comma, why);
    else if (!key) append(text, size, " has 0x%x in 0x%04x:%u, which is not what it must be", r.value, r.index, r.sub);
    else
        append(text, size, ": another device, 0x%04x:%u is 0x%x, not 0x%x (can.%s)", r.index, r.sub, r.value, (uint32_t)llround(configured),
               key);
}

/* Appends a node's problem to the text, such as ", node 3 lost EMCY 0x8250". node: the node's four
 * bits of can_condition.state. code: its EMCY code; 0: not known. refusal: its
 * can_condition.refusal; 0: not known. */
static void describe_node(const char *who, unsigned node, unsigned code, uint64_t refusal, const struct params *params, char *text,
                          size_t size) {
    static const char *const phases[] = {[CAN_LOST] = " lost",
                                         [CAN_REFUSED] = " refused its set-up",
                                         [CAN_SETUP] = " being set up",
                                         [CAN_STARTING] = " starting",
                                         [CAN_RUNNING] = ""};
    unsigned phase = CAN_RUNNING - (node & 7) % (CAN_RUNNING + 1);
    append(text, size, ", %s", who);
    if (phase == CAN_REFUSED && refusal) describe_refusal(refusal, params, text, size);
    else append(text, size, "%s", phases[phase]);
    if (node & 8) append(text, size, code ? " EMCY 0x%04x" : " EMCY", code);
}

void can_condition_describe(struct can_condition c, const struct params *params, char *text, size_t size) {
    static const char *const buses[] = {[CAN_BUS_GOOD] = "", [CAN_BUS_PASSIVE] = ", bus error-passive", [CAN_BUS_OFF] = ", bus-off"};
    /* a bit for each expected node, the lowest of its four: if all nodes are in state x, `nodes` is
     * x * all */
    const unsigned all = 0x1111111 >> CONDITION_NODE_BITS * (CAN_NODES - can_nodes(params));
    unsigned code = c.state >> CONDITION_EMCY & 0xffff, nodes = c.state >> CONDITION_NODES & 0xfffffff;
    unsigned foreign = c.state >> CONDITION_FOREIGN & 0xfff, twin = c.state >> CONDITION_TWIN & 7;
    int refusing = c.refusal >> REFUSAL_NODE & 7;
    *text = '\0';
    if (foreign) {
        const char *what = can_frame_of_master(&(struct can_frame){.can_id = foreign & CAN_SFF_MASK});
        append(text, size, ", another master: %s (0x%03x)", what ? what : "frame", foreign & CAN_SFF_MASK);
    }
    if (twin) append(text, size, ", node %u answers twice: two devices have its number, or it repeats itself", twin);
    append(text, size, "%s", buses[(c.state & 3) % 3]);
    if (nodes && nodes == (nodes & 15) * all) {
        describe_node("all nodes", nodes & 15, code, c.refusal, params, text, size);
        nodes = 0;
    }
    for (int i = 1; nodes; i++, nodes >>= CONDITION_NODE_BITS) {
        char who[20];
        snprintf(who, sizeof who, "node %d", i);
        if (nodes & 15) describe_node(who, nodes & 15, code, i == refusing ? c.refusal : 0, params, text, size);
        if (nodes & 8) code = 0; /* the code belongs to the first node with an EMCY */
    }
    if (*text) memmove(text, text + 2, strlen(text + 2) + 1); /* removes the leading comma */
}
