/* The device side of Modbus, for `hexid plant`: modbus_server.h on TCP or on a serial line.
 *
 * SAFETY: no client delays the master or the watchdog. The only wait is at the beginning of each
 * turn(), for at most a millisecond; incomplete requests stay in the buffer of their connection.
 * The owner is served at once; all others, and new connections, once a millisecond in rotation, for
 * at most OTHERS_A_TURN requests and WELCOMES_A_TURN connections. If all places are taken, the
 * connection that was idle for longest is closed, but never the owner's; this is the pool of
 * non-priority connections in Messaging on TCP/IP V1.0b, 4.2.1. So a new master has some
 * milliseconds to claim the machine, however many others connect. A client that does not read its
 * answers is disconnected. */
#include <errno.h>
#include <fcntl.h>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "backends.h"
#include "modbus_adu.h"
#include "modbus_link.h"
#include "modbus_server.h"
#include "monotonic.h"
#include "params.h"
#include "poll_any.h"
#include "units.h"

enum {
    CLIENTS = 64,
    BACKLOG = 64,
    REQUESTS_A_TURN = 4,       /* most requests of one client that are served in a turn */
    OTHERS_A_TURN = 32,        /* most requests of all clients but the owner that are served in a
                                * turn; they take a third of a millisecond */
    WELCOMES_A_TURN = 16,
    TURN_NS = NS_PER_S / 1000,
    TTY_LATENCY_NS = 4 * TURN_NS, /* added to modbus_silence_s(), because adapters (latency timer, 1
                                   * ms if set so) and schedulers cause gaps within a frame */
    EMPTY_READS_MAX = 8,       /* number of consecutive reads without bytes after which a line that
                                * still polls as readable counts as lost */
    REOPEN_NS = NS_PER_S,      /* interval between attempts to open a lost line */
    SEND_BUFFER = 4096,        /* size of a connection's send buffer, bytes; it is small, so that
                                * only few answers wait unread */
    UNIT_BROADCAST = 0,        /* unit of requests to all devices of a serial line */
};

struct client {
    int fd;                  /* socket or serial line; -1: this place is free */
    struct modbus_peer peer;
    int64_t active_ns;       /* time of the last answer (exceptions do not count) or, before the
                              * first answer, of the connection; on a serial line also of the last
                              * byte */
    size_t filled;
    uint8_t bytes[2 * ADU_MAX];
};

struct modbus_device {
    const struct params *params;
    struct modbus_server server;
    modbus_t *modbus;           /* libmodbus's context, which listens or has the serial line open */
    int listener;    /* listening socket; -1: the device is on a serial line, served as client[0] */
    struct client client[CLIENTS];
    struct modbus_address_parts address;
    int64_t silence_ns;          /* serial only: length of the silence that ends a request */
    int empty_reads;             /* serial: number of consecutive reads without bytes */
    uint8_t sent[ADU_MAX];       /* serial only: the last answer */
    size_t sent_size;
    int64_t reopen_ns;           /* serial: time of the next attempt to open a lost line */
    uint64_t connections;        /* number of connections so far */
    int64_t turn_ns;             /* time of the next turn of clients other than the owner */
    unsigned turns;              /* number of turns so far */
};

static bool is_serial(const struct modbus_device *d) { return d->listener < 0; }

static bool is_master(const struct modbus_device *d, const struct client *c) {
    return c->fd >= 0 && modbus_server_owned_by(&d->server, c->peer.connection);
}

static void drop(struct client *c) {
    close(c->fd);
    c->fd = -1;
}

/* True if the buffer begins with the device's own last answer, as an adapter that receives what it
 * sends returns it. Such an answer may look like a request. */
static bool is_echo(const struct modbus_device *d, const struct client *c) {
    return is_serial(d) && d->sent_size && c->filled >= d->sent_size && !memcmp(c->bytes, d->sent, d->sent_size);
}

static enum adu_result take(const struct modbus_device *d, const struct client *c, int64_t now_ns, struct adu *adu) {
    if (c->filled == 0) return ADU_MORE;
    if (is_echo(d, c)) {
        *adu = (struct adu){.used = d->sent_size};
        return ADU_DISCARD;
    }
    return is_serial(d) ? adu_take_rtu(c->bytes, c->filled, now_ns - c->active_ns >= d->silence_ns, adu)
                        : adu_take_tcp(c->bytes, c->filled, adu);
}

