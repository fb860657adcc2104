/* The operators of the fuzzed loop and the rules about them that must never be broken. Requests
 * come as the sockets hand them on (operator.h); a client renews its lease until it hangs or
 * disconnects. */
#ifndef HEXID_TESTS_SUPERVISOR_CLIENTS_H
#define HEXID_TESTS_SUPERVISOR_CLIENTS_H

#include "operator.h"

#include "supervisor_model.h"

enum { CLIENTS = 6, TICK_CYCLES = 10, RENEWAL = 1 };

struct client {
    uint64_t peer;               /* its connection */
    int64_t heard_ns, hangs_until; /* time of the last renewal; cycle at which the hanging ends */
    enum command waits;          /* command whose answer it awaits, COMMAND_NONE: none */
    uint32_t id;                 /* number of that command's request */
    bool leads;                  /* the lease was last granted to this client's engage */
};

struct clients {
    struct operator operator;
    struct loop *loop;
    struct client client[CLIENTS];
    uint64_t peers;
    uint32_t ids;                /* number of requests so far, renewals excluded */
    enum command asked;          /* stop or park that the next cycle must see */
    int64_t ticked;              /* cycle of the main thread's last turn */
    int unled, unheard;          /* number of consecutive cycles with the supply on and no lease, or
                                  * with an expired one */
    int64_t now_ns;
};

static inline void clients_answered(void *context, uint64_t peer, const struct command_answer *a) {
    struct clients *c = context;
    for (int i = 0; i < CLIENTS; i++) {
        struct client *one = &c->client[i];
        if (one->peer != peer) continue;
        if (a->id == RENEWAL && a->outcome != OUTCOME_REFUSED) one->heard_ns = c->now_ns;
        if (a->id != one->id) continue;
        bool granted = a->outcome == OUTCOME_DONE && one->waits == COMMAND_ENGAGE && a->lease_s > 0.0;
        for (int k = 0; k < CLIENTS && granted; k++) c->client[k].leads = k == i;
        if (granted) one->heard_ns = c->now_ns;
        one->waits = COMMAND_NONE;
    }
}

static inline void clients_said(void *context, const char *text) { (void)context, (void)text; }

static inline void clients_begin(struct clients *c, const struct params *params, struct loop *loop) {
    *c = (struct clients){.loop = loop, .ticked = -1};
    for (int i = 0; i < CLIENTS; i++) c->client[i].peer = ++c->peers;
    operator_init(&c->operator, params, loop, &(struct operator_ports){c, clients_answered, clients_said});
}

/* Sends a request of client i: with may_move over the socket of the operators' group, otherwise
 * over the socket for everybody, which accepts only stop and park. */
static inline void clients_ask(struct clients *c, int i, enum command command, bool may_move) {
    struct client *one = &c->client[i];
    const struct command_request r = {.id = RENEWAL + ++c->ids, .command = command};
    /* no packet can carry this */
    if ((unsigned)command >= COMMANDS || command == COMMAND_NONE) return;
    if (command_stops(command) && c->asked != COMMAND_PARK) c->asked = command;
    /* a client that asks again before the answer still waits for the first answer */
    if (may_move && !command_stops(command) && one->waits == COMMAND_NONE) one->waits = command, one->id = r.id;
    operator_take(&c->operator, one->peer, &r, may_move, c->now_ns);
}

static inline void clients_gone(struct clients *c, int i) {
    uint64_t peer = c->client[i].peer;
    operator_gone(&c->operator, peer, c->now_ns);
    c->client[i] = (struct client){.peer = ++c->peers, .leads = c->client[i].leads, .heard_ns = INT64_MIN / 2};
}

/* Runs the main thread's part, unless it is delayed for a while. */
static inline void clients_turn(struct clients *c, const struct params *params, int64_t cycle, bool stalls) {
    if (stalls && cycle - c->ticked < TICK_CYCLES) return;
    for (int i = 0; i < CLIENTS; i++) {
        struct client *one = &c->client[i];
        if (!one->leads || one->hangs_until > cycle || c->now_ns - one->heard_ns < ns_from_seconds(params->lcm.lease_s / 3)) continue;
        operator_take(&c->operator, one->peer, &(struct command_request){.id = RENEWAL, .renew = true}, true, c->now_ns);
    }
    operator_tick(&c->operator, c->now_ns);
    c->ticked = cycle;
}

/* Judges the request that the loop is about to see and the loop's reaction to it. */
static inline bool never_by_clients(struct clients *c, struct model *m, enum command command) {
    bool moves = command != COMMAND_NONE && !command_stops(command), waited_for = false;
    for (int i = 0; i < CLIENTS; i++) waited_for |= c->client[i].waits == command;
    never(moves && !waited_for, "the loop was told to %s, and nobody waits for it", command_names[command]);
    never(c->asked == COMMAND_PARK && command != COMMAND_PARK, "a park did not reach the loop");
    never(c->asked == COMMAND_STOP && !command_stops(command), "a stop did not reach the loop");
    c->asked = COMMAND_NONE;
    return true;
}

/* Checks that the platform is not driven if its operator has left, or has been silent for longer
 * than the main thread can be delayed. */
static inline bool never_unled(struct clients *c, struct model *m) {
    enum state state = m->before.state;
    bool led = false, heard = false;
    for (int i = 0; i < CLIENTS; i++) {
        struct client *one = &c->client[i];
        one->leads = one->leads && model_powers(state);
        led |= one->leads;
        heard |= one->leads && c->now_ns - one->heard_ns <= ns_from_seconds(m->params->lcm.lease_s);
    }
    bool needed = model_powers(state) && state != STATE_PARKING;
    c->unled = needed && !led ? c->unled + 1 : 0;
    c->unheard = needed && led && !heard ? c->unheard + 1 : 0;
    never(c->unled > 2 * TICK_CYCLES, "in %s, and nobody holds a lease", state_names[state]);
    never(c->unheard > 2 * TICK_CYCLES, "in %s, and the operator's lease has run out", state_names[state]);
    return true;
}

#endif
