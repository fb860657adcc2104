/* The daemon's side of the CANopen nodes, six axes and, if an input or output is wired, the I/O
 * module (can_nodes()): set-up, supervision, samples. Pure: frames and time in, frames and samples
 * out. RT, no heap.
 *
 * A node:  lost      --heartbeat or SDO reply-->                set-up
 *          set-up    --last SDO reply-->                        starting
 *          set-up    --an abort, or an unexpected value-->      refused
 *          set-up    --no SDO reply after three tries-->        lost
 *          refused   --half a second-->                         set-up
 *          starting  --heartbeat "operational"-->               running
 *          starting  --no such heartbeat for 0.2 s-->           set-up
 *          running   --heartbeat in another state-->            set-up
 *          running   --no frame for three heartbeat periods-->  lost
 *          any       --boot-up, or EMCY 0x8130 or 0x8250-->     set-up
 *
 * Set-up, in pre-operational: the master checks the identity, claims the node (0x2000:1), writes
 * watchdogs, SYNC and PDOs, reads these settings back, and repeats the claim. SAFETY: a node with
 * other values is not started.
 *
 * SAFETY: one master. CAN frames carry no sender, but echoes of own frames are marked. Any other
 * frame that only a master sends comes from another master, and makes the next sample
 * SAMPLE_FOREIGN.
 *
 * A lost node is sent an SDO request twice a second, and is set up again as soon as it replies or
 * sends a heartbeat. Every sample is invalid while a node is not running, so the supervisor and the
 * operator decide whether the platform may move again.
 *
 * A cycle: the window of a sample opens with the echo of a SYNC, at the moment when the bus carried
 * that SYNC, and closes with the next echo. If all TPDOs, including that of the inputs, come within
 * the window, they are a sample, latched at the SYNC. If a TPDO is missing, the last complete
 * sample is returned again, marked stale. If the time between two SYNCs differs from the period by
 * more than half a period, the sample of the second SYNC is marked late.
 *
 * A TPDO does not show to which SYNC it belongs, and a late TPDO must not be taken for an answer to
 * the next SYNC. So if a TPDO is missing, the next command and SYNC pause for a cycle, in which the
 * TPDO can still come within its own window. If it does not come then, it may come in a later
 * window; so every SYNC is followed by a pause, until all nodes have answered before their pause
 * began. Thus all legs of a sample belong to one instant, even with losses or delays of up to two
 * cycles. A leg that is always late halves the rate, and every sample is marked late.
 *
 * A sent command inverts the supply output if the loop has changed the requested level since the
 * previous sent command, even if a second change has restored the level. So the life sign continues
 * even if every second cycle pauses.
 *
 * SAFETY: one node, one answer. A bus may repeat a frame once; a node that keeps answering twice is
 * two devices with one number, and nobody knows which device is right. If two TPDOs of a node in
 * one window differ, or a TPDO has a wrong length, the sample is SAMPLE_TWIN, and an input counts
 * as closed only if all TPDOs show it closed. Weaker signs (equal TPDOs twice in a window, more
 * heartbeats than configured, replies without a request, other frames of a wrong length) fill two
 * leaky buckets of the node; while either of them is full, every sample is SAMPLE_TWIN.
 *
 * SAFETY: a missing reading is NaN, which the limit checks find (platform.c); an EMCY 0x5000 of the
 * same node is then ignored. Every other active EMCY, and every node that is not running, makes the
 * sample invalid. */
#ifndef HEXID_CAN_MASTER_H
#define HEXID_CAN_MASTER_H

#include <stddef.h>

#include "can_node.h"

enum can_phase { CAN_LOST, CAN_REFUSED, CAN_SETUP, CAN_STARTING, CAN_RUNNING };

/* State of the bus as the controller reports it in error frames. */
enum can_bus { CAN_BUS_GOOD, CAN_BUS_PASSIVE, CAN_BUS_OFF };

/* State of a pause, which is a cycle without SYNC: none, due, or done. */
enum can_pause { CAN_NO_PAUSE, CAN_PAUSE_DUE, CAN_PAUSED };

/* Kind of a node's refusal of a set-up step: none, an abort, or another value than expected. */
enum can_refusal_kind { CAN_ACCEPTED, CAN_ABORTED, CAN_OTHERWISE };
struct can_refusal {
    enum can_refusal_kind kind;
    uint16_t index;
    uint8_t sub;
    uint32_t value;            /* abort code, or the value read */
};

/* True if the node refused the claim because another master owns it. */
static inline bool can_refused_by_owner(const struct can_refusal *r) {
    return r->kind == CAN_ABORTED && r->index == 0x2000 && r->value == SDO_DENIED;
}

struct can_peer {
    enum can_phase phase;
    int step, tries;           /* number of the current set-up step, and how often its request was
                                * sent */
    int64_t deadline_ns;       /* time from which the node is asked or set up again if it has not
                                * answered */
    bool halted;       /* the node was told to enter pre-operational, in which it can be set up */
    bool claimed;        /* the node belongs to this master, or has no object 0x2000 and can have no
                          * owner */
    struct can_refusal refusal;/* the node's refusal; valid in phase CAN_REFUSED */
    int64_t heard_ns;          /* arrival time of the node's last well-formed frame */
    uint16_t emcy;             /* code of the node's active error; 0: none */
    struct can_tpdo tpdo;
    bool fresh;                /* a TPDO has come in this window */
    bool again;                /* more than one TPDO came in this window */
    bool contradicts;          /* since the last sample, two TPDOs of one window differed, or a TPDO
                                * had a wrong length */
    int twice;                /* level of a leaky bucket that counts windows with a repeated TPDO */
    int asked;                 /* number of SDO requests that may still be answered */
    int64_t odd_ns;         /* time at which the node's leaky bucket of excess frames (ODD_MAX in
                             * can_master.c) will be empty */
    bool known;   /* the node was neither lost nor refused nor rebooted since the last complete
                   * sample */
};

