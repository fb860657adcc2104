#include "live_server.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "http_library.h"
#include "live_page.h"
#include "page.h"

enum { CONNECTIONS = 2 * LIVE_CLIENTS, STILL_S = 15, HEALTH_MS = 250, AT_ONCE = 64, RETRY_MS = 1000, TURN_MS = 50 };

/* The stream to one browser. `cycle` and `event` are the numbers of the last cycle and event sent
 * to it, and `version` has, for each place (live_state.h), the version that this browser was sent
 * last. */
struct client {
    struct live_server *server;
    struct MHD_Connection *connection; /* connection to the browser; NULL: this element of the array
                                        * is free */
    struct json_text piece; /* the chunk being sent, of which libmicrohttpd has taken the first
                             * `sent` bytes */
    size_t sent;
    bool greeted, waits;               /* greeted: the machine's description was sent; waits: the
                                        * connection is suspended until there is something new to
                                        * send */
    int64_t health_ms; /* time at which the last chunk, and with it the health, was composed */
    uint64_t cycle, event, version[LIVE_PLACES];
};

struct live_server {
    struct http_library http;
    struct MHD_Daemon *daemon;
    const struct live_state *state;
    const char *served;
    char own_name[LIVE_HOST_SIZE];
    char *style;                       /* the page's style, made by page_style() */
    size_t style_size;
    int64_t now_ms;
    struct client client[LIVE_CLIENTS];
};

/* ---- the stream ---- */

static void say_begin(struct json_text *to, const char *name) { json_text_say(to, "event: %s\ndata: ", name); }
static void say_end(struct json_text *to) { json_text_add(to, "\n\n", 2); }

static void say(struct json_text *to, const char *name, const struct json_text *what) {
    say_begin(to, name);
    if (what->size && !what->failed) json_text_add(to, what->text, what->size);
    else json_text_add(to, "null", 4);
    say_end(to);
}

/* Adds the entries of the ring after number `*told`, at most AT_ONCE, to `to` as an array, and sets
 * `*told` to the number of the last entry added. */
static void say_ring(struct json_text *to, const char *name, const struct json_text *ring, uint64_t size, uint64_t count, uint64_t *told) {
    uint64_t most = count - *told < AT_ONCE ? count : *told + AT_ONCE;
    if (*told == count) return;
    say_begin(to, name);
    for (uint64_t n = *told + 1; n <= most; n++) {
        const struct json_text *one = &ring[n % size];
        json_text_add(to, n == *told + 1 ? "[" : ",", 1);
        json_text_add(to, one->failed ? "null" : one->text, one->failed ? 4 : one->size);
    }
    json_text_add(to, "]", 1);
    say_end(to);
    *told = most;
}

/* If a browser is too far behind, moves `*told` past the entries that are no longer in the ring. */
static void catch_up(uint64_t *told, uint64_t count, uint64_t size) {
    if (count - *told >= size) *told = count - size + 1;
}

static bool has_news(const struct client *c) {
    const struct live_state *s = c->server->state;
    return !c->greeted || c->cycle != s->cycles || c->event != s->events || memcmp(c->version, s->version, sizeof c->version) != 0 ||
           c->server->now_ms - c->health_ms >= HEALTH_MS;
}

/* Composes the next chunk: every place that changed, and a bounded number of cycles and events. */
static void compose(struct client *c) {
    const struct live_state *s = c->server->state;
    struct json_text *to = &c->piece;
    to->size = c->sent = 0;
    if (!c->greeted) {
        json_text_say(to, "retry: %d\n", RETRY_MS);
        say(to, "machine", &s->machine);
    }
    say_begin(to, "health");
    live_state_health(s, c->server->now_ms, to);
    say_end(to);
    for (int i = 0; i < LIVE_PLACES; i++)
        if (c->version[i] != s->version[i]) say(to, live_place_names[i], &s->place[i]);
    catch_up(&c->event, s->events, LIVE_EVENTS);
    catch_up(&c->cycle, s->cycles, LIVE_CYCLES);
    say_ring(to, "events", s->event, LIVE_EVENTS, s->events, &c->event);
    say_ring(to, "cycles", s->cycle, LIVE_CYCLES, s->cycles, &c->cycle);
    memcpy(c->version, s->version, sizeof c->version);
    c->health_ms = c->server->now_ms;
    c->greeted = true;
}

