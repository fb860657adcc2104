#include "operator.h"

#include <string.h>
#include <sys/random.h>

#include "units.h"

static const int64_t token_valid_ns = NS_PER_S, settle_ns = NS_PER_S;
enum { ANSWER_PATIENCE_NS = 500000000 };

void operator_init(struct operator *o, const struct params *params, struct loop *loop, struct bus *bus,
                   void (*say)(void *context, const char *text), void *context) {
    *o = (struct operator){.params = params, .loop = loop, .bus = bus, .say = say, .context = context};
}

/* Never 0; the time stands in for a kernel without random numbers. */
static int64_t random_token(int64_t now_ns) {
    int64_t token = 0;
    if (getrandom(&token, sizeof token, GRND_NONBLOCK) != (ssize_t)sizeof token) token = now_ns;
    return token ? token : 1;
}

static void answer(struct operator *o, int64_t id, enum outcome outcome, int64_t token, const char *text) {
    unsigned char buffer[ANSWER_MESSAGE_MAX];
    const struct answer a = {.id = id,
                             .token = token,
                             .lease_s = outcome <= OUTCOME_STOPPED && token ? o->params->lcm.lease_s : 0.0,
                             .outcome = outcome,
                             .state = loop_acted(o->loop).state,
                             .text = text};
    if (id) bus_publish(o->bus, CHANNEL_ANSWER, buffer, answer_encode(&a, buffer));
}

static void refuse(struct operator *o, const struct operator_request *r, const char *why) {
    unsigned char buffer[ANSWER_MESSAGE_MAX];
    char text[300];
    snprintf(text, sizeof text, "%s refused: %s", command_names[r->command], why);
    answer(o, r->id, OUTCOME_REFUSED, 0, why);
    int size = event_encode(clock_now(&o->loop->clock), 0, "command", text, buffer, sizeof buffer);
    bus_publish(o->bus, CHANNEL_EVENT, buffer, size);
    o->say(o->context, text);
}

/* A stop that the loop has not yet seen: the mailbox holds one request, and a later one
 * would take its place. */
static bool stop_under_way(const struct operator *o) {
    return o->waiting_request && command_stops(o->waiting.command) && (int32_t)(loop_acted(o->loop).request_id - o->waiting_request) < 0;
}

static void post(struct operator *o, const struct operator_request *request, int64_t now_ns) {
    struct operator_request r = *request, before = o->waiting;
    bool displaces = o->waiting_request != 0;
    /* SAFETY: a stop does not undo it */
    if (stop_under_way(o) && before.command == COMMAND_PARK) r.command = COMMAND_PARK;
    o->waiting_request = mailbox_post(&o->loop->requests, r.command);
    o->waiting = r;
    o->waiting_ns = now_ns;
    if (displaces) answer(o, before.id, OUTCOME_REFUSED, 0, "another command came at the same time: ask again");
}

static void renew(struct operator *o, const struct operator_request *r, int64_t now_ns) {
    bool holds = o->lease && !o->expired && r->token == o->lease;
    if (holds) o->lease_ns = now_ns;
    enum outcome renewed = loop_acted(o->loop).stopped ? OUTCOME_STOPPED : OUTCOME_DONE;
    answer(o, r->id, holds ? renewed : OUTCOME_REFUSED, holds ? o->lease : 0,
           holds ? "" : "the lease has run out, or is another's: ask `engage` anew");
}

/* SAFETY: whoever on this host reaches the bus may put the platform down; only the configuration,
 * and an answer that was given to this operator just now, let it be moved from there. */
static void move(struct operator *o, const struct operator_request *r, int64_t now_ns) {
    bool fresh = o->token && r->token == o->token && now_ns - o->token_ns <= token_valid_ns;
    if (!o->params->lcm.commands) {
        refuse(o, r, "set lcm.commands to true to accept commands that move");
    } else if (stop_under_way(o)) {
        refuse(o, r, "a stop came just before: ask again when it has been acted upon");
    } else if (!r->id) {
        refuse(o, r, "a command that moves needs an id and a token (request_t); `hexid command` brings them");
    } else if (!fresh) {
        if (!o->token || now_ns - o->token_ns > token_valid_ns) o->token = random_token(now_ns), o->token_ns = now_ns;
        answer(o, r->id, OUTCOME_TOKEN, o->token, "");
    } else {
        o->token = 0; /* good for once */
        post(o, r, now_ns);
    }
}

void operator_take(struct operator *o, const struct bus_message *message, int64_t now_ns) {
    struct operator_request r;
    if (strcmp(message->channel, CHANNEL_COMMAND) || !request_decode(message->data, message->size, &r)) return;
    /* SAFETY: first of all, and from anybody on this host */
    if (command_stops(r.command)) post(o, &r, now_ns);
    else if (r.renew) renew(o, &r, now_ns);
    else move(o, &r, now_ns);
}

static void grant_lease(struct operator *o, int64_t now_ns) {
    if (!(o->params->lcm.lease_s > 0.0)) return;
    if (!o->lease) o->lease = random_token(now_ns), o->powered = false;
    o->expired = false;
    o->lease_ns = now_ns;
}

static void answer_waiting(struct operator *o, int64_t now_ns) {
    struct loop_acted acted = loop_acted(o->loop);
    const struct operator_request *r = &o->waiting;
    if (!o->waiting_request) return;
    if ((int32_t)(acted.request_id - o->waiting_request) < 0) {
        /* SAFETY: a stop waits for a loop that stalls */
        if (command_stops(r->command) || now_ns - o->waiting_ns < ANSWER_PATIENCE_NS) return;
        /* SAFETY: what is refused is not done when the loop comes back: this takes its place
         * there, or undoes it. */
        mailbox_post(&o->loop->requests, r->command == COMMAND_START ? COMMAND_STOP : COMMAND_PARK);
        refuse(o, r, "the loop does not answer: see whether hexid is given the processor");
    } else if (acted.request_id != o->waiting_request) {
        refuse(o, r, "another command came in between: ask again");
    } else if (!acted.taken && command_stops(r->command)) {
        /* it is as was asked for */
        answer(o, r->id, OUTCOME_DONE, 0, supervisor_advice(acted.state, acted.wrong, r->command));
    } else if (!acted.taken) {
        refuse(o, r, supervisor_advice(acted.state, acted.wrong, r->command));
    } else {
        bool leased = r->command == COMMAND_ENGAGE || r->command == COMMAND_START;
        bool ramping = acted.state == STATE_TESTING && r->command == COMMAND_STOP;
        if (leased) grant_lease(o, now_ns);
        answer(o, r->id, OUTCOME_DONE, leased ? o->lease : 0, ramping ? "the motion is ramped out first" : "");
    }
    o->waiting_request = 0;
}

/* SAFETY: an operator who went away does not leave a machine in motion. */
static void watch_lease(struct operator *o, int64_t now_ns) {
    if (!o->lease) return;
    enum state state = loop_acted(o->loop).state;
    bool powers = supervisor_powers(state);
    o->powered |= powers;
    if (!powers && (o->powered || now_ns - o->lease_ns > settle_ns)) {
        o->lease = 0;
    } else if (powers && state != STATE_PARKING && now_ns - o->lease_ns > ns_from_seconds(o->params->lcm.lease_s)) {
        mailbox_post(&o->loop->requests, COMMAND_PARK); /* again, until it is seen */
        if (!o->expired) o->say(o->context, "the operator's lease has run out (lcm.lease_s): parking");
        o->expired = true;
    }
}

void operator_tick(struct operator *o, int64_t now_ns) {
    answer_waiting(o, now_ns);
    watch_lease(o, now_ns);
}
