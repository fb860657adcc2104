/* What operators ask for over the bus, and what is told to them. The main thread's;
 * nothing here blocks.
 *
 * stop and park are acted upon at once, whoever on this host sends them; until the loop has seen
 * one, no command that moves the machine is taken. Those (engage, start, reset) are taken
 *   - only where lcm.commands is true,
 *   - with a token that was sent to this operator within the last second. The first request gets
 *     the token, the second brings it back: a replayed log, a message of another session or one
 *     left over somewhere has none, and no clocks are compared;
 *   - under a lease: engage and start are answered with another token, and when that has not come
 *     back in a `renew` for lcm.lease_s while the supply is on, the platform is parked.
 * Every request with an id is answered with what the loop did about it, once that is known. */
#ifndef HEXID_OPERATOR_H
#define HEXID_OPERATOR_H

#include "bus.h"
#include "loop.h"
#include "messages.h"

struct operator {
    const struct params *params;
    struct loop *loop;
    struct bus *bus;
    /* Called with what an operator at the terminal should know. */
    void (*say)(void *context, const char *text);
    void *context;
    int64_t token, token_ns;     /* 0: none given; when it was given, CLOCK_MONOTONIC */
    int64_t lease, lease_ns;     /* 0: nobody holds one; when it was last renewed */
    bool powered, expired;       /* the supply was on since the lease was given; the lease ran out,
                                  * and `say` was told so */
    struct operator_request waiting; /* its answer waits for the loop */
    uint32_t waiting_request;    /* its id in the mailbox, 0: nothing waits */
    int64_t waiting_ns;
};

void operator_init(struct operator *o, const struct params *params, struct loop *loop, struct bus *bus,
                   void (*say)(void *context, const char *text), void *context);

/* A message of CHANNEL_COMMAND; what is no request is dropped. */
void operator_take(struct operator *o, const struct bus_message *message, int64_t now_ns);

/* Sends answers that have become known, and watches the lease. At least every 20 ms. */
void operator_tick(struct operator *o, int64_t now_ns);

#endif
