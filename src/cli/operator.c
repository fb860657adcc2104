#include "operator.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "config.h"
#include "failure.h"
#include "gains.h"
#include "number_text.h"
#include "params.h"
#include "supervisor.h"
#include "units.h"

static const int64_t answer_patience_ns = NS_PER_S / 2;
static const int64_t said_every_ns = NS_PER_S / 5; /* interval between messages about refusals */

void operator_init(struct operator *o, const struct params *params, struct loop *loop, const struct operator_ports *ports) {
    *o = (struct operator){.params = params, .loop = loop, .ports = *ports};
    o->digest = config_digest(params);
    o->bus = loop && loop->hal && !loop->hal->ops->simulated;
}

/* Writes the kind of machine, "bus" or "sim", and the present gains; a client computes the loop
 * from them: "bus control.kp=40 control.ki=20 ...". */
static void write_gains(const struct operator *o, char text[COMMAND_TEXT_SIZE]) {
    char value[NUMBER_SIZE];
    struct gains gains = loop_gains(o->loop);
    int used = snprintf(text, COMMAND_TEXT_SIZE, "%s", o->bus ? "bus" : "sim");
    for (int i = 0; i < LOOP_GAINS; i++)
        used += snprintf(text + used, COMMAND_TEXT_SIZE - (size_t)used, " %s=%s", gain_keys[i], number_shortest(gains.value[i], value));
}

static void answer(struct operator *o, uint64_t peer, uint32_t id, enum outcome outcome, double lease_s, const char *text) {
    struct command_answer a = {.id = id, .lease_s = lease_s, .outcome = outcome, .state = loop_acted(o->loop).state};
    if (!peer) return;
    snprintf(a.text, sizeof a.text, "%s", text);
    o->ports.answer(o->ports.context, peer, &a);
}

/* Refuses a request and answers it. Any program on this host can cause ten thousand refusals a
 * second, so terminal and bus get only a few reports a second, each with the number of refusals
 * since the last report. */
static void refuse(struct operator *o, uint64_t peer, uint32_t id, enum command command, const char *why, int64_t now_ns) {
    char text[COMMAND_TEXT_SIZE + 100], more[64] = "";
    answer(o, peer, id, OUTCOME_REFUSED, 0.0, why);
    if (o->refused && now_ns - o->refused_ns < said_every_ns) {
        o->unsaid++;
        return;
    }
    if (o->unsaid) snprintf(more, sizeof more, " (and %" PRIu64 " commands before it)", o->unsaid);
    snprintf(text, sizeof text, "%s refused: %s%s", command_names[command], why, more);
    o->ports.say(o->ports.context, text);
    o->refused = true, o->refused_ns = now_ns, o->unsaid = 0;
}

/* Returns true if the loop has processed this request or a later one. */
static bool reached(const struct operator *o, uint32_t request_id) { return (int32_t)(loop_acted(o->loop).request_id - request_id) >= 0; }

/* Returns true if the loop has not seen the last stop yet. The mailbox holds one request only, so
 * another request would replace the stop. */
static bool stop_under_way(const struct operator *o) { return o->stop_id && !reached(o, o->stop_id); }

/* ---- requests ---- */

/* Remembers a stop whose answer is to be sent later. A peer may have one request at a time, so of
 * two stops of a peer only the later one is answered. */
static void owe(struct operator *o, const struct operator_waiting *w) {
    int place = -1;
    if (!w->peer) return;
    for (int i = OPERATOR_STOPS - 1; i >= 0; i--)
        if (!o->stop[i].peer) place = i;
    for (int i = 0; i < OPERATOR_STOPS; i++)
        if (o->stop[i].peer == w->peer) place = i;
    if (place >= 0) o->stop[place] = *w;
}

/* SAFETY: posts a stop or park. If the loop has not seen the last park yet, a park is posted in
 * place of a stop, because the stop would replace that park in the mailbox. */
static void post_stop(struct operator *o, enum command command) {
    if (stop_under_way(o) && o->stop_command == COMMAND_PARK) command = COMMAND_PARK;
    o->stop_id = mailbox_post(&o->loop->requests, command);
    o->stop_command = command;
}

