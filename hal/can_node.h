/* One node of the device side, CANopen (CiA 301). Nodes 1 to 6 are axes: a position encoder
 * (objects named after CiA 406), two pressure inputs (CiA 404) and a proportional valve (CiA 408);
 * node 7 has digital inputs and outputs (CiA 401). The kinds differ in their dictionaries and in
 * nothing else. Pure: frames and time in, frames out; no socket, no heap. config/hexid_node.eds and
 * config/hexid_io.eds describe them.
 *
 * The output is an axis's valve command, or the bits of the digital outputs. SAFETY: it is 0, the
 * valve at its centre and the outputs off, unless the node is operational, has a command from an
 * RPDO that was put into force (by the SYNC after it; transmission types 254 and 255: at once),
 * watches a heartbeat (0x1016) and hears all that it watches. When no command is put into force for
 * 0x1400:5 ms, or a heartbeat is late by its time in 0x1016, the output goes to 0, EMCY 0x8250 or
 * 0x8130 is sent, and the node goes to pre-operational (0x1029:1), where no command that was late
 * can move it. Both watchdogs are on by default, and switching the heartbeat off leaves the output
 * at 0. In operational no SDO writes anything but 0x1003:0.
 *
 * Owner: a master claims a node in pre-operational by writing a token of its own, not 0, to
 * 0x2000:1; as long as its heartbeat (0x1016:1) comes, another token is refused (0x08000022). It
 * ends when that is late, which is EMCY 0x8130 even where it never came, with power, or with the
 * same token in 0x2000:2; not with an NMT reset, which anybody can send. */
#ifndef HEXID_CAN_NODE_H
#define HEXID_CAN_NODE_H

#include "can_objects.h"

enum { CAN_QUEUE = 64 };

/* Frames to be sent, in order. Full: the rest is dropped and counted, as a controller does. */
struct can_queue {
    struct can_frame frame[CAN_QUEUE];
    int count, dropped;
};
void can_queue_push(struct can_queue *q, struct can_frame frame);

/* What can stand in 0x1001. */
enum can_error {
    CAN_ERROR_SENSOR,       /* EMCY 0x5000: a reading is missing */
    CAN_ERROR_HEARTBEAT,    /* 0x8130 */
    CAN_ERROR_RPDO_TIMEOUT, /* 0x8250 */
    CAN_ERROR_RPDO_SHORT,   /* 0x8210: fewer bytes than are mapped; not processed */
    CAN_ERROR_RPDO_LONG,    /* 0x8220: more; the first are processed */
    CAN_ERROR_SYNC_LENGTH,  /* 0x8240: not as 0x1019 has it; not processed */
    CAN_ERRORS,
};

struct can_owner {
    uint32_t token;         /* 0: none */
    uint32_t limit_ms;      /* ends when its heartbeat is silent for so long */
    int64_t heard_ns;
};

struct can_node {
    int id;
    const struct can_dictionary *dictionary;
    enum can_state state;
    uint32_t value[CAN_OBJECTS_MAX];
    int16_t output;         /* in force */
    uint32_t received;      /* by the last RPDO, */
    bool commanded;         /* and that one has come since the node became operational */
    uint32_t errors;        /* standing, 1 << enum can_error */
    int64_t heartbeat_due_ns;
    int64_t heard_ns[CAN_CONSUMERS]; /* heartbeats, 0: not yet */
    int64_t rpdo_ns, in_force_ns;    /* arrival of the last RPDO, and of the one in force */
    uint32_t syncs;         /* since the last TPDO */
    struct can_frame sent;  /* the last TPDO, */
    bool has_sent;          /* since the node became operational */
    struct can_owner owner;
};

/* Power-on: default values, nobody's, boot-up sent, pre-operational. The id, 1 to 7, says which
 * kind of node it is. */
void can_node_init(struct can_node *n, int id, int64_t now_ns, struct can_queue *out);

/* Any frame of the bus but SYNC. */
void can_node_receive(struct can_node *n, const struct can_frame *frame, int64_t now_ns, struct can_queue *out);

/* The frame is the node's SYNC (0x1005). */
bool can_node_synced_by(const struct can_node *n, const struct can_frame *frame);

/* SYNC: sends these latched readings or inputs, and puts the last command into force. */
void can_node_sync(struct can_node *n, const struct can_frame *sync, const struct can_tpdo *latched, struct can_queue *out);

/* Heartbeat and watchdogs. At least every millisecond. */
void can_node_tick(struct can_node *n, int64_t now_ns, struct can_queue *out);

/* Output in force, 0 unless all of the above holds. */
int16_t can_node_output(const struct can_node *n);

/* For the SDO server (can_server.h): values of objects that are in the table, consumer 0 or 1 of
 * 0x1016, and the end of errors. */
uint32_t can_node_get(const struct can_node *n, uint16_t index, uint8_t sub);
void can_node_set(struct can_node *n, uint16_t index, uint8_t sub, uint32_t value);
struct can_consumer {
    int node;               /* 0: the entry is not used */
    uint32_t limit_ms;
};
struct can_consumer can_consumer_of(uint32_t value);
void can_node_clear(struct can_node *n, uint32_t errors, struct can_queue *out);

#endif