/* Copies the next bytes to libmicrohttpd, which calls this function whenever it can send more. */
static ssize_t give(void *context, uint64_t position, char *buffer, size_t room) {
    struct client *c = context;
    (void)position;
    if (c->sent == c->piece.size && has_news(c)) compose(c);
    if (c->piece.failed) return MHD_CONTENT_READER_END_WITH_ERROR;
    size_t left = c->piece.size - c->sent, size = left < room ? left : room;
    if (!size) {
        c->waits = true;
        c->server->http.suspend(c->connection);
        return 0;
    }
    memcpy(buffer, c->piece.text + c->sent, size);
    c->sent += size;
    return (ssize_t)size;
}

static void leave(void *context) {
    struct client *c = context;
    json_text_free(&c->piece);
    *c = (struct client){0};
}

/* ---- requests ---- */

/* With these headers the page loads nothing from other hosts, cannot be framed by another page, and
 * is not cached. */
static const char *const headers[][2] = {
    {"Content-Security-Policy", "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
                                "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cache-Control", "no-store"},
};

/* Sends a response and frees it. If the response is NULL, because memory ran out, the connection
 * ends. */
static enum MHD_Result send_response(struct live_server *s, struct MHD_Connection *to, unsigned status, struct MHD_Response *r,
                                     const char *type) {
    if (!r) return MHD_NO;
    enum MHD_Result good = s->http.add_header(r, MHD_HTTP_HEADER_CONTENT_TYPE, type);
    for (size_t i = 0; good && i < sizeof headers / sizeof *headers; i++) good = s->http.add_header(r, headers[i][0], headers[i][1]);
    if (good && status == MHD_HTTP_METHOD_NOT_ALLOWED) good = s->http.add_header(r, MHD_HTTP_HEADER_ALLOW, "GET, HEAD");
    if (good) good = s->http.answer(to, status, r);
    s->http.destroy(r);
    return good;
}

static enum MHD_Result send_bytes(struct live_server *s, struct MHD_Connection *to, unsigned status, const void *data, size_t size,
                                  const char *type) {
    return send_response(s, to, status, s->http.response(size, (void *)(uintptr_t)data, MHD_RESPMEM_PERSISTENT), type);
}

static enum MHD_Result send_words(struct live_server *s, struct MHD_Connection *to, unsigned status, const char *words) {
    return send_bytes(s, to, status, words, strlen(words), "text/plain; charset=utf-8");
}

/* Sends one of the page's files; page.css is the style that hexid's reports use too. */
static enum MHD_Result send_file(struct live_server *s, struct MHD_Connection *to, const char *name) {
    static const char *const types[][2] = {
        {".html", "text/html; charset=utf-8"}, {".css", "text/css"}, {".js", "text/javascript; charset=utf-8"}};
    const char *type = types[0][1], *end = strrchr(name, '.');
    for (size_t i = 0; end && i < sizeof types / sizeof *types; i++)
        if (!strcmp(end, types[i][0])) type = types[i][1];
    if (!strcmp(name, "page.css")) return send_bytes(s, to, MHD_HTTP_OK, s->style, s->style_size, type);
    for (const struct live_file *f = live_files; f->name; f++)
        if (!strcmp(name, f->name)) return send_bytes(s, to, MHD_HTTP_OK, f->data, f->size, type);
    return send_words(s, to, MHD_HTTP_NOT_FOUND, "no such page; the live page is /\n");
}

