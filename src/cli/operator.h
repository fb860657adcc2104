/* Handles the requests of operators and answers them. A peer is a connection (command_server.h), or
 * 0 for an LCM message, which is not answered. Main thread; nothing here blocks.
 *
 * stop and park are acted on at once, whoever sends them; until the loop has seen them, no command
 * that moves the machine is accepted. Commands that move the machine or change its gains (engage,
 * start, reset, a set with a value) are accepted
 *   - only if lcm.commands is true,
 *   - only from a peer that may move the machine, as the kernel's access check decides,
 *   - one at a time,
 *   - as long as the peer is connected: if its connection ends before the loop has acted, the
 *     request is withdrawn,
 *   - new gains only if the client has computed with this configuration and the present gains, and
 *     only by the step that gains.h allows,
 *   - under a lease, unless lcm.lease_s is 0: a peer that engaged or started holds one, and the
 *     platform is parked if the peer does not renew it for lcm.lease_s or its connection ends. A
 *     lease of engage ends when the supply is off, one of start when no test is in progress.
 * Every request of a peer is answered with the loop's reaction as soon as that is known. */
#ifndef HEXID_OPERATOR_H
#define HEXID_OPERATOR_H

#include "command_packet.h"
#include "loop.h"

/* Functions that send answers, and messages for an operator at the terminal. */
struct operator_ports {
    void *context;
    void (*answer)(void *context, uint64_t peer, const struct command_answer *answer);
    void (*say)(void *context, const char *text);
};

/* A request on which the loop has not acted yet. */
struct operator_waiting {
    uint64_t peer;       /* client that sent it; 0: no request waits */
    uint32_t id;         /* id that the client gave its request */
    uint32_t request_id; /* id that the mailbox gave the request */
    enum command command;
    int64_t since_ns;
};

struct operator_lease {
    uint64_t peer;        /* client that holds the lease; 0: none */
    enum command command; /* command that began the lease, COMMAND_ENGAGE or COMMAND_START */
    int64_t heard_ns;     /* time when the lease was granted or last renewed */
    bool expired;       /* the lease was not renewed in time, or its peer is gone, so the platform
                         * is parked */
    bool over;  /* the command that began the lease has ended: the lease is no longer watched, but
                 * its peer may still renew it */
};

enum { OPERATOR_STOPS = 64, OPERATOR_LEASES = 8 };

struct operator {
    const struct params *params;
    struct loop *loop;
    struct operator_ports ports;
    uint64_t digest;                              /* config_digest() of params */
    bool bus;                                     /* the machine is a real one on a field bus */
    bool moves;                                   /* the request in `move` is pending */
    struct operator_waiting move; /* engage, start, reset or set that was requested last */
    struct gains wanted;          /* gains that the last set requested */
    struct operator_waiting stop[OPERATOR_STOPS]; /* stops and parks whose answers are pending */
    uint32_t stop_id;                             /* mailbox id of the last stop or park, or of the
                                                   * COMMAND_NONE that replaced a withdrawn set */
    enum command stop_command;              /* the command with the id stop_id; COMMAND_NONE also
                                             * before the first stop */
    struct operator_lease lease[OPERATOR_LEASES];
    bool refused;                                 /* a refusal has been reported */
    int64_t refused_ns;                           /* time of the last report of a refusal */
    uint64_t unsaid;                            /* number of refusals since that report that were
                                                 * answered to the peer but not reported */
};

void operator_init(struct operator *o, const struct params *params, struct loop *loop, const struct operator_ports *ports);

/* Handles a request. may_move: the peer came through the socket whose permissions allow moving the
 * machine. now_ns is CLOCK_MONOTONIC in all calls. */
void operator_take(struct operator *o, uint64_t peer, const struct command_request *request, bool may_move, int64_t now_ns);

/* Withdraws the peer's pending command, and parks the platform if the peer holds a lease. To be
 * called when its connection has ended. */
void operator_gone(struct operator *o, uint64_t peer, int64_t now_ns);

/* Returns true if this peer waits for an answer or holds a lease. */
bool operator_needs(const struct operator *o, uint64_t peer);

/* Returns true if an answer waits for the loop, so that operator_tick() should be called again
 * soon. */
bool operator_waits(const struct operator *o);

/* Sends pending answers and watches the leases. To be called at least every 20 ms. */
void operator_tick(struct operator *o, int64_t now_ns);

#endif