enum { WHY_SIZE = 200 };

/* SAFETY: returns why these gains are not set: the state does not allow it, the client computed
 * with a configuration or with gains that are not the daemon's, or the change is too large. NULL:
 * they may be set. */
static const char *why_not_set(const struct operator *o, const struct gain_change *c, char text[WHY_SIZE]) {
    struct gains now = loop_gains(o->loop);
    enum state state = loop_acted(o->loop).state;
    int gain = gains_refused(&now, &c->to);
    if (state != STATE_READY && state != STATE_SETTLED) return supervisor_advice(state, 0, COMMAND_SET);
    if (c->digest != o->digest)
        return "the client's configuration is not this machine's: give hexid command the -c and --set with which the daemon was started";
    if (!gains_equal(&c->from, &now)) return "the gains have been changed in between: ask again";
    if (gain == LOOP_GAINS) return NULL;
    snprintf(text, WHY_SIZE, "%s from %g to %g: at once by a factor of %g at most, within 0..%g, and neither from 0 nor to it",
             gain_keys[gain], now.value[gain], c->to.value[gain], GAINS_FACTOR, gain_most[gain]);
    return text;
}

/* SAFETY: posts a command that moves the machine or sets gains. It is refused if the peer lacks the
 * permission, the configuration forbids such commands, the loop parks because the thread that takes
 * stops was held up, a stop or another operator's command is pending, no lease is free, or
 * why_not_set() has a reason. */
static void move(struct operator *o, uint64_t peer, const struct command_request *r, bool may_move, int64_t now_ns) {
    const char *why = NULL;
    char text[WHY_SIZE];
    int leases = 0;
    for (int i = 0; i < OPERATOR_LEASES; i++) leases += o->lease[i].peer && !o->lease[i].over;
    if (!may_move || !peer) why = "this way takes stop and park only; what moves comes over the machine's own socket, from group hexid";
    else if (!o->params->lcm.commands) why = "set lcm.commands to true to accept commands that move";
    else if (atomic_load_explicit(&o->loop->unattended, memory_order_relaxed))
        why = "stops could not be taken for a while, so nothing else is: ask again in a second";
    else if (stop_under_way(o)) why = "a stop came just before: ask again when it has been acted upon";
    else if (o->moves) why = "another operator's command is under way: ask again";
    else if (leases == OPERATOR_LEASES) why = "too many operators hold a lease: let one of them end";
    else if (r->command == COMMAND_SET) why = why_not_set(o, &r->change, text);
    if (why) {
        refuse(o, peer, r->id, r->command, why, now_ns);
        return;
    }
    if (r->command == COMMAND_SET) gains_box_put(&o->loop->gains, &r->change.to), o->wanted = r->change.to;
    o->move = (struct operator_waiting){peer, r->id, mailbox_post(&o->loop->requests, r->command), r->command, now_ns};
    o->moves = true;
}

static struct operator_lease *lease_of(struct operator *o, uint64_t peer) {
    for (int i = 0; peer && i < OPERATOR_LEASES; i++)
        if (o->lease[i].peer == peer) return &o->lease[i];
    return NULL;
}

static void renew(struct operator *o, uint64_t peer, const struct command_request *r, int64_t now_ns) {
    struct operator_lease *lease = lease_of(o, peer);
    bool holds = lease && !lease->expired;
    if (holds) lease->heard_ns = now_ns;
    enum outcome renewed = loop_acted(o->loop).stopped ? OUTCOME_STOPPED : OUTCOME_DONE;
    answer(o, peer, r->id, holds ? renewed : OUTCOME_REFUSED, holds ? o->params->lcm.lease_s : 0.0,
           holds   ? ""
           : lease ? "the lease has run out: ask `engage` anew"
                   : "no lease is held here: `engage` or `start` gives one");
}

