/* `hexid command`: sends a command to a running hexid over its sockets and reports the result.
 * After engage or start the command keeps running and renews the lease (operator.h) until the
 * platform is parked again or the tests are over; a signal ends the command and parks the
 * platform. */
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "command_set.h"
#include "command_stop.h"
#include "edit_distance.h"
#include "monotonic.h"
#include "params.h"
#include "process.h"
#include "supervisor.h"

enum { RENEWALS = 4 /* number of times that a lease is renewed during its term */ };

static volatile sig_atomic_t interrupted; /* global, because a signal handler has no other access */
static void on_signal(int number) { interrupted = number; }

/* ---- one machine ---- */

/* Sends a request and waits for its answer. Connects again if the daemon has closed the connection
 * to make room for others, but not to renew a lease, because a lease belongs to its connection. */
static enum command_news ask(struct command_client *c, enum command command, bool renew) {
    int64_t end_ms = monotonic_ms() + ANSWER_MS;
    for (int64_t left_ms = ANSWER_MS; left_ms > 0; left_ms = end_ms - monotonic_ms()) {
        enum command_news news = NEWS_LOST;
        if (!command_client_send(c, command, renew) || renew) news = command_client_wait(c, (int)left_ms, NULL);
        if (news != NEWS_LOST || renew) return news;
        if (command_client_reopen(c, command_stops(command), (int)left_ms)) return NEWS_LOST;
    }
    return NEWS_NONE;
}

static bool may_move(const struct command_client *c) { return !c->answered || supervisor_powers(c->answer.state); }

static int interrupted_park(struct command_client *c, struct error *error) {
    enum command_news news = ask(c, COMMAND_PARK, false);
    if (news == NEWS_ANSWER) fprintf(stderr, "hexid: interrupted: park %s\n", c->answer.outcome == OUTCOME_DONE ? "done" : c->answer.text);
    int status = news == NEWS_ANSWER ? STATUS_OK : report_silent(c, news, may_move(c), "", error);
    return status ? status : -EXIT_CHECK_FAILED;
}

/* Renews the lease until the command has ended: after engage when the platform is parked again,
 * after start when the tests are done. SAFETY: tests that ended otherwise (stopped or parked by
 * somebody, by an expired lease or by a fault) are not a success, so that a script does not go
 * on. */