/* True if the request is for this device: its unit is modbus.unit; on TCP also 255 or 0; on a
 * serial line also the broadcast. On TCP other units are devices behind a gateway, which this
 * device is not. */
static bool is_meant(const struct modbus_device *d, uint8_t unit) {
    bool other = is_serial(d) ? unit != UNIT_BROADCAST : unit != ADU_UNIT_TCP && unit != 0;
    return unit == d->params->modbus.unit || !other;
}

static bool is_write(uint8_t function) { return function == FUNCTION_WRITE_ONE || function == FUNCTION_WRITE; }

/* Answers a request. Returns the size of the answer's PDU; 0: there is no answer. */
static size_t answer(struct modbus_device *d, struct client *c, const struct adu *adu, int64_t now_ns, uint8_t pdu[ADU_PDU_MAX]) {
    bool broadcast = is_serial(d) && adu->unit == UNIT_BROADCAST;
    if (!is_meant(d, adu->unit)) return is_serial(d) ? 0 : modbus_server_refuse(adu->pdu[0], EXCEPTION_TARGET, pdu);
    if (broadcast && !is_write(adu->pdu[0])) return 0;
    size_t size = modbus_server_answer(&d->server, &c->peer, adu->pdu, adu->pdu_size, now_ns, pdu);
    return broadcast ? 0 : size;
}

/* Answers a request without waiting. Returns false if a TCP connection does not take the whole
 * answer at once. SAFETY: waiting for a client that does not read would delay the watchdog. */
static bool reply(struct modbus_device *d, struct client *c, const struct adu *adu, int64_t now_ns) {
    uint8_t pdu[ADU_PDU_MAX], bytes[ADU_MAX];
    size_t pdu_size = answer(d, c, adu, now_ns, pdu);
    if (!pdu_size) return true;
    if (!(pdu[0] & FUNCTION_FAILED)) c->active_ns = now_ns;
    size_t size = (is_serial(d) ? adu_put_rtu : adu_put_tcp)(adu, pdu, pdu_size, bytes);
    /* the answer to function 6 equals its request, so a repeated request must not count as an
     * echo */
    d->sent_size = pdu[0] == FUNCTION_WRITE_ONE ? 0 : size;
    memcpy(d->sent, bytes, size);
    ssize_t sent = is_serial(d) ? write(c->fd, bytes, size) : send(c->fd, bytes, size, MSG_NOSIGNAL);
    return sent == (ssize_t)size || is_serial(d);
}

/* Receives as many bytes as there is room for. Returns false if the connection is lost. */
static bool receive(struct modbus_device *d, struct client *c, int64_t now_ns) {
    size_t room = sizeof c->bytes - c->filled;
    if (room == 0) return true;
    ssize_t got = read(c->fd, c->bytes + c->filled, room);
    if (got < 0) return errno == EAGAIN || errno == EINTR;
    if (got == 0) return is_serial(d) && ++d->empty_reads < EMPTY_READS_MAX;
    d->empty_reads = 0;
    c->filled += (size_t)got;
    if (is_serial(d)) c->active_ns = now_ns;
    return true;
}

/* Serves complete requests within the budget. Returns false if the connection must be closed. */
static bool serve(struct modbus_device *d, struct client *c, int *budget) {
    struct adu adu;
    for (int i = 0; i < REQUESTS_A_TURN && *budget > 0; i++, --*budget) {
        int64_t now_ns = monotonic_ns();
        enum adu_result result = take(d, c, now_ns, &adu);
        if (result == ADU_MORE) return true;
        if (result == ADU_BROKEN || (result == ADU_REQUEST && !reply(d, c, &adu, now_ns))) return false;
        c->filled -= adu.used;
        memmove(c->bytes, c->bytes + adu.used, c->filled);
    }
    return true;
}

/* Handles the events of a client and serves its requests. Returns false if the serial line is
 * lost. */
static bool attend(struct modbus_device *d, struct client *c, int events, int *budget) {
    /* SAFETY: after a hang-up a line always polls as readable, so reading on would take the
     * processor from all less urgent threads */
    if (is_serial(d) && events & (POLLERR | POLLHUP | POLLNVAL)) return false;
    if ((!events || receive(d, c, monotonic_ns())) && serve(d, c, budget)) return true;
    if (!is_serial(d)) drop(c);
    return !is_serial(d);
}

