/* `hexid command`: asks a running hexid over its sockets, and says what became of it. Who sets a
 * platform in motion stays and renews the lease (operator.h) until it is put down again, or tests
 * are over; ended by a signal, it parks the platform. */
#include <errno.h>
#include <signal.h>
#include <string.h>
#include <time.h>

#include "bus.h"
#include "cli.h"
#include "command_client.h"
#include "edit_distance.h"
#include "messages.h"
#include "monotonic.h"
#include "supervisor.h"
#include "units.h"

enum { ANSWER_MS = 1000, RENEWALS = 4 /* in the time of a lease */, LCM_TRIES = 3 };
#define ALARM " THE PLATFORM MAY STILL MOVE: press the emergency stop"

/* The command line, read: which command, for which machine, by which ways. */
struct asked {
    enum command command;
    const char *word; /* its name */
    const char *name; /* of the machine, "": none was named */
    const char *url;  /* of LCM, "": none */
    sigset_t during_waits; /* the mask with which it waits for signals, too */
};

static volatile sig_atomic_t interrupted; /* a signal handler can reach nothing else */
static void on_signal(int number) { interrupted = number; }

/* ---- one machine ---- */

/* Sends a request and waits for its answer. Connects again if the daemon closed the connection to
 * make room, but not for a renewal: a lease belongs to its connection. */
static enum command_news ask(struct command_client *c, enum command command, bool renew) {
    int64_t end_ms = monotonic_ms() + ANSWER_MS;
    for (int64_t left_ms = ANSWER_MS; left_ms > 0; left_ms = end_ms - monotonic_ms()) {
        enum command_news news = NEWS_LOST;
        struct command_client again;
        if (!command_client_send(c, command, renew) || renew) news = command_client_wait(c, (int)left_ms, NULL);
        if (news != NEWS_LOST || renew) return news;
        if (command_client_open(&again, &c->machine, command_stops(command), (int)left_ms)) return NEWS_LOST;
        command_client_close(c);
        again.answer = c->answer;
        again.answered = c->answered;
        *c = again;
    }
    return NEWS_NONE;
}

/* Reports that no answer came: the daemon has ended, in good order or not, or it hangs.
 * `may_move` is true if the supply was on when it was last heard of, or if that is not known. */
static int say_silent(const struct command_client *c, enum command_news news, bool may_move, const char *also, struct error *error) {
    const char *name = c->machine.name, *state = c->answered ? state_names[c->answer.state] : "not known";
    const char *alarm = may_move ? ALARM : "";
    if (news == NEWS_LEFT && !supervisor_powers(c->answer.state)) {
        printf("hexid: %s has ended; the platform is %s\n", name, state);
        return STATUS_OK;
    }
    if (news == NEWS_LEFT) return error_set(error, STATUS_IO, "%s has ended; its last state was %s." ALARM, name, state);
    if (news == NEWS_LOST) return error_set(error, STATUS_IO, "%s ended without a word; its last state: %s.%s%s", name, state, also, alarm);
    return error_set(error, STATUS_IO, "%s did not answer within %d ms: it hangs, or is not given the processor.%s%s", name, ANSWER_MS,
                     also, alarm);
}

static bool may_move(const struct command_client *c) { return !c->answered || supervisor_powers(c->answer.state); }

static int interrupted_park(struct command_client *c, struct error *error) {
    enum command_news news = ask(c, COMMAND_PARK, false);
    if (news == NEWS_ANSWER) fprintf(stderr, "hexid: interrupted: park %s\n", c->answer.outcome == OUTCOME_DONE ? "done" : c->answer.text);
    int status = news == NEWS_ANSWER ? STATUS_OK : say_silent(c, news, may_move(c), "", error);
    return status ? status : -EXIT_CHECK_FAILED;
}

/* Until what the command began is over: put down again after engage, tests done after start.
 * SAFETY: tests that ended otherwise, stopped or parked by somebody, by a lease that ran out or by
 * a fault, are no success for what comes next in a script. */
