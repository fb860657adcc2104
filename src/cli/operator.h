/* Requests of operators, and the answers to them. The main thread's; nothing here blocks, and
 * nothing knows how requests come: a peer is a connection (command_server.h), 0 a message of LCM,
 * which is not answered.
 *
 * stop and park are acted upon at once, whoever sends them; until the loop has seen one, no command
 * that moves the machine is taken. Those (engage, start, reset) are taken
 *   - only where lcm.commands is true,
 *   - only from a peer that may move it: one whom the kernel has let in,
 *   - one at a time,
 *   - as long as the peer is there: when its connection ends before the loop has acted, the request
 *     is taken back,
 *   - under a lease: whoever engaged or started holds one until what that began is over, and the
 *     platform is parked when the peer has not renewed it for lcm.lease_s or its connection ends. A
 *     lease of engage is over when the supply is off, one of start when no test is under way.
 * Every request of a peer is answered with what the loop did about it, once that is known. */
#ifndef HEXID_OPERATOR_H
#define HEXID_OPERATOR_H

#include "command_packet.h"
#include "loop.h"

/* Calls by which answers leave, and what an operator at the terminal should know. */
struct operator_ports {
    void *context;
    void (*answer)(void *context, uint64_t peer, const struct command_answer *answer);
    void (*say)(void *context, const char *text);
};

/* A request of which it is not known yet what the loop did about it. */
struct operator_waiting {
    uint64_t peer;       /* 0: nobody waits */
    uint32_t id;         /* the client's */
    uint32_t request_id; /* in the mailbox */
    enum command command;
    int64_t since_ns;
};

struct operator_lease {
    uint64_t peer;        /* 0: none */
    enum command command; /* COMMAND_ENGAGE or COMMAND_START: what it is for */
    int64_t heard_ns;
    bool expired;         /* it ran out, or its peer is gone: parking */
    bool over;            /* what it was for is: its peer is told so, and it is not watched */
};

enum { OPERATOR_STOPS = 64, OPERATOR_LEASES = 8 };

struct operator {
    const struct params *params;
    struct loop *loop;
    struct operator_ports ports;
    bool moves;                                   /* move is under way */
    struct operator_waiting move;                 /* engage, start or reset */
    struct operator_waiting stop[OPERATOR_STOPS]; /* answers that are owed */
    uint32_t stop_id;                             /* of the last stop or park in the mailbox; */
    enum command stop_command;                    /* 0: none */
    struct operator_lease lease[OPERATOR_LEASES];
    bool refused;                                 /* something was, and said so */
    int64_t refused_ns;                           /* then; */
    uint64_t unsaid;                              /* and so many since that were only answered */
};

void operator_init(struct operator *o, const struct params *params, struct loop *loop, const struct operator_ports *ports);

/* Times are CLOCK_MONOTONIC. */
void operator_take(struct operator *o, uint64_t peer, const struct command_request *request, bool may_move, int64_t now_ns);

/* Called when the peer's connection has ended. */
void operator_gone(struct operator *o, uint64_t peer, int64_t now_ns);

/* Tells whether this peer waits for an answer or holds a lease. */
bool operator_needs(const struct operator *o, uint64_t peer);

/* Tells whether something waits for the loop, so that operator_tick() should be called again
 * soon. */
bool operator_waits(const struct operator *o);

/* Sends answers that have become known, and watches the leases. At least every 20 ms. */
void operator_tick(struct operator *o, int64_t now_ns);

#endif