static uint32_t ipv4_of(const struct sockaddr_storage *a) {
    const struct sockaddr_in6 *six = (const struct sockaddr_in6 *)a;
    uint32_t address = 0;
    if (a->ss_family == AF_INET) address = ((const struct sockaddr_in *)a)->sin_addr.s_addr;
    else if (IN6_IS_ADDR_V4MAPPED(&six->sin6_addr)) memcpy(&address, six->sin6_addr.s6_addr + 12, sizeof address);
    return ntohl(address);
}

/* Returns a free place. If there is none, disconnects the client that was idle for longest, and
 * returns its place. */
static struct client *make_room(struct modbus_device *d) {
    struct client *idle = NULL;
    for (struct client *c = d->client; c < d->client + CLIENTS; c++) {
        if (c->fd < 0) return c;
        if (!is_master(d, c) && (!idle || c->active_ns < idle->active_ns)) idle = c;
    }
    drop(idle);
    return idle;
}

/* Accepts a connection. Returns false if no connection waits. */
static bool welcome(struct modbus_device *d) {
    struct sockaddr_storage from = {0};
    socklen_t size = sizeof from;
    int on = 1, buffer = SEND_BUFFER, fd = accept4(d->listener, (struct sockaddr *)&from, &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return false;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    struct client *c = make_room(d);
    c->fd = fd;
    c->peer = (struct modbus_peer){.connection = ++d->connections, .ipv4 = ipv4_of(&from)};
    c->active_ns = monotonic_ns();
    c->filled = 0;
    return true;
}

/* Descriptors and buffers that a turn waits for. */
struct wait {
    struct pollfd poll[CLIENTS + 1]; /* one for each client, then the listener */
    bool filled[CLIENTS];      /* this client's buffer still has complete requests from the previous
                                * turn */
};

/* Waits at most a millisecond for events of the owner or of the serial line; if `others` is set,
 * also for events of all other clients and for new connections. */
static void wait_for(const struct modbus_device *d, struct wait *w, bool others, int64_t now_ns) {
    struct adu adu;
    int timeout_ms = 1;
    for (int i = 0; i < CLIENTS; i++) {
        const struct client *c = &d->client[i];
        bool attended = c->fd >= 0 && (others || is_serial(d) || is_master(d, c));
        w->poll[i] = (struct pollfd){.fd = attended ? c->fd : -1, .events = POLLIN};
        w->filled[i] = attended && take(d, c, now_ns, &adu) != ADU_MORE;
        if (w->filled[i]) timeout_ms = 0;
    }
    w->poll[CLIENTS] = (struct pollfd){.fd = others ? d->listener : -1, .events = POLLIN};
    if (poll_any(w->poll, CLIENTS + 1, timeout_ms, NULL) >= 0) return;
    for (int i = 0; i <= CLIENTS; i++) w->poll[i].revents = 0;
}

/* Serves the owner (`masters`), or all others. Returns false if the serial line is lost. */
static bool attend_all(struct modbus_device *d, struct wait *w, bool masters, int budget) {
    for (unsigned n = 0; n < CLIENTS; n++) {
        unsigned i = (d->turns + n) % CLIENTS;
        bool due = w->poll[i].revents || w->filled[i];
        if (!due || is_master(d, &d->client[i]) != masters) continue;
        if (!attend(d, &d->client[i], w->poll[i].revents, &budget)) return false;
        w->poll[i].revents = 0, w->filled[i] = false;
    }
    return true;
}

/* Waits for requests once and serves them. Returns false if the serial line is lost. */
static bool turn(struct modbus_device *d) {
    struct wait w;
    int64_t now_ns = monotonic_ns();
    bool others = now_ns >= d->turn_ns;
    wait_for(d, &w, others, now_ns);
    bool alive = attend_all(d, &w, true, REQUESTS_A_TURN) && attend_all(d, &w, false, OTHERS_A_TURN);
    if (others) d->turn_ns = now_ns + TURN_NS, d->turns++;
    for (int i = 0; i < WELCOMES_A_TURN && w.poll[CLIENTS].revents; i++)
        if (!welcome(d)) break;
    modbus_server_tick(&d->server, monotonic_ns());
    return alive;
}

static int listen_tcp(struct modbus_device *d, const struct modbus_address_parts *a, struct error *error) {
    struct sockaddr_storage bound;
    socklen_t size = sizeof bound;
    d->modbus = modbus_new_tcp_pi(a->name, a->port);
    if (!d->modbus) return error_set(error, STATUS_IO, "plant: out of memory");
    d->listener = modbus_tcp_pi_listen(d->modbus, BACKLOG);
    bool bad = d->listener < 0 || getsockname(d->listener, (struct sockaddr *)&bound, &size);
    /* SAFETY: a blocking accept() would wait if a client had disconnected before it was
     * accepted. */
    if (bad || fcntl(d->listener, F_SETFL, O_NONBLOCK)) return modbus_line_refused(a, errno, error);
    int port = ntohs(bound.ss_family == AF_INET6 ? ((struct sockaddr_in6 *)&bound)->sin6_port : ((struct sockaddr_in *)&bound)->sin_port);
    printf("plant: ready on modbus:tcp://%s:%d\n", a->name, port);
    return STATUS_OK;
}

static int connect_serial(struct modbus_device *d) {
    if (modbus_connect(d->modbus)) return -1;
    d->client[0].fd = modbus_get_socket(d->modbus); /* libmodbus has opened the port non-blocking */
    d->client[0].filled = 0;
    d->empty_reads = 0;
    printf("plant: ready on modbus:rtu:%s\n", d->address.name);
    fflush(stdout);
    return 0;
}

static int open_serial(struct modbus_device *d, const struct modbus_address_parts *a, struct error *error) {
    d->modbus = modbus_new_rtu(a->name, a->baud, 'N', 8, 1);
    if (!d->modbus) return error_set(error, STATUS_IO, "plant: out of memory");
    d->silence_ns = ns_from_seconds(modbus_silence_s(a->baud)) + TTY_LATENCY_NS;
    return connect_serial(d) ? modbus_line_refused(a, errno, error) : STATUS_OK;
}

/* Closes the serial line after its adapter was unplugged. The simulation goes on, and the device's
 * watchdog centres the valves. */
static void lose_serial(struct modbus_device *d) {
    printf("plant: modbus:rtu:%s: the line is gone; it is opened again when it is back\n", d->address.name);
    fflush(stdout);
    modbus_close(d->modbus);
    d->client[0].fd = -1;
    d->reopen_ns = monotonic_ns() + REOPEN_NS;
}

static void reopen_serial(struct modbus_device *d) {
    if (d->client[0].fd >= 0 || monotonic_ns() < d->reopen_ns || !connect_serial(d)) return;
    d->reopen_ns = monotonic_ns() + REOPEN_NS;
}

static int start(struct modbus_device *d, const char *address, struct error *error) {
    const struct modbus_address_parts *a = &d->address;
    int status = modbus_parse(address, &d->address, error);
    if (!status) status = a->serial ? open_serial(d, a, error) : listen_tcp(d, a, error);
    fflush(stdout);
    return status;
}

static int modbus_serve(const char *address, const struct params *params, struct device *device, const _Atomic bool *stop,
                        struct error *error) {
    struct modbus_device d = {.params = params, .listener = -1};
    for (int i = 0; i < CLIENTS; i++) d.client[i].fd = -1;
    modbus_server_init(&d.server, params, device, monotonic_ns());
    int status = start(&d, address, error);
    while (!status && !atomic_load_explicit(stop, memory_order_relaxed))
        if (!turn(&d)) lose_serial(&d);
        else if (is_serial(&d)) reopen_serial(&d);
    for (int i = 0; i < CLIENTS && !is_serial(&d); i++)
        if (d.client[i].fd >= 0) drop(&d.client[i]);
    if (is_serial(&d) && d.client[0].fd >= 0) modbus_close(d.modbus);
    if (!is_serial(&d)) close(d.listener);
    if (d.modbus) modbus_free(d.modbus);
    return status;
}

const struct device_bus device_modbus = {
    .scheme = "modbus",
    .usage = "modbus:tcp://HOST:PORT     one Modbus device with all legs (port 0: a free one); or modbus:rtu:DEVICE?baud=N",
    .serve = modbus_serve,
};