static void tell_gains(struct operator *o, uint64_t peer, uint32_t id) {
    char text[COMMAND_TEXT_SIZE];
    write_gains(o, text);
    answer(o, peer, id, OUTCOME_DONE, 0.0, text);
}

void operator_take(struct operator *o, uint64_t peer, const struct command_request *r, bool may_move, int64_t now_ns) {
    /* SAFETY: stops come first, from anybody */
    if (command_stops(r->command)) {
        post_stop(o, r->command);
        owe(o, &(struct operator_waiting){peer, r->id, o->stop_id, r->command, now_ns});
    } else if (r->renew) renew(o, peer, r, now_ns);
    else if (r->command == COMMAND_SET && !r->sets) tell_gains(o, peer, r->id);
    else move(o, peer, r, may_move, now_ns);
}

/* ---- answers ---- */

static void grant_lease(struct operator *o, const struct operator_waiting *w, int64_t now_ns) {
    struct operator_lease *lease = lease_of(o, w->peer);
    for (int i = 0; !lease && i < OPERATOR_LEASES; i++)
        if (!o->lease[i].peer || o->lease[i].over) lease = &o->lease[i];
    /* if a peer has engaged and now starts the tests, its lease remains one of engage */
    bool engaged = lease && lease->peer == w->peer && !lease->over && lease->command == COMMAND_ENGAGE;
    if (lease) *lease = (struct operator_lease){.peer = w->peer, .command = engaged ? COMMAND_ENGAGE : w->command, .heard_ns = now_ns};
}

/* SAFETY: withdraws the pending command: a stop (after start) or a park replaces it in the mailbox,
 * and also undoes it if the loop has acted on it meanwhile. */
static void withdraw(struct operator *o) {
    o->moves = false;
    if (o->move.command != COMMAND_SET) post_stop(o, o->move.command == COMMAND_START ? COMMAND_STOP : COMMAND_PARK);
    else if (!stop_under_way(o)) { /* a set is replaced by COMMAND_NONE, because a stop would end
                                    * another peer's motion */
        o->stop_id = mailbox_post(&o->loop->requests, COMMAND_NONE);
        o->stop_command = COMMAND_NONE;
    }
}

/* Returns why a request had no effect. After a reset without effect the cause of the fault
 * persists, and the text has its remedy. */
static const char *why_not_taken(const struct loop_acted *acted, enum command command, char text[WHY_SIZE]) {
    bool stands = command == COMMAND_RESET && acted->state == STATE_FAULT && acted->first_fault;
    if (!stands) return supervisor_advice(acted->state, acted->wrong, command);
    snprintf(text, WHY_SIZE, "the fault %s stands: %s", fault_name(acted->first_fault), failure_of(acted->first_fault)->remedy);
    return text;
}

static void answer_move(struct operator *o, int64_t now_ns) {
    char text[WHY_SIZE];
    struct loop_acted acted = loop_acted(o->loop);
    const struct operator_waiting w = o->move;
    if (!o->moves) return;
    if (!reached(o, w.request_id)) {
        if (stop_under_way(o) && w.command != COMMAND_SET) {
            o->moves = false;
            refuse(o, w.peer, w.id, w.command, "another command came at the same time: ask again", now_ns);
        } else if (now_ns - w.since_ns >= answer_patience_ns) {
            withdraw(o);
            refuse(o, w.peer, w.id, w.command,
                   w.command == COMMAND_SET ? "the loop does not answer; whether the gains were changed `hexid command set` says"
                                            : "the loop does not answer: see whether hexid is given the processor",
                   now_ns);
        }
        return;
    }
    o->moves = false;
    if (w.command == COMMAND_SET) { /* the loop's gains show whether the set had an effect,
                                     * whichever request the loop acted on last */
        struct gains now = loop_gains(o->loop);
        bool other = acted.request_id != w.request_id;
        if (gains_equal(&now, &o->wanted)) tell_gains(o, w.peer, w.id);
        else
            refuse(o, w.peer, w.id, w.command,
                   other ? "another command came in between: ask again" : why_not_taken(&acted, w.command, text), now_ns);
        return;
    }
    if (acted.request_id != w.request_id) refuse(o, w.peer, w.id, w.command, "another command came in between: ask again", now_ns);
    else if (!acted.taken) refuse(o, w.peer, w.id, w.command, why_not_taken(&acted, w.command, text), now_ns);
    else {
        bool leased = (w.command == COMMAND_ENGAGE || w.command == COMMAND_START) && o->params->lcm.lease_s > 0.0;
        if (leased) grant_lease(o, &w, now_ns);
        answer(o, w.peer, w.id, OUTCOME_DONE, leased ? o->params->lcm.lease_s : 0.0, "");
    }
}

