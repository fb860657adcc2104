#include "commands.h"

#include <string.h>
#include <time.h>
#include <unistd.h>

#include "clock.h"
#include "messages.h"
#include "params.h"
#include "units.h"

enum {
    MESSAGES_AT_ONCE = 64, /* largest number of LCM messages taken in a row, so that a flood of
                            * messages does not stop other work */
    EVENT_MAX = COMMAND_TEXT_SIZE + 200,
    IDLE_MS = 20,
    SOON_MS = 2,
    FLOOD = 32,       /* number of packets, connections and messages in one wake-up that counts as a
                       * flood */
    REST_NS = 500000, /* pause after a flood, ns, in which other threads get the processor */
};
static const int64_t look_every_ns = NS_PER_S; /* interval between checks of the sockets' files */

/* ---- between the sockets and operator.h ---- */

static void take(void *context, uint64_t peer, const struct command_request *request, bool may_move) {
    struct commands *c = context;
    operator_take(&c->operator, peer, request, may_move, c->now_ns);
}

static void gone(void *context, uint64_t peer) {
    struct commands *c = context;
    operator_gone(&c->operator, peer, c->now_ns);
}

static bool needs(void *context, uint64_t peer) {
    const struct commands *c = context;
    return operator_needs(&c->operator, peer);
}

static bool over(void *context) {
    const struct commands *c = context;
    return atomic_load_explicit(&c->operator.loop->ended, memory_order_acquire);
}

static void answer(void *context, uint64_t peer, const struct command_answer *a) {
    struct commands *c = context;
    command_server_answer(&c->server, peer, a);
}

static void say(void *context, const char *text) {
    struct commands *c = context;
    unsigned char buffer[EVENT_MAX];
    int size = event_encode(clock_now(&c->operator.loop->clock), 0, "command", text, buffer, sizeof buffer);
    if (c->bus && size > 0) bus_publish(c->bus, CHANNEL_EVENT, buffer, size);
    c->say(c->context, text);
}

void commands_init(struct commands *c) {
    *c = (struct commands){.missing = COMMAND_SOCKETS, .handler = {.context = c, .take = take, .gone = gone, .needs = needs, .over = over}};
    command_server_init(&c->server);
}

static int open_sockets(struct commands *c, const char *name, struct error *doubt, struct error *error) {
    struct error refused;
    int status = command_server_open(&c->server, name, &c->handler, &refused);
    *error = refused;
    if (status != STATUS_IO) return status;
    error_set(doubt, STATUS_IO,
              "%.600s: nobody can command this hexid but by signals and, where it is heard, LCM; set "
              "HEXID_RUNTIME_DIR to a directory of this user, for hexid and hexid command alike",
              refused.text);
    return STATUS_OK;
}

static int listen_to_bus(struct commands *c, const char *others, struct error *doubt, struct error *error) {
    struct error wrong;
    if (!c->bus) return STATUS_OK;
    if (bus_allow(c->bus, others, &wrong)) return error_set(error, STATUS_USAGE, "lcm.remote_stop: %.300s", wrong.text);
    c->listens = bus_listen(c->bus, CHANNEL_COMMAND, BUS_THIS_HOST, doubt) == STATUS_OK;
    return STATUS_OK;
}

int commands_open(struct commands *c, const struct params *params, struct bus *bus, struct error *doubt, struct error *error) {
    c->bus = bus;
    *doubt = (struct error){0};
    int status = listen_to_bus(c, params->lcm.remote_stop, doubt, error);
    return status ? status : open_sockets(c, params->machine.name, doubt, error);
}

void commands_begin(struct commands *c, const struct params *params, struct loop *loop, void (*tell)(void *, const char *), void *context) {
    c->say = tell;
    c->context = context;
    operator_init(&c->operator, params, loop, &(struct operator_ports){.context = c, .answer = answer, .say = say});
}

void commands_polls(const struct commands *c, struct pollfd polls[COMMANDS_POLLS]) {
    command_server_polls(&c->server, polls);
    polls[COMMAND_POLLS] = (struct pollfd){.fd = c->listens ? bus_fd(c->bus) : -1, .events = POLLIN};
}

