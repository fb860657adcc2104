/* One node of the device side, CANopen (CiA 301). Nodes 1 to 6 are axes: a position encoder
 * (objects named after CiA 406), two pressure inputs (CiA 404) and a proportional valve (CiA 408);
 * node 7 has digital inputs and outputs (CiA 401). The kinds differ only in their dictionaries.
 * Pure: frames and time in, frames out; no socket, no heap. config/hexid_node.eds and
 * config/hexid_io.eds describe them.
 *
 * The output is an axis's valve command, or the bits of the digital outputs. SAFETY: the output is
 * 0 (valve centred, outputs off) unless the node is operational, a command from an RPDO has come
 * into force, at least one heartbeat is watched (0x1016), and all watched heartbeats come. A
 * command comes into force with the following SYNC, or at once with transmission types 254 and 255.
 * The output goes to 0, with EMCY 0x8250, if the RPDO of the command in force is older than the
 * time in 0x1400:5, and with EMCY 0x8130 if a watched heartbeat is later than 0x1016 permits. The
 * node then goes to pre-operational (or to stopped, by 0x1029:1), where no late command can move
 * it. Both watchdogs are on by default; if the heartbeat is not watched, the output stays 0. In
 * operational, SDOs can only write 0x1003:0.
 *
 * Owner: a master claims a node in pre-operational by writing a token of its own, not 0, to
 * 0x2000:1. While that master's heartbeat (0x1016:1) comes, other tokens are refused (0x08000022).
 * Ownership ends when that heartbeat is late (EMCY 0x8130, even if it never came), at power-off, or
 * when the same token is written to 0x2000:2. It does not end with an NMT reset, because anybody
 * can send one. */
#ifndef HEXID_CAN_NODE_H
#define HEXID_CAN_NODE_H

#include "can_objects.h"

enum { CAN_QUEUE = 64 };

/* Frames to be sent, in order. If the queue is full, further frames are dropped and counted, as in
 * a controller. */
struct can_queue {
    struct can_frame frame[CAN_QUEUE];
    int count, dropped;
};
void can_queue_push(struct can_queue *q, struct can_frame frame);

/* Errors that the error register, 0x1001, shows. */
enum can_error {
    CAN_ERROR_SENSOR,       /* EMCY 0x5000: a reading is missing */
    CAN_ERROR_HEARTBEAT,    /* EMCY 0x8130: a heartbeat that the node watches is late */
    CAN_ERROR_RPDO_TIMEOUT, /* EMCY 0x8250: no command has come into force in time */
    CAN_ERROR_RPDO_SHORT,   /* EMCY 0x8210: an RPDO had fewer bytes than mapped and was ignored */
    CAN_ERROR_RPDO_LONG,    /* EMCY 0x8220: an RPDO had more bytes than mapped; only the mapped ones
                             * were used */
    CAN_ERROR_SYNC_LENGTH,  /* EMCY 0x8240: a SYNC had no counter although 0x1019 demands one, or
                             * had a counter although 0x1019 demands none; the SYNC was ignored */
    CAN_ERRORS,
};

struct can_owner {
    uint32_t token;         /* token of the owner; 0: there is none */
    uint32_t limit_ms;      /* ownership ends after this time without the owner's heartbeat */
    int64_t heard_ns;       /* time of the owner's last heartbeat, or of its claim if that is
                             * later */
};

struct can_node {
    int id;
    const struct can_dictionary *dictionary;
    enum can_state state;
    uint32_t value[CAN_OBJECTS_MAX]; /* values of the objects, in the dictionary's order */
    int16_t output;         /* output value in force */
    uint32_t received;      /* value that the last RPDO carried */
    bool commanded;         /* an RPDO has come since the node became operational */
    uint32_t errors;        /* active errors, 1 << enum can_error */
    int64_t heartbeat_due_ns;
    int64_t heard_ns[CAN_CONSUMERS]; /* arrival of the last heartbeat from each watched master; 0:
                                      * none yet */
    int64_t rpdo_ns, in_force_ns;    /* arrival time of the last RPDO, and of the RPDO whose command
                                      * is in force */
    uint32_t syncs;         /* number of SYNCs since the last TPDO */
    struct can_frame sent;  /* the last TPDO */
    bool has_sent;          /* a TPDO was sent since the node became operational */
    struct can_owner owner;
};

/* Switches a node on: sets default values, clears the owner, sends the boot-up and enters
 * pre-operational. The id, 1 to 7, determines the node's kind. */
void can_node_init(struct can_node *n, int id, int64_t now_ns, struct can_queue *out);

/* Handles any frame except SYNC. */
void can_node_receive(struct can_node *n, const struct can_frame *frame, int64_t now_ns, struct can_queue *out);

/* True if the frame is the node's SYNC (0x1005). */
bool can_node_synced_by(const struct can_node *n, const struct can_frame *frame);

/* Handles SYNC: sends the latched readings or inputs, and puts the last command into force. */
void can_node_sync(struct can_node *n, const struct can_frame *sync, const struct can_tpdo *latched, struct can_queue *out);

/* Sends the heartbeat and checks the watchdogs. To be called at least every millisecond. */
void can_node_tick(struct can_node *n, int64_t now_ns, struct can_queue *out);

/* Returns the output in force; 0 unless all conditions at the top of this file are met. */
int16_t can_node_output(const struct can_node *n);

/* Functions for the SDO server (can_server.h). can_node_get() and can_node_set() read and write
 * objects, which must exist; can_consumer_of() decodes an entry of 0x1016; can_node_clear() clears
 * errors (1u << enum can_error). */
uint32_t can_node_get(const struct can_node *n, uint16_t index, uint8_t sub);
void can_node_set(struct can_node *n, uint16_t index, uint8_t sub, uint32_t value);
struct can_consumer {
    int node;               /* node to watch; 0: this entry is unused */
    uint32_t limit_ms;
};
struct can_consumer can_consumer_of(uint32_t value);
void can_node_clear(struct can_node *n, uint32_t errors, struct can_queue *out);

#endif