/* SAFETY: answers stops. A stop is answered only when the loop has acted on it, however long the
 * loop stalls. If a later stop has replaced it in the mailbox, it is answered when the loop has
 * acted on the later one. */
static void answer_stops(struct operator *o) {
    struct loop_acted acted = loop_acted(o->loop);
    for (int i = 0; i < OPERATOR_STOPS; i++) {
        struct operator_waiting w = o->stop[i];
        if (!w.peer || !reached(o, w.request_id)) continue;
        bool ramping = acted.state == STATE_TESTING && w.command == COMMAND_STOP,
             nothing = acted.request_id == w.request_id && !acted.taken;
        o->stop[i].peer = 0;
        answer(o, w.peer, w.id, OUTCOME_DONE, 0.0,
               nothing   ? supervisor_advice(acted.state, acted.wrong, w.command)
               : ramping ? "the motion is ramped out first"
                         : "");
    }
}

/* ---- leases ---- */

/* SAFETY: parks the platform when a lease is not renewed or its peer is gone. A machine must not
 * stay in motion without its operator. The park is posted in every call until the loop parks,
 * because another request may replace it in the mailbox. */
static void watch_lease(struct operator *o, struct operator_lease *lease, bool gone, int64_t now_ns) {
    enum state state = loop_acted(o->loop).state;
    lease->over |= !supervisor_powers(state) || (lease->command == COMMAND_START && state != STATE_TESTING);
    if (lease->over && gone) lease->peer = 0;
    if (!lease->peer || lease->over) return;
    bool out = gone || lease->expired || now_ns - lease->heard_ns > ns_from_seconds(o->params->lcm.lease_s);
    if (!out || state == STATE_PARKING) return;
    post_stop(o, COMMAND_PARK);
    if (!lease->expired)
        o->ports.say(o->ports.context,
                     gone ? "the operator's connection has ended: parking" : "the operator's lease has run out (lcm.lease_s): parking");
    lease->expired = true;
}

void operator_gone(struct operator *o, uint64_t peer, int64_t now_ns) {
    answer_move(o, now_ns); /* if the loop has already acted on the peer's command, this grants the
                             * lease that is then ended below */
    if (o->moves && o->move.peer == peer) {
        withdraw(o);
        o->ports.say(o->ports.context, "the operator's connection has ended before the command was acted upon: taken back");
    }
    for (int i = 0; i < OPERATOR_STOPS; i++)
        if (o->stop[i].peer == peer) o->stop[i].peer = 0;
    struct operator_lease *lease = lease_of(o, peer);
    if (lease) watch_lease(o, lease, true, now_ns);
}

bool operator_needs(const struct operator *o, uint64_t peer) {
    bool needs = o->moves && o->move.peer == peer;
    for (int i = 0; i < OPERATOR_STOPS; i++) needs |= o->stop[i].peer == peer;
    for (int i = 0; i < OPERATOR_LEASES; i++) needs |= o->lease[i].peer == peer;
    return needs;
}

bool operator_waits(const struct operator *o) {
    bool waits = o->moves;
    for (int i = 0; i < OPERATOR_STOPS; i++) waits |= o->stop[i].peer != 0;
    return waits;
}

void operator_tick(struct operator *o, int64_t now_ns) {
    answer_move(o, now_ns);
    answer_stops(o);
    for (int i = 0; i < OPERATOR_LEASES; i++) watch_lease(o, &o->lease[i], false, now_ns);
}
