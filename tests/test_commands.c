/* Every command in every state, as an operator sees it. `hexid command` runs in its own process,
 * and asks the operator's side of the daemon and the loop behind it, on the simulated machine. The
 * sockets are in a directory of the test. The loop stands still except for the cycle in which it
 * sees the command, so the state is the intended one however slow this host is. The results are
 * compared with docs/commands.md; test_commands --table prints that table (make docs). */
#include "support.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "cli.h"
#include "command_client.h"
#include "commands.h"
#include "units.h"

enum {
    RING = 64,
    CYCLES_MAX = 20000,
    TEXT_SIZE = 1000,
    ROWS_MAX = 80,
    TRIES = 5,
    IN_A_TEST = 250, /* cycles until settled, ramped in and evaluated */
    A_TURN = 50      /* cycles */
};
static const double DISTURBED_S = 0.3; /* a row that took longer is measured again, because its
                                        * client may have asked twice */

/* Directory of the test's sockets; the table prints the usual places instead. */
static char directory[] = "/tmp/hexid-commands.XXXXXX";
static const char usual[] = "/run/hexid, /run/user/1000/hexid";

struct row {
    enum state state;
    enum command command;
    bool waits;           /* the client held the lease until the test killed it */
    int status;
    char state_name[80];
    char text[TEXT_SIZE]; /* lines of terminal output without "hexid: " */
};

/* The daemon's side. */
static struct bench {
    struct params params;
    struct hal hal, *machine;  /* the simulated machine behind a back-end that spoils its samples */
    struct ring ring;
    struct loop loop;
    struct commands commands;
    uint32_t open, closed;     /* INPUT_... forced to read open or closed */
    bool doubtful, contradicts;
    enum state state;          /* state after the last cycle */
    int64_t now_ns;            /* time for the operator's side: nothing expires unless the test
                                * advances it */
    void (*meanwhile)(void);   /* called instead of a cycle when a command waits for the loop */
} b;

static int spoiled_read(struct hal *hal, int64_t now_ns, struct hal_sample *sample) {
    (void)hal;
    int status = b.machine->ops->read(b.machine, now_ns, sample);
    sample->inputs = (sample->inputs & ~b.open) | b.closed;
    if (b.doubtful) sample->flags |= SAMPLE_INVALID;
    if (b.contradicts) sample->contradicted = INPUT_DOOR;
    return status;
}
static int spoiled_write(struct hal *hal, const struct hal_command *command) {
    return (void)hal, b.machine->ops->write(b.machine, command);
}
static void spoiled_safe(struct hal *hal) { (void)hal, b.machine->ops->safe(b.machine); }
static const struct hal_ops spoiled = {.scheme = "spoiled", .read = spoiled_read, .write = spoiled_write, .safe = spoiled_safe};

static void say(void *context, const char *text) { (void)context, (void)text; }

static void cycle(void) {
    struct cycle c;
    loop_cycle(&b.loop);
    while (ring_pop(&b.ring, &c)) b.state = c.state;
}

static void begin(void) {
    struct error error, doubt;
    b = (struct bench){.hal.ops = &spoiled, .params = by_hand(), .now_ns = NS_PER_S};
    b.params.lcm.commands = true;
    assert_int_equal(hal_open(&b.machine, "sim:", &b.params, 1, &error), STATUS_OK);
    assert_int_equal(ring_init(&b.ring, sizeof(struct cycle), RING), 0);
    assert_int_equal(loop_init(&b.loop, &b.params, &b.hal, &b.ring, CLOCK_VIRTUAL, &error), STATUS_OK);
    commands_init(&b.commands);
    assert_int_equal(commands_open(&b.commands, &b.params, NULL, &doubt, &error), STATUS_OK);
    assert_int_equal(doubt.status, STATUS_OK);
    commands_begin(&b.commands, &b.params, &b.loop, say, NULL);
    cycle();
}

