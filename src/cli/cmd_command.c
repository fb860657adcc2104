/* `hexid command`: asks a running hexid over LCM, and says what became of it. Who sets a platform
 * in motion stays and renews the lease (operator.h) until it is put down again, or tests are over;
 * ended by a signal, it parks the platform. */
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>

#include "bus.h"
#include "cli.h"
#include "edit_distance.h"
#include "messages.h"
#include "supervisor.h"
#include "units.h"

enum { ANSWER_MS = 1000, RENEWALS = 4 /* in the time of a lease */ };

struct client {
    struct bus *bus;
    const char *url;
};

static volatile sig_atomic_t interrupted; /* a signal handler can reach nothing else */
static void on_signal(int number) { interrupted = number; }

static int64_t now_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000LL + t.tv_nsec / 1000000;
}

static int send_request(struct client *c, const struct operator_request *r, struct error *error) {
    unsigned char buffer[COMMAND_MESSAGE_MAX];
    if (!bus_publish(c->bus, CHANNEL_COMMAND, buffer, request_encode(r, buffer))) return STATUS_OK;
    return error_set(error, STATUS_IO, "command: not sent: %s", strerror(errno));
}

/* The answer to this id; 1, 0 when none came in time, or STATUS_IO. a->text lives
 * until the next one. */
static int wait_for_answer(struct client *c, int64_t id, int patience_ms, struct answer *a) {
    struct bus_message m;
    for (int64_t end_ms = now_ms() + patience_ms, left_ms = patience_ms; left_ms > 0; left_ms = end_ms - now_ms()) {
        if (bus_wait(c->bus, (int)left_ms) < 0) return STATUS_IO;
        for (int got; (got = bus_receive(c->bus, &m));) {
            if (got < 0) return STATUS_IO;
            if (got == 1 && !strcmp(m.channel, CHANNEL_ANSWER) && answer_decode(m.data, m.size, a) && a->id == id) return 1;
        }
    }
    return 0;
}

/* One request and its answer; a token that it is answered with is brought back. Datagrams get lost:
 * asked three times. */
static int ask(struct client *c, struct operator_request r, struct answer *a, struct error *error) {
    const char *word = r.renew ? "renew" : command_names[r.command];
    if (getrandom(&r.id, sizeof r.id, 0) != (ssize_t)sizeof r.id || r.id == 0) r.id = now_ms();
    for (int tries = 0; tries < 3; tries++) {
        int status = send_request(c, &r, error);
        int got = status ? 0 : wait_for_answer(c, r.id, ANSWER_MS / 3, a);
        if (status) return status;
        if (got < 0) return error_set(error, STATUS_IO, "command %s: sent, but LCM is broken", word);
        if (got && a->outcome != OUTCOME_TOKEN) return STATUS_OK;
        if (got) r.token = a->token;
    }
    return error_set(error, STATUS_IO,
                     "command %s: nobody answered within %d ms: no hexid of this host listens on %s, or it does not "
                     "say what became of it: is one running, with this lcm.url?%s",
                     word, ANSWER_MS, c->url,
                     command_stops(r.command) || r.renew ? " THE PLATFORM MAY STILL MOVE: press the emergency stop" : "");
}

static int park(struct client *c, struct error *error) {
    struct answer a;
    int status = ask(c, (struct operator_request){.command = COMMAND_PARK}, &a, error);
    if (!status) fprintf(stderr, "hexid: interrupted: park %s\n", a.outcome == OUTCOME_DONE ? "done" : a.text);
    return status ? status : -EXIT_CHECK_FAILED;
}

/* Until what the command began is over: put down again after engage, tests done after start.
 * SAFETY: tests that ended otherwise, stopped or parked by somebody, by a lease that ran out or by
 * a fault, are no success for what comes next in a script. */
static int hold_lease(struct client *c, enum command command, const struct answer *granted, struct error *error) {
    struct answer a = *granted;
    bool started = command == COMMAND_START;
    int period_ms = (int)(granted->lease_s * 1000.0 / RENEWALS) + 1;
    printf("hexid: renewing the lease of %g s until the platform is %s; Ctrl-C parks it\n", granted->lease_s,
           started ? "ready again" : "put down");
    fflush(stdout);
    for (;;) {
        struct timespec pause = {.tv_sec = period_ms / 1000, .tv_nsec = period_ms % 1000 * 1000000L};
        if (!interrupted) nanosleep(&pause, NULL);
        if (interrupted) return park(c, error);
        int status = ask(c, (struct operator_request){.token = granted->token, .renew = true}, &a, error);
        if (status) return status;
        bool renewed = a.outcome == OUTCOME_DONE || a.outcome == OUTCOME_STOPPED;
        if (!supervisor_powers(a.state) || (started && renewed && a.state != STATE_TESTING)) break;
        if (!renewed) return error_set(error, STATUS_UNSAFE, "the lease is lost, the platform is %s: %s", state_names[a.state], a.text);
    }
    bool stopped = started && a.outcome == OUTCOME_STOPPED;
    printf("hexid: now %s%s\n", state_names[a.state], stopped ? ": the tests were ended by a stop" : "");
    return a.state == (started ? STATE_READY : STATE_SETTLED) && !stopped ? STATUS_OK : -EXIT_CHECK_FAILED;
}

static int tell(struct client *c, enum command command, struct error *error) {
    struct answer a;
    int status = ask(c, (struct operator_request){.command = command}, &a, error);
    if (status) return status;
    if (a.outcome == OUTCOME_REFUSED) {
        fprintf(stderr, "hexid: %s refused, state %s: %s\n", command_names[command], state_names[a.state], a.text);
        return STATUS_UNSAFE;
    }
    printf("hexid: %s done, now %s%s%s\n", command_names[command], state_names[a.state], *a.text ? ": " : "", a.text);
    return a.lease_s > 0.0 ? hold_lease(c, command, &a, error) : STATUS_OK;
}

static const char *name_of(int i) { return i + COMMAND_ENGAGE < COMMANDS ? command_names[i + COMMAND_ENGAGE] : NULL; }

static int unknown(const struct options *o, struct error *error) {
    static const char commands[] = "one of engage, start, stop, park, reset";
    if (!o->operands) return error_set(error, STATUS_USAGE, "command: %s", commands);
    const char *nearest = edit_nearest(o->operand[0], name_of);
    return error_set(error, STATUS_USAGE, "command %.100s: not %s%s%s%s", o->operand[0], commands, nearest ? "; did you mean " : "",
                     nearest ? nearest : "", nearest ? "?" : "");
}

int cmd_command(int argc, char **argv) {
    const struct sigaction action = {.sa_handler = on_signal};
    struct options o;
    struct error error = {0};
    struct params params;
    struct client c = {0};
    enum command command = COMMANDS;
    int status = options_parse(&o, argc, argv, "cS", 1, &error);
    for (int i = COMMAND_ENGAGE; !status && o.operands && i < COMMANDS; i++)
        if (!strcmp(o.operand[0], command_names[i])) command = (enum command)i;
    if (!status && command == COMMANDS) status = unknown(&o, &error);
    if (!status) status = options_bus(&o, &params, &c.bus, &error);
    if (!status) {
        sigaction(SIGINT, &action, NULL);
        sigaction(SIGTERM, &action, NULL);
        sigaction(SIGHUP, &action, NULL);
        c.url = params.lcm.url;
        status = bus_listen(c.bus, CHANNEL_ANSWER, BUS_ANYONE, &error);
        if (!status) status = tell(&c, command, &error);
        bus_close(c.bus);
    }
    return status < 0 && error.status ? cli_fail(&error) : -status;
}
