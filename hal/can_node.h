/* One axis node of the device side: CANopen (CiA 301) with a position encoder (objects named after CiA 406), two pressure inputs (CiA 404)
 * and a proportional valve (CiA 408). Pure: frames and time in, frames out; no socket, no heap. config/hexid_node.eds describes it.
 *
 * SAFETY: the valve is at its centre (0) unless the node is operational, has a command from an RPDO that was followed by a SYNC, and hears
 * the daemon: when no RPDO comes within 0x1400:5 ms, or no heartbeat within 0x1016:1, the valve is centred, EMCY 0x8250 or 0x8130 is sent,
 * and the node goes to pre-operational, where no command that was late can move it. Only the daemon's set-up brings it back. */
#ifndef HEXID_CAN_NODE_H
#define HEXID_CAN_NODE_H

#include "can_frames.h"

enum { CAN_OBJECTS = 41, CAN_QUEUE = 64 };

/* Frames to be sent, in order. Full: the rest is dropped and counted, as a controller does. */
struct can_queue {
    struct can_frame frame[CAN_QUEUE];
    int count, dropped;
};
void can_queue_push(struct can_queue *q, struct can_frame frame);

struct can_object {
    uint16_t index;
    uint8_t sub, size;      /* bytes */
    bool writable, is_signed;
    bool plus_node;         /* the default is value + node id */
    uint32_t value;         /* default */
    const char *name;
};
extern const struct can_object can_objects[CAN_OBJECTS];

/* Place in the table, -1: no such object. */
int can_object_find(uint16_t index, uint8_t sub);

struct can_node {
    int id;
    enum can_state state;
    uint32_t value[CAN_OBJECTS];
    int16_t valve;          /* in force since the last SYNC */
    bool commanded;         /* an RPDO has come since the node became operational */
    uint16_t emcy;          /* standing error, 0 none */
    int64_t heartbeat_due_ns;
    int64_t master_heard_ns;/* heartbeat of the daemon, 0: not yet */
    int64_t rpdo_heard_ns;
};

/* Power-on: default values, boot-up sent, pre-operational. */
void can_node_reset(struct can_node *n, int id, int64_t now_ns, struct can_queue *out);

/* Any frame of the bus; SYNC does nothing here (can_node_sync). */
void can_node_receive(struct can_node *n, const struct can_frame *frame, int64_t now_ns, struct can_queue *out);

/* SYNC: sends these latched readings, and puts the last command into force. */
void can_node_sync(struct can_node *n, const struct can_tpdo *latched, struct can_queue *out);

/* Heartbeat and watchdogs. At least every millisecond. */
void can_node_tick(struct can_node *n, int64_t now_ns, struct can_queue *out);

/* Command in force, 0 unless all of the above holds. */
int16_t can_node_valve(const struct can_node *n);

#endif