static int hold_lease(struct command_client *c, const struct asked *q, struct error *error) {
    double lease_s = c->answer.lease_s;
    bool started = q->command == COMMAND_START, left = false;
    int renewed_each_ms = (int)(lease_s * MS_PER_S / RENEWALS) + 1;
    printf("hexid: renewing the lease of %g s until the platform is %s; Ctrl-C parks it\n", lease_s, started ? "ready again" : "put down");
    fflush(stdout);
    for (;;) {
        enum command_news news = interrupted ? NEWS_NONE : command_client_wait(c, renewed_each_ms, &q->during_waits);
        if (interrupted && news == NEWS_NONE) return interrupted_park(c, error);
        if (news == NEWS_NONE) news = ask(c, COMMAND_NONE, true);
        left = news == NEWS_LEFT;
        if (news != NEWS_ANSWER) {
            int status = report_silent(c, news, may_move(c), "", error);
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
        /* the daemon withdraws an unanswered request when its connection closes */
        int status = report_silent(c, news, false, " The request goes with this connection: nothing has begun.", error);
        return status ? status : -EXIT_CHECK_FAILED;
    }
    if (a->outcome == OUTCOME_REFUSED) {
        fprintf(stderr, "hexid: %s refused, state %s: %s\n", q->word, state_names[a->state], a->text);
        return STATUS_UNSAFE;
    }
    printf("hexid: %s done, now %s%s%s\n", q->word, state_names[a->state], *a->text ? ": " : "", a->text);
    return a->lease_s > 0.0 ? hold_lease(c, q, error) : STATUS_OK;
}

/* ---- commands that move go to one machine ---- */

static int say_several(const struct asked *q, int count, struct error *error) {
    char names[NAMES_SIZE];
    report_names(q, count, names);
    return error_set(error, STATUS_USAGE, "command %s: %d hexids run on this host: %s: name one with --machine NAME; nothing was done",
                     q->word, count, names);
}

static int say_no_way(const struct asked *q, const struct machine_name *m, struct error *error) {
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
    struct command_client c;
    struct error doubt;
    int count = machine_find(q->name, q->found, &doubt);
    if (count == 0) return report_nobody(q, &doubt, "", error);
    if (count > 1) return say_several(q, count, error);
    if (command_client_open(&c, q->found, false, ANSWER_MS)) return say_no_way(q, q->found, error);
    int status = q->command == COMMAND_SET ? command_set(&c, q->params, q->setting, error) : tell(&c, q, error);
    command_client_close(&c);
    return status;
}

/* ---- the command line ---- */

static const char *name_of(int i) { return i + COMMAND_ENGAGE < COMMANDS ? command_names[i + COMMAND_ENGAGE] : NULL; }

static int unknown(const struct options *o, struct error *error) {
    static const char commands[] = "one of engage, start, stop, park, reset, set";
    if (!o->operands) return error_set(error, STATUS_USAGE, "command: %s", commands);
    const char *nearest = edit_nearest(o->operand[0], name_of);
    return error_set(error, STATUS_USAGE, "command %.100s: not %s%s%s%s", o->operand[0], commands, nearest ? "; did you mean " : "",
                     nearest ? nearest : "", nearest ? "?" : "");
}

/* Blocks the signals except while hold_lease() waits, so that they interrupt nothing but that
 * wait. */
static void catch_signals(struct asked *q) {
    static const int caught[] = {SIGINT, SIGTERM, SIGHUP};
    const struct sigaction action = {.sa_handler = on_signal};
    sigset_t set;
    sigemptyset(&set);
    for (int i = 0; i < (int)(sizeof caught / sizeof *caught); i++) {
        if (process_ignores(caught[i])) continue;
        sigaction(caught[i], &action, NULL);
        sigaddset(&set, caught[i]);
    }
    sigprocmask(SIG_BLOCK, &set, &q->during_waits);
}

/* Chooses the machine: --machine, else machine.name. SAFETY: an unreadable configuration does not
 * prevent a stop, which then goes to all machines unless --machine names one. */
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

/* SAFETY: this memory is on the heap, because a stop must work even on a small stack. */
struct memory {
    struct params params;
    struct machine_name found[MACHINES_MAX];
};

static int carry_out(const struct options *o, struct asked *q, struct error *error) {
    struct memory *memory = calloc(1, sizeof *memory);
    if (!memory) return error_set(error, STATUS_IO, "command %s: out of memory.%s", q->word, command_stops(q->command) ? ALARM : "");
    q->found = memory->found;
    q->params = &memory->params;
    int status = address(o, &memory->params, q, error);
    if (!status) {
        catch_signals(q);
        status = command_stops(q->command) ? command_stop(q, error) : move(q, error);
    }
    free(memory);
    return status;
}

int cmd_command(int argc, char **argv) {
    struct options o;
    struct error error = {0};
    struct asked q = {.command = COMMANDS};
    int status = options_parse(&o, argc, argv, "cSN", 2, &error);
    for (int i = COMMAND_ENGAGE; !status && o.operands && i < COMMANDS; i++)
        if (!strcmp(o.operand[0], command_names[i])) q.command = (enum command)i, q.word = command_names[i];
    if (!status && q.command == COMMANDS) status = unknown(&o, &error);
    if (!status && o.operands > 1 && q.command != COMMAND_SET)
        status = error_set(&error, STATUS_USAGE, "%.100s: one argument too many, `hexid command %s` takes none", o.operand[1], q.word);
    q.setting = o.operands > 1 ? o.operand[1] : NULL;
    if (!status) status = command_set_check(q.setting, &error);
    if (!status) status = carry_out(&o, &q, &error);
    return status < 0 && error.status ? cli_fail(&error) : -status;
}