/* Closes what the end of the daemon's process closes. */
static void close_sockets(void) {
    struct command_server *s = &b.commands.server;
    for (int k = 0; k < COMMAND_SOCKETS; k++) {
        for (int i = 0; i < COMMAND_PLACES; i++)
            if (s->place[k][i].fd >= 0) close(s->place[k][i].fd), s->place[k][i].fd = -1;
        if (s->listener[k] >= 0) close(s->listener[k]), s->listener[k] = -1;
    }
}

static void end(void) {
    commands_end(&b.commands);
    close_sockets();
    b.machine->ops->close(b.machine);
    ring_free(&b.ring);
}

static void tick(void) { operator_tick(&b.commands.operator, b.now_ns); }

/* Runs the daemon's main thread once. */
static void attend(void) {
    struct pollfd p[COMMANDS_POLLS];
    commands_polls(&b.commands, p);
    if (poll(p, COMMANDS_POLLS, 0) > 0) commands_serve(&b.commands, p, b.now_ns);
    tick();
}

static void run_until(enum state state) {
    for (int i = 0; b.state != state && i < CYCLES_MAX; i++) {
        cycle();
        if (i % A_TURN == 0)
            attend(); /* often enough, because a client waits no longer than a
                                        * second */
    }
    assert_int_equal(b.state, state);
}

static void bring_to(enum state state) {
    if (state == STATE_INIT) return;
    run_until(STATE_SETTLED);
    if (state == STATE_SETTLED) return;
    mailbox_post(&b.loop.requests, COMMAND_ENGAGE);
    run_until(STATE_PRESSURISING);
    if (state == STATE_PRESSURISING) return;
    run_until(STATE_ENGAGING);
    if (state == STATE_ENGAGING) return;
    run_until(STATE_READY);
    if (state == STATE_TESTING) mailbox_post(&b.loop.requests, COMMAND_START);
    if (state == STATE_PARKING) mailbox_post(&b.loop.requests, COMMAND_PARK);
    if (state == STATE_FAULT) b.open = INPUT_EMERGENCY_STOP;
    run_until(state);
    b.open = 0;
    for (int i = 0; state == STATE_TESTING && i < IN_A_TEST; i++) cycle();
    assert_int_equal(b.state, state);
}

/* ---- the client ---- */

struct client {
    pid_t process;
    int out;
    char text[TEXT_SIZE];
    size_t length;
    bool ended;
    int status;
};

static void start(struct client *c, const char *word) {
    char *arguments[] = {(char *)(uintptr_t)"command", (char *)(uintptr_t)word, (char *)(uintptr_t)"--set",
                         (char *)(uintptr_t)"lcm.url=", NULL};
    int ends[2];
    *c = (struct client){0};
    assert_int_equal(pipe(ends), 0);
    fflush(NULL);
    c->process = fork();
    if (c->process == 0) {
        dup2(ends[1], STDOUT_FILENO);
        dup2(ends[1], STDERR_FILENO);
        close_range(STDERR_FILENO + 1, ~0U, 0); /* closes the daemon's descriptors, which would make
                                                 * it seem alive */
        int status = cmd_command(4, arguments);
        fflush(NULL);
        _exit(status);
    }
    assert_true(c->process > 0);
    close(ends[1]);
    c->out = ends[0];
}

/* Runs the main thread once, runs the cycle for which a command waits, and collects the client's
 * output. */
static void serve(struct client *c) {
    struct pollfd p[COMMANDS_POLLS + 1];
    commands_polls(&b.commands, p);
    p[COMMANDS_POLLS] = (struct pollfd){.fd = c->out, .events = POLLIN};
    poll(p, COMMANDS_POLLS + 1, 20);
    commands_serve(&b.commands, p, b.now_ns);
    void (*meanwhile)(void) = b.meanwhile ? b.meanwhile : cycle;
    if (operator_waits(&b.commands.operator)) b.meanwhile = NULL, meanwhile();
    tick();
    if (!p[COMMANDS_POLLS].revents) return;
    ssize_t size = read(c->out, c->text + c->length, sizeof c->text - 1 - c->length);
    if (size > 0) c->length += (size_t)size;
    c->ended = size == 0;
}