static enum MHD_Result send_stream(struct live_server *s, struct MHD_Connection *to) {
    enum { BLOCK = 16384 };
    struct client *c = s->client;
    while (c < s->client + LIVE_CLIENTS && c->connection) c++;
    if (c == s->client + LIVE_CLIENTS)
        return send_words(s, to, MHD_HTTP_SERVICE_UNAVAILABLE, "as many browsers as it serves watch already\n");
    *c = (struct client){.server = s, .connection = to};
    struct MHD_Response *r = s->http.response_of(MHD_SIZE_UNKNOWN, BLOCK, give, c, leave);
    if (!r) leave(c);
    return send_response(s, to, MHD_HTTP_OK, r, "text/event-stream");
}

static enum MHD_Result handle(void *context, struct MHD_Connection *from, const char *url, const char *method, const char *version,
                              const char *upload, size_t *upload_size, void **memory) {
    static const char page[] = "live.html";
    struct live_server *s = context;
    (void)version, (void)upload, (void)upload_size, (void)memory;
    if (strcmp(method, MHD_HTTP_METHOD_GET) != 0 && strcmp(method, MHD_HTTP_METHOD_HEAD) != 0)
        return send_words(s, from, MHD_HTTP_METHOD_NOT_ALLOWED, "this page is for reading only\n");
    if (!live_host_allowed(s->http.header(from, MHD_HEADER_KIND, MHD_HTTP_HEADER_HOST), s->served, s->own_name))
        return send_words(s, from, MHD_HTTP_FORBIDDEN, "not served under that name: use the address, or give the name to --http\n");
    if (!strcmp(url, "/events")) return send_stream(s, from);
    return send_file(s, from, !strcmp(url, "/") ? page : url + 1);
}

/* ---- the server ---- */

static bool write_style(struct live_server *s) {
    FILE *out = open_memstream(&s->style, &s->style_size);
    if (!out) return false;
    page_style(out);
    return !fclose(out);
}

int live_server_start(struct live_server **server, const struct live_listener *listener, const char *served, const struct live_state *state,
                      struct error *error) {
    struct live_server *s = calloc(1, sizeof *s);
    *server = NULL;
    if (!s || !write_style(s)) error_set(error, STATUS_IO, "out of memory");
    else if (!http_library_load(&s->http, error)) {
        s->state = state;
        s->served = served;
        gethostname(s->own_name, sizeof s->own_name - 1);
        s->daemon = s->http.start(MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME, 0, NULL, NULL, handle, s, MHD_OPTION_LISTEN_SOCKET,
                                  listener->fd, MHD_OPTION_CONNECTION_LIMIT, (unsigned)CONNECTIONS, MHD_OPTION_CONNECTION_TIMEOUT,
                                  (unsigned)STILL_S, MHD_OPTION_END);
        if (!s->daemon) error_set(error, STATUS_IO, "--http: libmicrohttpd does not start");
    }
    if (s && s->daemon) {
        *server = s;
        return STATUS_OK;
    }
    close(listener->fd);
    if (s) free(s->style);
    free(s);
    return error->status;
}

void live_server_stop(struct live_server *s) {
    for (int i = 0; i < LIVE_CLIENTS; i++)
        if (s->client[i].waits) s->http.resume(s->client[i].connection);
    s->http.stop(s->daemon);
    free(s->style);
    free(s);
}

int live_server_fd(const struct live_server *s) { return s->http.info(s->daemon, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd; }

int live_server_patience_ms(const struct live_server *s) {
    MHD_UNSIGNED_LONG_LONG due_ms;
    return s->http.timeout(s->daemon, &due_ms) == MHD_YES && due_ms < TURN_MS ? (int)due_ms : TURN_MS;
}

void live_server_turn(struct live_server *s, int64_t now_ms) {
    s->now_ms = now_ms;
    for (struct client *c = s->client; c < s->client + LIVE_CLIENTS; c++) {
        if (!c->waits || !has_news(c)) continue;
        c->waits = false;
        s->http.resume(c->connection);
    }
    s->http.run(s->daemon);
}
