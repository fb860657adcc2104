/* The daemon's side of the CANopen nodes, six axes and, where an input or output is wired, the I/O
 * module (can_nodes()): set-up, supervision, samples. Pure: frames and time in, frames and samples
 * out. RT, no heap.
 *
 * A node:  lost      --boot-up, heartbeat or SDO reply-->  set-up
 *          set-up    --last SDO reply-->                   starting
 *          starting  --heartbeat "operational"-->          running
 *          set-up    --an abort, or a value that is not what it must be-->  refused
 *          refused   --half a second-->                    set-up
 *          any       --nothing heard for three heartbeats, boot-up, heartbeat in another state,
 *                      no SDO reply after three tries-->   lost or set-up
 *
 * Set-up, in pre-operational: who it is, a claim of it for this master (0x2000:1), watchdogs, PDOs;
 * then all that was written is read back. SAFETY: a node that answers otherwise is not started.
 *
 * SAFETY: one master. CAN frames carry no sender, but those of our own come back marked: any other
 * that only a master sends makes the next sample SAMPLE_FOREIGN.
 *
 * A lost node is asked twice a second, and set up again by itself whenever it comes back; whether
 * the platform may move again is the supervisor's and the operator's decision, because every sample
 * from a bus with a node that is not running is invalid.
 *
 * A cycle: the window of a sample opens with SYNC (its own echo from the bus: the bus has carried
 * it, and when) and closes with the next. All TPDOs came in it, the inputs' too: a sample, latched
 * at the SYNC. One is missing: the last whole sample again, stale and older. A SYNC half a period
 * and more off the grid makes its sample late.
 *
 * A TPDO does not say which SYNC it answers, and a late one must not pass for the answer to the
 * next. So when one is missing, the next command and SYNC wait for a cycle, in which it comes
 * into its own window. Does it not, it may come into a later one: they wait after every SYNC
 * until all have answered in the first of the two cycles. The legs of a sample are of one
 * instant, whatever is lost or late by up to two cycles; a leg that is late for good halves the
 * rate, and every sample is late.
 *
 * The supply output changes with every command that is sent, as long as the level it was given has
 * changed since the one before: a charge pump goes on where every second cycle waits.
 *
 * SAFETY: one node, one answer. A bus may repeat a frame once; a node that goes on answering twice
 * is two devices with one number, and nobody can know which one is right. Two different TPDOs of a
 * node in one window, or one of another length, make the sample SAMPLE_TWIN, and an input is closed
 * only where all of them say so. What says the same (a TPDO twice in a window, more heartbeats than
 * were asked for, answers to no request, frames of a wrong length) fills a leaky bucket of the
 * node, and every sample is SAMPLE_TWIN while one is full.
 *
 * SAFETY: a reading that is missing is NaN, and the platform knows what that means for it; an EMCY
 * 0x5000 of the same node says no more. Every other EMCY that stands, and every node that is not
 * running, makes the sample invalid. */
#ifndef HEXID_CAN_MASTER_H
#define HEXID_CAN_MASTER_H

#include <stddef.h>

#include "can_node.h"

enum can_phase { CAN_LOST, CAN_REFUSED, CAN_SETUP, CAN_STARTING, CAN_RUNNING };

/* State of the bus as the controller reports it in error frames. */
enum can_bus { CAN_BUS_GOOD, CAN_BUS_PASSIVE, CAN_BUS_OFF };

/* A cycle without SYNC: not asked for, still to come, or been. */
enum can_pause { CAN_NO_PAUSE, CAN_PAUSE_DUE, CAN_PAUSED };

/* What a node answered in its set-up in place of what it should. */
enum can_refusal_kind { CAN_ACCEPTED, CAN_ABORTED, CAN_OTHERWISE };
struct can_refusal {
    enum can_refusal_kind kind;
    uint16_t index;
    uint8_t sub;
    uint32_t value;            /* abort code, or what stands in the object */
};

/* Another master's token stands there. */
static inline bool can_refused_by_owner(const struct can_refusal *r) {
    return r->kind == CAN_ABORTED && r->index == 0x2000 && r->value == SDO_DENIED;
}

struct can_peer {
    enum can_phase phase;
    int step, tries;           /* of the set-up */
    int64_t deadline_ns;       /* of the reply that is waited for */
    bool halted;               /* told to leave operational: it can be set up */
    bool claimed;              /* it is ours, or cannot be owned */
    struct can_refusal refusal;/* while refused */
    int64_t heard_ns;          /* last frame */
    uint16_t emcy;             /* standing error */
    struct can_tpdo tpdo;
    bool fresh;                /* came in this window, */
    bool again;                /* and came again */
    bool contradicts;          /* it said two things since the last sample was handed out */
    int twice;                 /* leaky bucket of windows in which it came again */
    int asked;                 /* SDO requests that may still be answered */
    int64_t odd_ns;            /* leaky bucket of all other frames too many: empty by then */
    bool known;                /* neither lost nor refused nor booted since the last whole sample */
};