int commands_patience_ms(const struct commands *c) { return operator_waits(&c->operator) ? SOON_MS : IDLE_MS; }

/* Handles the LCM messages that have arrived, at most MESSAGES_AT_ONCE. Returns their number,
 * including those that are dropped. */
static int take_messages(struct commands *c) {
    struct bus_message m;
    enum command command;
    int came = 0;
    for (int got; came < MESSAGES_AT_ONCE && (got = bus_receive(c->bus, &m)) > 0; came++)
        if (got == 1 && !strcmp(m.channel, CHANNEL_COMMAND) && command_decode(m.data, m.size, &command))
            operator_take(&c->operator, 0, &(struct command_request){.command = command}, false, c->now_ns);
    return came;
}

/* SAFETY: reports that a socket's file was deleted or replaced. Without the file nobody can
 * connect, which the operator would otherwise notice only when a stop fails. The file is not made
 * again, because the confined daemon is not permitted to bind a socket. */
static void watch_files(struct commands *c) {
    enum command_socket missing = command_server_missing(&c->server);
    struct sockaddr_un address;
    char text[COMMAND_TEXT_SIZE];
    enum command_socket changed = missing == COMMAND_SOCKETS ? c->missing : missing;
    if (missing == c->missing) return;
    c->missing = missing;
    machine_address(&c->server.machine, changed == SOCKET_STOP, &address);
    if (missing == COMMAND_SOCKETS) snprintf(text, sizeof text, "%s is there again: commands arrive", address.sun_path);
    else if (missing == SOCKET_ALL)
        snprintf(text, sizeof text, "%s was deleted or replaced: engage, start and reset no longer arrive, stop and park do; restart hexid",
                 address.sun_path);
    else
        snprintf(text, sizeof text,
                 "%s was deleted or replaced: `hexid command` finds this hexid no longer, not even for a stop. What still stops it: the "
                 "emergency stop, SIGTERM (`kill %ld` parks)%s. Park it and restart hexid",
                 address.sun_path, (long)getpid(), c->listens ? ", stop and park over LCM" : "");
    say(c, text);
}

/* SAFETY: reports that connections cannot be accepted for lack of descriptors, because only the
 * daemon can report why a stop fails. Its limit of open files may have been lowered while it
 * ran. */
static void watch_room(struct commands *c) {
    char text[COMMAND_TEXT_SIZE];
    bool starved = command_server_starved(&c->server);
    if (starved == c->starved) return;
    c->starved = starved;
    snprintf(
        text, sizeof text,
        "no descriptor is free for `hexid command`, not even for a stop. What still stops this hexid: the emergency stop, SIGTERM (`kill "
        "%ld` parks)%s. Raise its limit: prlimit --pid %ld --nofile=128",
        (long)getpid(), c->listens ? ", stop and park over LCM" : "", (long)getpid());
    say(c, starved ? text : "`hexid command` is accepted again");
}

void commands_serve(struct commands *c, const struct pollfd polls[COMMANDS_POLLS], int64_t now_ns) {
    static const struct timespec rest = {.tv_nsec = REST_NS};
    c->now_ns = now_ns;
    int taken = command_server_serve(&c->server, polls);
    if (c->listens && polls[COMMAND_POLLS].revents) taken += take_messages(c);
    operator_tick(&c->operator, c->now_ns);
    if (now_ns >= c->look_ns) c->look_ns = now_ns + look_every_ns, watch_files(c), watch_room(c);
    if (taken < FLOOD) return;
    loop_attend(c->operator.loop, false);
    clock_nanosleep(CLOCK_MONOTONIC, 0, &rest, NULL);
    loop_attend(c->operator.loop, true);
}

void commands_end(struct commands *c) {
    struct command_answer last = {.outcome = OUTCOME_ENDED};
    if (c->operator.loop) last.state = loop_acted(c->operator.loop).state;
    command_server_end(&c->server, &last);
}
