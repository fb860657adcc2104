/* `hexid monitor`: shows a running hexid, received over LCM, in the terminal, as JSON, or as a page
 * for browsers. It sends nothing. */
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "bus.h"
#include "cli.h"
#include "json_text.h"
#include "live_server.h"
#include "messages.h"
#include "monotonic.h"
#include "params.h"
#include "poll_any.h"
#include "process.h"
#include "terminal.h"

enum { SILENCE_MS = 2000, ONCE_MS = 3000, MESSAGES_AT_ONCE = 1000 };

static volatile sig_atomic_t interrupted; /* global, because a signal handler has no other access */
static void on_signal(int number) { interrupted = number; }

static int broken(struct error *error) { return error_set(error, STATUS_IO, "monitor: LCM is broken"); }

/* ---- as JSON ---- */

/* Prints a message as a line, {"channel": "HEXID_EVENT", its fields}; ignores a message that is
 * unknown or malformed. */
static void print_json(const struct bus_message *b) {
    struct json_text j = {0};
    struct cycle c;
    struct message m;
    if (!strcmp(b->channel, CHANNEL_STATE) && state_decode(b->data, b->size, &c)) json_text_cycle(&j, &c);
    else if (message_known(b->channel) && message_read(b->channel, b->data, b->size, &m)) json_text_message(&j, &m);
    if (j.size && !j.failed) printf("{\"channel\":\"%s\",%.*s\n", b->channel, (int)j.size - 1, j.text + 1);
    fflush(stdout);
    json_text_free(&j);
}

/* ---- once ---- */

static int show_once(struct bus *bus, const struct params *params, bool json, struct error *error) {
    struct bus_message m;
    struct cycle c;
    for (int64_t end_ms = monotonic_ms() + ONCE_MS, left_ms = ONCE_MS; left_ms > 0; left_ms = end_ms - monotonic_ms()) {
        int got = bus_wait(bus, (int)left_ms);
        while (got > 0 && (got = bus_receive(bus, &m)) > 0) {
            if (got != 1 || strcmp(m.channel, CHANNEL_STATE) || !state_decode(m.data, m.size, &c)) continue;
            if (json) print_json(&m);
            else terminal_view(&(struct terminal){.params = params}, &c);
            return STATUS_OK;
        }
        if (got < 0) return broken(error);
    }
    return error_set(error, STATUS_IO,
                     "monitor: no hexid was heard on %s within %d s: is one running, with this lcm.url? "
                     "`hexid doctor` looks at LCM",
                     params->lcm.url, ONCE_MS / MS_PER_S);
}

/* ---- continuously ---- */

static int show_stream(struct bus *bus, const struct params *params, bool json, struct error *error) {
    struct terminal t = {.params = params, .redraws = isatty(STDOUT_FILENO) != 0};
    bool heard = false, told = false;
    for (;;) {
        struct bus_message m;
        int waited = bus_wait(bus, SILENCE_MS), got = waited;
        while (got > 0 && (got = bus_receive(bus, &m)) > 0) {
            if (got != 1) continue;
            heard = true, told = false;
            if (json) print_json(&m);
            else terminal_take(&t, &m, monotonic_ms());
        }
        if (got < 0) return broken(error);
        if (waited || told) continue;
        char line[PARAMS_TEXT_SIZE + 80];
        snprintf(line, sizeof line, "nothing %s: waiting for a hexid on %s", heard ? "more" : "yet", params->lcm.url);
        terminal_say(&t, line);
        told = true;
    }
}

/* ---- as a page ---- */

static void say_where(const struct live_listener *l, const char *host) {
    printf("hexid: live page at %s\n", l->url);
    fflush(stdout);
    if (!l->loopback)
        cli_say(stderr, "hexid: warning: %s is no loopback address: whoever reaches it sees the machine (but moves nothing)", host);
}

/* SAFETY: serves the page until a signal comes. This single thread never waits for a browser, and
 * in each turn reads LCM before it serves browsers. */
static int serve(struct bus *bus, struct live_state *state, struct live_server *server, struct error *error) {
    struct pollfd ready[] = {{.fd = bus_fd(bus), .events = POLLIN}, {.fd = live_server_fd(server), .events = POLLIN}};
    struct bus_message m;
    while (!interrupted) {
        int got = 0;
        if (poll_any(ready, 2, live_server_patience_ms(server), NULL) < 0 && errno != EINTR)
            return error_set(error, STATUS_IO, "monitor: %s", strerror(errno));
        for (int n = 0; n < MESSAGES_AT_ONCE && (got = bus_receive(bus, &m)) > 0; n++) {
            if (got == 1) live_state_take(state, &m, monotonic_ms());
            else state->dropped++;
        }
        if (got < 0) return broken(error);
        live_server_turn(server, monotonic_ms());
    }
    return STATUS_OK;
}

static int show_page(struct bus *bus, const struct params *params, const char *where, struct error *error) {
    const struct sigaction action = {.sa_handler = on_signal};
    struct live_address address;
    struct live_listener listener;
    struct live_server *server = NULL;
    struct live_state *state = calloc(1, sizeof *state);
    int status = state ? live_address_parse(where, &address, error) : error_set(error, STATUS_IO, "out of memory");
    if (!status) status = live_state_init(state, params, error);
    if (!status) status = live_listen(&address, &listener, error);
    if (!status) status = live_server_start(&server, &listener, address.host, state, error);
    if (!status) {
        sigaction(SIGINT, &action, NULL);
        sigaction(SIGTERM, &action, NULL);
        process_survive_readers(); /* browsers may close connections at any time */
        say_where(&listener, address.host);
        status = serve(bus, state, server, error);
        live_server_stop(server);
    }
    if (state) live_state_free(state);
    free(state);
    return status;
}

int cmd_monitor(int argc, char **argv) {
    struct options o;
    struct params params;
    struct error error;
    struct bus *bus = NULL;
    int status = options_parse(&o, argc, argv, "cSh1J", 0, &error);
    if (!status && o.http && (o.once || o.json_lines))
        status = error_set(&error, STATUS_USAGE, "--http: a page has no --once and no --json");
    if (!status) status = options_bus(&o, &params, &bus, &error);
    if (!status) status = bus_listen(bus, "HEXID_", BUS_ANYONE, &error);
    if (!status) {
        if (o.http) status = show_page(bus, &params, o.http, &error);
        else if (o.once) status = show_once(bus, &params, o.json_lines, &error);
        else status = show_stream(bus, &params, o.json_lines, &error);
    }
    if (bus) bus_close(bus);
    return status ? cli_fail(&error) : EXIT_PASSED;
}