static int hold_lease(struct command_client *c, const struct asked *q, struct error *error) {
    double lease_s = c->answer.lease_s;
    bool started = q->command == COMMAND_START, left = false;
    printf("hexid: renewing the lease of %g s until the platform is %s; Ctrl-C parks it\n", lease_s, started ? "ready again" : "put down");
    fflush(stdout);
    for (;;) {
        enum command_news news = interrupted ? NEWS_NONE : command_client_wait(c, (int)(lease_s * 1000.0 / RENEWALS) + 1, &q->during_waits);
        if (interrupted && news == NEWS_NONE) return interrupted_park(c, error);
        if (news == NEWS_NONE) news = ask(c, COMMAND_NONE, true);
        left = news == NEWS_LEFT;
        if (news != NEWS_ANSWER) {
            int status = say_silent(c, news, may_move(c), "", error);
            if (status) return status;
            break;
        }
        bool renewed = c->answer.outcome == OUTCOME_DONE || c->answer.outcome == OUTCOME_STOPPED;
        if (!supervisor_powers(c->answer.state) || (started && renewed && c->answer.state != STATE_TESTING)) break;
        if (!renewed)
            return error_set(error, STATUS_UNSAFE, "the lease is lost, the platform is %s: %s", state_names[c->answer.state],
                             c->answer.text);
    }
    bool stopped = started && c->answer.outcome == OUTCOME_STOPPED;
    if (!left) printf("hexid: now %s%s\n", state_names[c->answer.state], stopped ? ": the tests were ended by a stop" : "");
    return c->answer.state == (started ? STATE_READY : STATE_SETTLED) && !stopped ? STATUS_OK : -EXIT_CHECK_FAILED;
}

static int tell(struct command_client *c, const struct asked *q, struct error *error) {
    const struct command_answer *a = &c->answer;
    enum command_news news = ask(c, q->command, false);
    if (news != NEWS_ANSWER) {
        /* who is not answered takes it back by going: nothing has begun */
        int status = say_silent(c, news, false, " The request goes with this connection: nothing has begun.", error);
        return status ? status : -EXIT_CHECK_FAILED;
    }
    if (a->outcome == OUTCOME_REFUSED) {
        fprintf(stderr, "hexid: %s refused, state %s: %s\n", q->word, state_names[a->state], a->text);
        return STATUS_UNSAFE;
    }
    printf("hexid: %s done, now %s%s%s\n", q->word, state_names[a->state], *a->text ? ": " : "", a->text);
    return a->lease_s > 0.0 ? hold_lease(c, q, error) : STATUS_OK;
}

/* ---- what moves goes to one machine ---- */