#define FOREIGN_HEARD 0x800u

struct can_master {
    const struct params *params;
    int nodes;                 /* number of expected nodes */
    uint32_t token;            /* token with which this master claims nodes */
    struct can_peer peer[CAN_NODES];
    enum can_bus bus;
    unsigned foreign;          /* identifier of the first frame of another master since the last
                                * sample, or'ed with FOREIGN_HEARD; 0: none */
    int64_t heartbeat_due_ns;
    uint64_t syncs;            /* number of own SYNCs that the bus has carried */
    int unechoed;             /* number of SYNCs sent since the last echo of a SYNC */
    int64_t sync_ns, gap_ns;   /* time of the last SYNC's echo; time from the echo before to that
                                * one */
    bool doubt;                /* a TPDO of an older window may still arrive */
    enum can_pause pause;      /* this window needs no pause, will have one, or has had one */
    bool punctual;             /* all TPDOs of this window had arrived when its pause began */
    bool centred;              /* the last command centred the valves */
    bool given, due, level;    /* supply output. given: level that the loop requested last. due: the
                                * loop has changed the level since the last sent command. level:
                                * level that was sent last */
    struct can_tpdo latched[CAN_NODES]; /* TPDOs of the last complete sample */
    uint64_t latched_sync;     /* number of the SYNC that latched this sample; 0: none yet */
    int64_t latched_ns, latched_gap_ns;
    bool delivered;            /* the last complete sample has been returned */
    uint32_t closed;           /* inputs that all TPDOs since the last returned sample show as
                                * closed */
    int64_t now_ns;            /* time of the last call of can_master_poll() */
    /* Counts of events, for tests only: windows without all TPDOs, repeated TPDOs, TPDOs that are
     * malformed or precede the first SYNC, error frames, boot-ups of nodes. */
    uint64_t lost, twice, stray, errors, boots;
};

/* Initialises the master. token: unique to this session, not 0. */
void can_master_init(struct can_master *m, const struct params *params, uint32_t token);

/* Handles a frame from the bus, also an error frame. own: the frame is the echo of one that this
 * master has sent. time_ns: time of receipt, on the clock of can_master_poll(). */
void can_master_receive(struct can_master *m, const struct can_frame *frame, bool own, int64_t time_ns);

/* Checks time-outs. Sends the heartbeat if it is due and `alive` is set, and the SDO requests and
 * NMT commands of the set-up. To be called in every cycle after the received frames. now_ns: any
 * steady clock. */
void can_master_poll(struct can_master *m, int64_t now_ns, bool alive, struct can_queue *out);

/* True if all nodes are running and the controller is not in bus-off, so that a command can be
 * written. */
bool can_master_ready(const struct can_master *m);

/* True if all nodes are claimed; the heartbeat then keeps the claims. SAFETY: bring-up sends no
 * heartbeat before all nodes are claimed, because a heartbeat would keep another master's claims
 * alive. */
bool can_master_claimed(const struct can_master *m);

/* True if a node has another identity or mapping than expected, or refuses its set-up, so that
 * waiting does not help. A refusal because the node has another owner does not count. */
bool can_master_misfit(const struct can_master *m);

/* Returns the first node, 1 to 7, with a full leaky bucket, which means that two devices answer for
 * it; 0 if there is none. */
int can_master_twin(const struct can_master *m);

/* Tells the master that the socket was replaced. The master then no longer waits for echoes of
 * frames sent on the old socket, and takes the bus as good. */
void can_master_new_bus(struct can_master *m);

/* Sends the commands for six legs and for the supply output, then SYNC, whose echo opens the next
 * sample's window. In a pause nothing is sent, except the first command that centres the valves. */
void can_master_command(struct can_master *m, const struct hal_command *command, struct can_queue *out);

/* Sends frames that centre the valves and leave the supply output unchanged. */
void can_master_safe(struct can_master *m, struct can_queue *out);

/* Called at the end: sends all nodes to pre-operational, where their valves are centred, and
 * releases the nodes that this master has claimed. */
void can_master_leave(const struct can_master *m, struct can_queue *out);

/* Writes the last complete sample to *sample; a sample that was returned before is marked stale. To
 * be called once a cycle, after can_master_poll(). time_ns is on the clock of can_master_receive();
 * the caller sets age_ns. */
void can_master_sample(struct can_master *m, struct hal_sample *sample);

/* Current problems of the bus, packed in two words for atomic variables; both words are 0 if there
 * is none. Functions in can_condition.c. */
struct can_condition {
    uint64_t state;   /* bus, phases, EMCY, another master's frame, twin; bit 63 is free for the
                       * caller */
    uint64_t refusal; /* refusal of the first node that has refused its set-up */
};
struct can_condition can_master_condition(const struct can_master *m);

/* Describes a condition: "node 3 lost, node 5 EMCY 0x8250", "node 3 refused 0x1400:5: abort
 * 0x06090031, value too high"; "" without a problem. */
void can_condition_describe(struct can_condition condition, const struct params *params, char *text, size_t size);

/* Returns the configured value of a node's identity object; -1: any value is accepted. Sets *key to
 * the configuration key, or to NULL if the object is not part of the identity. */
double can_identity(const struct params *params, int node, uint16_t index, uint8_t sub, const char **key);

#endif