static void serve_until(struct client *c, const char *word) {
    while (!c->ended && !strstr(c->text, word)) serve(c);
}

static void finish(struct client *c) {
    int status;
    assert_int_equal(waitpid(c->process, &status, 0), c->process);
    close(c->out);
    c->status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static int make_directory(void) { return !mkdtemp(directory) || setenv("HEXID_RUNTIME_DIR", directory, 1); }

static void remove_directory(void) {
    static const char *const files[] = {"hexid", "hexid.stop", "hexid.lock"};
    char path[64];
    for (int i = 0; i < 3; i++) {
        snprintf(path, sizeof path, "%s/%s", directory, files[i]);
        unlink(path);
    }
    rmdir(directory);
}

/* Copies printed lines into a table's cell, without the program's name in front. */
static void as_cell(const char *printed, char cell[TEXT_SIZE]) {
    static const char name[] = "hexid: ";
    size_t used = 0;
    for (const char *line = printed; *line;) {
        if (!strncmp(line, name, sizeof name - 1)) line += sizeof name - 1;
        int length = (int)strcspn(line, "\n");
        const char *place = memmem(line, (size_t)length, directory, strlen(directory));
        int before = place ? (int)(place - line) : length;
        used += (size_t)snprintf(cell + used, TEXT_SIZE - used, "%s%.*s%s", used ? "<br>" : "", before, line, place ? usual : "");
        if (place)
            used += (size_t)snprintf(cell + used, TEXT_SIZE - used, "%.*s", length - before - (int)strlen(directory),
                                     place + strlen(directory));
        assert_true(used < TEXT_SIZE);
        line += length + (line[length] == '\n');
    }
}

static double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static struct row ask(enum state state, enum command command, void (*prepare)(void)) {
    struct row row = {.state = state, .command = command};
    snprintf(row.state_name, sizeof row.state_name, "%s", state_names[state]);
    for (int i = 0; i < TRIES; i++) {
        struct client c;
        begin();
        bring_to(state);
        if (prepare) prepare();
        double begun_s = now_s();
        start(&c, command_names[command]);
        serve_until(&c, "renewing");
        double took_s = now_s() - begun_s;
        row.waits = !c.ended;
        if (row.waits) kill(c.process, SIGKILL);
        finish(&c);
        end();
        row.status = row.waits ? 0 : c.status;
        memset(row.text, 0, sizeof row.text);
        as_cell(c.text, row.text);
        if (took_s < DISTURBED_S) break;
    }
    return row;
}

/* ---- what else can be in the way ---- */

static void emergency_stop_open(void) { b.open = INPUT_EMERGENCY_STOP, cycle(); }
static void enable_open(void) { b.open = INPUT_ENABLE, cycle(); }
static void door_open(void) { b.open = INPUT_DOOR, cycle(); }
static void pressure_lingers(void) { b.closed = INPUT_SUPPLY, cycle(); }
static void sample_doubtful(void) { b.doubtful = true; }
static void cause_stands(void) {
    b.contradicts = true;
    for (double s = 0.0; s < 2.0 * b.params.interlocks.discrepancy_s; s += b.params.loop.period_s) cycle();
}
static void commands_off(void) { b.params.lcm.commands = false; }

static void somebody_asks(enum command command) {
    operator_take(&b.commands.operator, 0, &(struct command_request){.command = command}, false, b.now_ns);
}
static void stop_meanwhile(void) { somebody_asks(COMMAND_STOP); }
static void nothing(void) { b.meanwhile = nothing; }
static void stop_came_before(void) {
    /* the loop does not see the stop before the client has its answer */
    somebody_asks(COMMAND_STOP);
    b.meanwhile = nothing;
}
static void stop_comes_with_it(void) { b.meanwhile = stop_meanwhile; }
static void daemon_parks(void) { mailbox_post(&b.loop.requests, COMMAND_PARK), cycle(); }
static void signal_comes_with_it(void) { b.meanwhile = daemon_parks; }
static void loop_hangs(void) { b.now_ns += NS_PER_S, tick(); }
static void loop_hangs_with_it(void) { b.meanwhile = loop_hangs; }

/* ---- while the lease is renewed ---- */

static void put_down(void) {
    mailbox_post(&b.loop.requests, COMMAND_PARK);
    run_until(STATE_SETTLED);
}
static void comes_to_its_end(void) { run_until(STATE_READY); }
static void emergency_stop_pressed(void) { b.open = INPUT_EMERGENCY_STOP, run_until(STATE_FAULT); }
static void parked(void) { mailbox_post(&b.loop.requests, COMMAND_PARK), run_until(STATE_PARKING); }
static void stopped(void) { mailbox_post(&b.loop.requests, COMMAND_STOP), run_until(STATE_READY); }
static void runs_out(void) {
    b.now_ns += 2 * ns_from_seconds(b.params.lcm.lease_s);
    tick();
    run_until(STATE_PARKING);
}

/* Everything in these functions happens between two renewals. */
static void told_to_end(void) {
    mailbox_post(&b.loop.requests, COMMAND_PARK);
    for (int i = 0; b.state != STATE_SETTLED && i < CYCLES_MAX; i++) cycle();
    commands_end(&b.commands);
}
static void killed(void) {
    struct command_server *s = &b.commands.server;
    struct pollfd p[COMMANDS_POLLS];
    for (int64_t heard = s->heard; s->heard == heard;) { /* waits for one more renewal, so that the
                                                          * client has the state */
        commands_polls(&b.commands, p);
        poll(p, COMMANDS_POLLS, 20);
        commands_serve(&b.commands, p, b.now_ns);
    }
    close_sockets();
}

/* Starts a client that renews its lease, calls happens() or, if it is NULL, interrupts the client,
 * and returns the output after "renewing ...". */
static struct row hold(enum state state, enum command command, void (*happens)(void), const char *words) {
    struct row row = {.state = state, .command = command};
    struct client c;
    snprintf(row.state_name, sizeof row.state_name, "%s", words);
    begin();
    b.params.lcm.lease_s = 0.4; /* short, because the client sleeps for as long */
    bring_to(state);
    start(&c, command_names[command]);
    serve_until(&c, "parks it\n");
    assert_false(c.ended);
    if (command == COMMAND_ENGAGE) run_until(STATE_READY);
    if (happens) happens();
    else kill(c.process, SIGINT);
    serve_until(&c, "no such text");
    finish(&c);
    end();
    row.status = c.status;
    const char *after = strstr(c.text, "parks it\n");
    assert_non_null(after);
    as_cell(after + strlen("parks it\n"), row.text);
    return row;
}

/* ---- all of it ---- */

static const enum state in_order[STATES] = {STATE_INIT,  STATE_SETTLED, STATE_PRESSURISING, STATE_ENGAGING,
                                            STATE_READY, STATE_TESTING, STATE_PARKING,      STATE_FAULT};
static struct row row[ROWS_MAX];
static int rows, in_states, in_the_way;

static void add(struct row r, const char *words) {
    assert_true(rows < ROWS_MAX);
    row[rows] = r;
    if (words) snprintf(row[rows].state_name, sizeof row[rows].state_name, "%s", words);
    rows++;
}

static void read_to_the_end(struct client *c) {
    while (!c->ended) {
        ssize_t size = read(c->out, c->text + c->length, sizeof c->text - 1 - c->length);
        if (size > 0) c->length += (size_t)size;
        c->ended = size <= 0;
    }
}

/* Asks a machine whose sockets belong to a daemon that has ended or that hangs. */
static struct row ask_deaf(enum command command, bool hangs) {
    struct row r = {.command = command};
    struct client c;
    begin();
    if (!hangs) commands_end(&b.commands);
    start(&c, command_names[command]);
    read_to_the_end(&c);
    finish(&c);
    end();
    r.status = c.status;
    as_cell(c.text, r.text);
    return r;
}

static void collect(void) {
    for (int i = 0; i < STATES; i++)
        for (int command = COMMAND_ENGAGE; command < COMMANDS; command++) add(ask(in_order[i], (enum command)command, NULL), NULL);
    in_states = rows;
    add(ask(STATE_SETTLED, COMMAND_ENGAGE, emergency_stop_open), "settled, the emergency stop pressed");
    add(ask(STATE_SETTLED, COMMAND_ENGAGE, enable_open), "settled, the enable switch let go");
    add(ask(STATE_SETTLED, COMMAND_ENGAGE, door_open), "settled, a door open");
    add(ask(STATE_SETTLED, COMMAND_ENGAGE, pressure_lingers), "settled, pressure without the supply");
    add(ask(STATE_SETTLED, COMMAND_ENGAGE, sample_doubtful), "settled, in that cycle a bad sample");
    add(ask(STATE_READY, COMMAND_START, sample_doubtful), "ready, in that cycle a bad sample");
    add(ask(STATE_FAULT, COMMAND_RESET, cause_stands), "fault, its cause still there");
    add(ask(STATE_SETTLED, COMMAND_ENGAGE, commands_off), "any, without `lcm.commands: true`");
    add(ask(STATE_READY, COMMAND_START, stop_came_before), "any, another operator's stop not yet acted upon");
    add(ask(STATE_READY, COMMAND_START, stop_comes_with_it), "any, another operator's stop at the same time");
    add(ask(STATE_READY, COMMAND_START, signal_comes_with_it), "any, the daemon told to end at the same time");
    add(ask(STATE_READY, COMMAND_START, loop_hangs_with_it), "any, the loop stands still for half a second");
    add(ask_deaf(COMMAND_STOP, false), "no hexid runs");
    add(ask_deaf(COMMAND_ENGAGE, false), "no hexid runs");
    add(ask_deaf(COMMAND_STOP, true), "hexid hangs");
    add(ask_deaf(COMMAND_ENGAGE, true), "hexid hangs");
    in_the_way = rows;
    add(hold(STATE_SETTLED, COMMAND_ENGAGE, put_down, "the platform is put down"), NULL);
    add(hold(STATE_SETTLED, COMMAND_ENGAGE, emergency_stop_pressed, "a fault"), NULL);
    add(hold(STATE_SETTLED, COMMAND_ENGAGE, runs_out, "the renewals did not arrive for `lcm.lease_s`"), NULL);
    add(hold(STATE_SETTLED, COMMAND_ENGAGE, told_to_end, "hexid is told to end, parks and ends"), NULL);
    add(hold(STATE_SETTLED, COMMAND_ENGAGE, killed, "hexid is killed"), NULL);
    add(hold(STATE_SETTLED, COMMAND_ENGAGE, NULL, "Ctrl-C, SIGTERM or SIGHUP"), NULL);
    add(hold(STATE_READY, COMMAND_START, comes_to_its_end, "the tests are done"), NULL);
    add(hold(STATE_READY, COMMAND_START, stopped, "another operator stops the tests"), NULL);
    add(hold(STATE_READY, COMMAND_START, parked, "another operator parks"), NULL);
    add(hold(STATE_READY, COMMAND_START, emergency_stop_pressed, "a fault"), NULL);
    add(hold(STATE_READY, COMMAND_START, runs_out, "the renewals did not arrive for `lcm.lease_s`"), NULL);
    add(hold(STATE_READY, COMMAND_START, told_to_end, "hexid is told to end, parks and ends"), NULL);
    add(hold(STATE_READY, COMMAND_START, killed, "hexid is killed"), NULL);
    add(hold(STATE_READY, COMMAND_START, NULL, "Ctrl-C, SIGTERM or SIGHUP"), NULL);
}

static void print_rows(FILE *out, int from, int to, const char *first) {
    fprintf(out, "| %s | command | what it prints | exit status |\n| --- | --- | --- | --- |\n", first);
    for (const struct row *r = row + from; r < row + to; r++)
        fprintf(out, r->waits ? "| %s | %s | %s | stays |\n" : "| %s | %s | %s | %d |\n", r->state_name, command_names[r->command], r->text,
                r->status);
}

static void print_table(FILE *out) {
    fprintf(out, "\n## In each state\n\n");
    print_rows(out, 0, in_states, "state");
    fprintf(out, "\n## What else can be in the way\n\n");
    print_rows(out, in_states, in_the_way, "state");
    fprintf(out, "\n## While the lease is renewed\n\n");
    print_rows(out, in_the_way, rows, "what happens");
}

/* ---- claims ---- */

static const struct row *at(enum state state, enum command command) {
    for (const struct row *r = row; r < row + in_states; r++)
        if (r->state == state && r->command == command) return r;
    fail_msg("no row of %s in %s", command_names[command], state_names[state]);
    return NULL;
}

static void a_stop_and_a_park_are_never_refused(void **unused) {
    (void)unused;
    for (int state = STATE_INIT; state < STATES; state++)
        for (int i = 0; i < 2; i++) {
            const struct row *r = at((enum state)state, i ? COMMAND_PARK : COMMAND_STOP);
            if (r->status != 0 || !strstr(r->text, " done, now "))
                fail_msg("%s in %s: %s", command_names[r->command], r->state_name, r->text);
        }
}

static void what_moves_is_taken_in_its_own_state_alone(void **unused) {
    (void)unused;
    static const struct {
        enum command command;
        enum state state;
        const char *now;
    } right[] = {{COMMAND_ENGAGE, STATE_SETTLED, "engage done, now pressurising<br>renewing"},
                 {COMMAND_START, STATE_READY, "start done, now testing<br>renewing"},
                 {COMMAND_RESET, STATE_FAULT, "reset done, now init"}};
    for (int i = 0; i < 3; i++)
        for (int state = STATE_INIT; state < STATES; state++) {
            const struct row *r = at((enum state)state, right[i].command);
            bool taken = r->state == right[i].state;
            if (r->status != (taken ? 0 : 4) || !strstr(r->text, taken ? right[i].now : " refused, state "))
                fail_msg("in %s: %s", r->state_name, r->text);
        }
}

static void the_exit_status_says_what_the_words_say(void **unused) {
    (void)unused;
    for (const struct row *r = row; r < row + in_the_way; r++) {
        int status = strstr(r->text, " refused, state ")                                       ? 4
                     : strstr(r->text, "nobody answered") || strstr(r->text, "did not answer") ? 3
                                                                                               : 0;
        if (r->status != status) fail_msg("%s in %s: %d, %s", command_names[r->command], r->state_name, r->status, r->text);
        if (status == 0) continue;
        const char *why = strstr(r->text, ": ");
        assert_true(why && strlen(why) > 15); /* the text is a reason, not a code */
    }
}

static void the_end_of_a_lease_has_its_own_status(void **unused) {
    (void)unused;
    static const struct {
        int status;
        const char *words;
    } expected[] = {
        {0, "now settled"},       {1, "now fault"},
        {4, "the lease is lost"}, {0, "has ended; the platform is settled"},
        {3, "MAY STILL MOVE"},    {1, "interrupted: park done"}, /* engage */
        {0, "now ready"},         {1, "now ready: the tests were ended by a stop"},
        {1, "now parking"},       {1, "now fault"},
        {4, "the lease is lost"}, {1, "has ended; the platform is settled"},
        {3, "MAY STILL MOVE"},    {1, "interrupted: park done"}, /* start */
    };
    enum { EXPECTED = sizeof expected / sizeof *expected };
    assert_int_equal(rows - in_the_way, EXPECTED);
    for (int i = 0; i < EXPECTED; i++) {
        const struct row *r = row + in_the_way + i;
        if (r->status != expected[i].status || !strstr(r->text, expected[i].words))
            fail_msg("%s: %d, %s", r->state_name, r->status, r->text);
    }
}

/* For each command, given in state `from`: state and phase in the record of the cycle that acts on
 * it. */
static const struct {
    enum command command;
    enum state from, to;
    enum phase phase; /* phase of the motion in that cycle */
} acts[] = {
    {COMMAND_ENGAGE, STATE_SETTLED, STATE_PRESSURISING, PHASE_NONE}, {COMMAND_START, STATE_READY, STATE_TESTING, PHASE_SETTLE},
    {COMMAND_STOP, STATE_PRESSURISING, STATE_SETTLED, PHASE_NONE},   {COMMAND_STOP, STATE_ENGAGING, STATE_PARKING, PHASE_NONE},
    {COMMAND_STOP, STATE_TESTING, STATE_TESTING, PHASE_RAMP_OUT},    {COMMAND_PARK, STATE_READY, STATE_PARKING, PHASE_NONE},
    {COMMAND_PARK, STATE_TESTING, STATE_PARKING, PHASE_RAMP_OUT},    {COMMAND_RESET, STATE_FAULT, STATE_INIT, PHASE_NONE},
};
enum { ACTS = sizeof acts / sizeof *acts, TWO_CYCLES = 2 };

/* Returns the number of cycles until the command has acted. Its packet waits on the socket before
 * the main thread's first turn; then turns and cycles alternate. */
static int cycles_until_acted(int i) {
    struct command_client c;
    int cycles = 0;
    assert_int_equal(command_client_open(&c, &b.commands.server.machine, command_stops(acts[i].command), 0), 0);
    assert_int_equal(command_client_send(&c, acts[i].command, false), 0);
    for (bool acted = false; !acted && cycles <= TWO_CYCLES; cycles++) {
        struct cycle last = {0};
        attend();
        loop_cycle(&b.loop);
        while (ring_pop(&b.ring, &last)) b.state = last.state;
        acted = last.state == acts[i].to && last.phase == acts[i].phase;
    }
    attend();
    assert_int_equal(command_client_wait(&c, 0, NULL), NEWS_ANSWER);
    assert_int_equal(c.answer.outcome, OUTCOME_DONE);
    command_client_close(&c);
    return cycles;
}

static void each_command_is_acted_upon_within_two_cycles(void **unused) {
    (void)unused;
    for (int i = 0; i < ACTS; i++) {
        begin();
        bring_to(acts[i].from);
        int cycles = cycles_until_acted(i);
        end();
        print_message("%s in %s: acted upon in cycle %d\n", command_names[acts[i].command], state_names[acts[i].from], cycles);
        assert_true(cycles <= TWO_CYCLES);
    }
}

static void what_a_stalled_loop_did_not_do_it_does_not_do_later(void **unused) {
    (void)unused;
    static const struct {
        enum state state;
        enum command command;
    } moves[] = {{STATE_SETTLED, COMMAND_ENGAGE}, {STATE_READY, COMMAND_START}};
    for (int i = 0; i < 2; i++) {
        struct client c;
        begin();
        bring_to(moves[i].state);
        loop_hangs_with_it();
        start(&c, command_names[moves[i].command]);
        serve_until(&c, "renewing");
        assert_true(c.ended && strstr(c.text, "the loop does not answer"));
        finish(&c);
        for (int k = 0; k < 10; k++) {
            cycle();
            tick();
            assert_int_equal(b.state, moves[i].state);
        }
        end();
    }
}

/* One of the machines' sockets belongs to another user's program. */
static void a_stop_for_all_says_where_it_could_not_go(void **unused) {
    (void)unused;
    enum { NOBODY = 65534 };
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    struct client c;
    int ready[2];
    char byte = 0;
    if (geteuid()) skip_because("root alone can be several users");
    begin();
    snprintf(at.sun_path, sizeof at.sun_path, "%s/other.stop", directory);
    assert_int_equal(pipe(ready), 0);
    pid_t other = fork();
    if (other == 0) {
        int s = socket(AF_UNIX, SOCK_SEQPACKET, 0);
        byte = !bind(s, (struct sockaddr *)&at, sizeof at) && !setuid(NOBODY) && !listen(s, 8);
        if (write(ready[1], &byte, 1) == 1) pause();
        _exit(0);
    }
    assert_int_equal(read(ready[0], &byte, 1), 1);
    assert_true(byte);
    start(&c, "stop");
    while (!c.ended) serve(&c);
    finish(&c);
    kill(other, SIGKILL);
    waitpid(other, NULL, 0);
    unlink(at.sun_path);
    close(ready[0]), close(ready[1]);
    end();
    assert_int_equal(c.status, 3);
    assert_non_null(strstr(c.text, "stop done"));
    assert_non_null(strstr(c.text, "not told to stop"));
    assert_non_null(strstr(c.text, "/other.stop: of another user's program"));
    assert_non_null(strstr(c.text, "press the emergency stop there"));
}

/* Linked in place of bus_receive (Makefile): an endless flood of messages. */
int __wrap_bus_receive(struct bus *bus, struct bus_message *message);
int __wrap_bus_receive(struct bus *bus, struct bus_message *message) { return (void)bus, (void)message, BUS_DROPPED; }

/* The flood includes dropped messages of other hosts. The main thread must leave the processor to
 * others, because it has priority over every thread that is not real-time. */
static void a_flood_on_the_bus_leaves_the_processor_to_others(void **unused) {
    (void)unused;
    struct pollfd p[COMMANDS_POLLS] = {[COMMAND_POLLS] = {.revents = POLLIN}};
    struct timespec before, after;
    begin();
    b.commands.listens = true;
    clock_gettime(CLOCK_MONOTONIC, &before);
    commands_serve(&b.commands, p, b.now_ns);
    clock_gettime(CLOCK_MONOTONIC, &after);
    end();
    assert_true((after.tv_sec - before.tv_sec) * NS_PER_S + after.tv_nsec - before.tv_nsec >= NS_PER_S / 2000);
}

static void docs_commands_md_has_what_is_answered(void **unused) {
    (void)unused;
    static const char marker[] = "<!-- test_commands --table -->\n";
    static char page[1 << 16];
    char *table;
    size_t size;
    FILE *file = fopen("docs/commands.md", "r"), *out = open_memstream(&table, &size);
    assert_non_null(file);
    page[fread(page, 1, sizeof page - 1, file)] = '\0';
    fclose(file);
    print_table(out);
    fclose(out);
    const char *there = strstr(page, marker);
    assert_non_null(there);
    there += strlen(marker);
    size_t same = 0;
    while (there[same] && there[same] == table[same]) same++;
    if (there[same] || table[same]) {
        while (same > 0 && table[same - 1] != '\n') same--;
        fail_msg("`make docs`; answered: %.300s", table + same);
    }
    free(table);
}

int main(int argc, char **argv) {
    if (make_directory()) return 1;
    collect();
    if (argc == 2 && !strcmp(argv[1], "--table")) print_table(stdout);
    if (argc == 2) return remove_directory(), 0;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stop_and_a_park_are_never_refused),
        cmocka_unit_test(what_moves_is_taken_in_its_own_state_alone),
        cmocka_unit_test(the_exit_status_says_what_the_words_say),
        cmocka_unit_test(the_end_of_a_lease_has_its_own_status),
        cmocka_unit_test(each_command_is_acted_upon_within_two_cycles),
        cmocka_unit_test(what_a_stalled_loop_did_not_do_it_does_not_do_later),
        cmocka_unit_test(a_stop_for_all_says_where_it_could_not_go),
        cmocka_unit_test(a_flood_on_the_bus_leaves_the_processor_to_others),
        cmocka_unit_test(docs_commands_md_has_what_is_answered),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    remove_directory();
    return failed;
}