static int say_several(const struct asked *q, const struct machine *list, int count, struct error *error) {
    char names[500];
    size_t used = 0;
    for (int i = 0; i < count && used < sizeof names; i++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s (%s)", i ? ", " : "", list[i].name, list[i].directory);
    return error_set(error, STATUS_USAGE, "command %s: %d hexids run on this host: %s: name one with --machine NAME; nothing was done",
                     q->word, count, names);
}

static int say_nobody(const struct asked *q, const struct error *doubt, const char *also, struct error *error) {
    char places[300];
    machine_places(places, sizeof places);
    return error_set(error, STATUS_IO,
                     "command %s: nobody answered: no hexid%s%s is found in %s%s%.200s: is one running, and started by this user, root "
                     "or the service?%s",
                     q->word, *q->name ? " of the name " : "", q->name, places, doubt->status ? "; " : "", doubt->status ? doubt->text : "",
                     also);
}

static int say_no_way(const struct asked *q, const struct machine *m, struct error *error) {
    if (errno != EACCES)
        return error_set(error, STATUS_IO, "command %s: %s in %s: %s", q->word, m->name, m->directory,
                         errno == EPERM ? "its socket is of another user's program" : strerror(errno));
    return error_set(
        error, STATUS_UNSAFE,
        "command %s refused: %s/%s is for its user, root and group hexid, and you are none of them: `sudo adduser $USER hexid`, then "
        "log in anew (docs/install.md where there is no such group); stop and park are everybody's",
        q->word, m->directory, m->name);
}

static int move(const struct asked *q, struct error *error) {
    struct machine list[MACHINES_MAX];
    struct command_client c;
    struct error doubt;
    int count = machine_find(q->name, list, &doubt);
    if (count == 0) return say_nobody(q, &doubt, "", error);
    if (count > 1) return say_several(q, list, count, error);
    if (command_client_open(&c, list, false, ANSWER_MS)) return say_no_way(q, list, error);
    int status = tell(&c, q, error);
    command_client_close(&c);
    return status;
}

/* ---- stop and park go to all, or to the one that was named ---- */

/* Sends the stop over LCM, too, which brings no answer. Returns a sentence for the message that
 * says what was done. */
static const char *by_lcm(const struct asked *q) {
    struct error error;
    struct bus *bus;
    unsigned char buffer[COMMAND_MESSAGE_MAX];
    int size = command_encode(q->command, 0, buffer), sent = 0;
    if (!*q->url) return "";
    if (bus_open(&bus, q->url, &error)) return " LCM cannot be used either.";
    for (int i = 0; i < LCM_TRIES; i++) sent += !bus_publish(bus, CHANNEL_COMMAND, buffer, size);
    bus_close(bus);
    return sent ? " It was sent over LCM, too, where nothing answers." : " LCM did not take it either.";
}

static int report_stop(const struct command_client *c, enum command_news news, const struct asked *q, bool several, const char *also) {
    const struct command_answer *a = &c->answer;
    struct error error = {0};
    if (news == NEWS_ANSWER && a->outcome != OUTCOME_REFUSED) {
        printf("hexid: %s%s%s done, now %s%s%s\n", several ? c->machine.name : "", several ? ": " : "", q->word, state_names[a->state],
               *a->text ? ": " : "", a->text);
        return STATUS_OK;
    }
    if (news == NEWS_ANSWER) error_set(&error, STATUS_UNSAFE, "%s: %s refused: %s", c->machine.name, q->word, a->text);
    else say_silent(c, news, true, also, &error);
    if (error.status) cli_fail(&error);
    return error.status;
}

/* SAFETY: sent to all before an answer is waited for: one that hangs holds no other up. */
static int stop_found(const struct asked *q, const struct machine *list, int count) {
    struct command_client client[MACHINES_MAX];
    enum command_news news[MACHINES_MAX];
    const char *also = NULL;
    int worst = STATUS_OK;
    for (int i = 0; i < count; i++)
        if (!command_client_open(&client[i], &list[i], true, 0)) command_client_send(&client[i], q->command, false);
    int64_t end_ms = monotonic_ms() + ANSWER_MS;
    for (int i = 0; i < count; i++) {
        struct command_client *c = &client[i];
        int64_t left_ms = end_ms - monotonic_ms();
        news[i] = c->fd >= 0 ? command_client_wait(c, left_ms > 0 ? (int)left_ms : 0, NULL) : NEWS_LOST;
        if (c->fd < 0 && !command_client_open(c, &list[i], true, ANSWER_MS)) news[i] = ask(c, q->command, false);
        /* a connection that was closed to make room */
        else if (news[i] == NEWS_LOST && c->fd >= 0) news[i] = ask(c, q->command, false);
        if (!also && (news[i] == NEWS_NONE || news[i] == NEWS_LOST)) also = by_lcm(q);
    }
    for (int i = 0; i < count; i++) {
        int status = report_stop(&client[i], news[i], q, count > 1, also ? also : "");
        /* not answered is worse than refused */
        if (status && (!worst || status > worst)) worst = status;
        command_client_close(&client[i]);
    }
    return worst;
}

static int stop_all(const struct asked *q, struct error *error) {
    struct machine list[MACHINES_MAX], others[MACHINES_MAX];
    struct error doubt, other_doubt;
    char also[sizeof ALARM + 80];
    int count = machine_find(q->name, list, &doubt);
    if (count > 0) {
        int status = stop_found(q, list, count);
        /* SAFETY: it is meant for all, and may have missed one */
        if (!*q->name && doubt.status) cli_say(stderr, "hexid: warning: another machine may be there: %s", doubt.text);
        return status;
    }
    /* SAFETY: meant for one of several, it does not stop the others that share its LCM */
    bool elsewhere = *q->name && machine_find("", others, &other_doubt) > 0;
    snprintf(also, sizeof also, "%s" ALARM, elsewhere ? "" : by_lcm(q));
    return say_nobody(q, &doubt, also, error);
}

/* ---- the command line ---- */

static const char *name_of(int i) { return i + COMMAND_ENGAGE < COMMANDS ? command_names[i + COMMAND_ENGAGE] : NULL; }

static int unknown(const struct options *o, struct error *error) {
    static const char commands[] = "one of engage, start, stop, park, reset";
    if (!o->operands) return error_set(error, STATUS_USAGE, "command: %s", commands);
    const char *nearest = edit_nearest(o->operand[0], name_of);
    return error_set(error, STATUS_USAGE, "command %.100s: not %s%s%s%s", o->operand[0], commands, nearest ? "; did you mean " : "",
                     nearest ? nearest : "", nearest ? "?" : "");
}

/* Blocks the signals except while the client waits, so that they interrupt nothing else. */
static void catch_signals(struct asked *q) {
    static const int caught[] = {SIGINT, SIGTERM, SIGHUP};
    const struct sigaction action = {.sa_handler = on_signal};
    sigset_t set;
    sigemptyset(&set);
    for (int i = 0; i < (int)(sizeof caught / sizeof *caught); i++) {
        sigaction(caught[i], &action, NULL);
        sigaddset(&set, caught[i]);
    }
    sigprocmask(SIG_BLOCK, &set, &q->during_waits);
}

/* Which machine: --machine, else machine.name. SAFETY: a configuration that cannot be read holds no
 * stop up: without one it goes to all. */
static int address(const struct options *o, struct params *params, struct asked *q, struct error *error) {
    int status = options_params(o, params, error);
    if (status && command_stops(q->command)) {
        cli_say(stderr, "hexid: warning: %s: %s goes to %s", error->text, q->word, o->machine ? "the one that is named" : "all machines");
        *error = (struct error){0};
        params->machine.name[0] = params->lcm.url[0] = '\0';
        status = STATUS_OK;
    }
    q->name = o->machine ? o->machine : params->machine.name;
    q->url = params->lcm.url;
    if (status || !o->machine || machine_name_valid(o->machine)) return status;
    return error_set(error, STATUS_USAGE, "--machine %.60s: not 1 to %d of A-Z a-z 0-9 - _", o->machine, MACHINE_NAME_SIZE - 1);
}

int cmd_command(int argc, char **argv) {
    struct options o;
    struct error error = {0};
    struct params params;
    struct asked q = {.command = COMMANDS};
    int status = options_parse(&o, argc, argv, "cSN", 1, &error);
    for (int i = COMMAND_ENGAGE; !status && o.operands && i < COMMANDS; i++)
        if (!strcmp(o.operand[0], command_names[i])) q.command = (enum command)i;
    if (!status && q.command == COMMANDS) status = unknown(&o, &error);
    if (!status) {
        q.word = command_names[q.command];
        status = address(&o, &params, &q, &error);
    }
    if (!status) {
        catch_signals(&q);
        status = command_stops(q.command) ? stop_all(&q, &error) : move(&q, &error);
    }
    return status < 0 && error.status ? cli_fail(&error) : -status;
}