#define FOREIGN_HEARD 0x800u

struct can_master {
    const struct params *params;
    int nodes;                 /* that are expected */
    uint32_t token;            /* of this master */
    struct can_peer peer[CAN_NODES];
    enum can_bus bus;
    unsigned foreign;          /* identifier of the first frame of another master since the last
                                * sample, with FOREIGN_HEARD */
    int64_t heartbeat_due_ns;
    uint64_t syncs;            /* carried by the bus */
    int unechoed;              /* sent since the last one that was carried */
    int64_t sync_ns, gap_ns;   /* echo of the last one, and time since the one before */
    bool doubt;                /* a TPDO of an older window may still come */
    enum can_pause pause;      /* in this window */
    bool punctual;             /* all TPDOs were there before it */
    bool centred;              /* the last command */
    bool given, due, level;    /* the supply output as it was given last, whether that is a change
                                * still to be sent, and what is sent */
    struct can_tpdo latched[CAN_NODES]; /* the last whole sample, */
    uint64_t latched_sync;     /* its SYNC, 0: none yet */
    int64_t latched_ns, latched_gap_ns;
    bool delivered;            /* it has been handed out */
    uint32_t closed;           /* inputs that all TPDOs since then say are closed */
    int64_t now_ns;            /* of the last poll */
    /* counted for the operator */
    uint64_t lost, twice, stray, errors, boots;
};

/* The token is this session's, not 0 and nobody else's. */
void can_master_init(struct can_master *m, const struct params *params, uint32_t token);

/* A frame from the bus, own ones (their echoes) and error frames included, with the time it was
 * received on any clock that goes on steadily. */
void can_master_receive(struct can_master *m, const struct can_frame *frame, bool own, int64_t time_ns);

/* Time-outs; heartbeat when `alive`, SDO requests and NMT of the set-up. Every cycle, after the
 * frames that have come. */
void can_master_poll(struct can_master *m, int64_t now_ns, bool alive, struct can_queue *out);

/* All nodes are running and the bus carries frames: a command can be written. */
bool can_master_ready(const struct can_master *m);

/* All nodes are claimed: from now on the heartbeat keeps them so. SAFETY: not before, or it would
 * keep another master's claims alive. */
bool can_master_claimed(const struct can_master *m);

/* A node is not what is configured, or does not take its set-up: more time would change nothing. */
bool can_master_misfit(const struct can_master *m);

/* Returns the first node, 1 to 7, for which two devices answer; 0 if there is none. */
int can_master_twin(const struct can_master *m);

/* Tells the master that the socket was replaced: it no longer waits for echoes of frames that the
 * old one sent, and forgets the controller's error state. */
void can_master_new_bus(struct can_master *m);

/* Commands of six legs, the supply output, then SYNC: the sample's window opens with its echo.
 * Nothing in a cycle that waits for a TPDO, but for the first command to the centre. */
void can_master_command(struct can_master *m, const struct hal_command *command, struct can_queue *out);

/* The same with the valves at the centre and the supply output as it is. */
void can_master_safe(struct can_master *m, struct can_queue *out);

/* The end: all nodes out of operational, and released. */
void can_master_leave(const struct can_master *m, struct can_queue *out);

/* The sample of the last window; time_ns on the clock of the frames; age_ns is the caller's. */
void can_master_sample(struct can_master *m, struct hal_sample *sample);

/* What is wrong now, in two words that fit atomics: all 0 when nothing is. can_condition.c. */
struct can_condition {
    uint64_t state;   /* bus, phases, EMCY, frame of another master; bit 63 is the caller's */
    uint64_t refusal; /* of the first node that has one */
};
struct can_condition can_master_condition(const struct can_master *m);

/* That in words: "node 3 lost, node 5 EMCY 0x8250", "node 3 refused 0x1400:5: abort 0x06090031,
 * value too high"; "" when nothing is wrong. */
void can_condition_describe(struct can_condition condition, const struct params *params, char *text, size_t size);

/* What is configured for this object of a node's identity, -1: anything; the key's name, or NULL
 * when the object is none. */
double can_identity(const struct params *params, int node, uint16_t index, uint8_t sub, const char **key);

#endif
