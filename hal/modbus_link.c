#include "modbus_link.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <modbus/modbus.h>
#include <netdb.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "modbus_map.h"
#include "monotonic.h"
#include "poll_any.h"
#include "units.h"

static int misused(const char *address, struct error *error) {
    return error_set(error, STATUS_USAGE, "modbus:%.100s: write modbus:tcp://HOST:PORT or modbus:rtu:DEVICE?baud=N", address);
}

static bool number(const char *text, long low, long high, long *value) {
    char *end;
    errno = 0;
    *value = strtol(text, &end, 10);
    return !errno && *text >= '0' && *text <= '9' && !*end && *value >= low && *value <= high;
}

static int parse_tcp(const char *rest, const char *address, struct modbus_address_parts *p, struct error *error) {
    const char *colon = strrchr(rest, ':');
    long port;
    if (!colon || colon == rest || colon - rest >= MODBUS_NAME_SIZE || strlen(colon + 1) >= sizeof p->port) return misused(address, error);
    if (!number(colon + 1, 0, 65535, &port)) return misused(address, error);
    bool bracketed = *rest == '[' && colon[-1] == ']'; /* an IPv6 address with its port,
                                                        * [::1]:502 */
    if (bracketed && colon - rest <= 2) return misused(address, error);
    snprintf(p->name, sizeof p->name, "%.*s", (int)(colon - rest) - 2 * bracketed, rest + bracketed);
    snprintf(p->port, sizeof p->port, "%ld", port);
    return STATUS_OK;
}

/* Rates that libmodbus 3.1.6 can set. It accepts other rates, too, but silently runs the line at
 * 9600 baud. */
const int modbus_bauds[] = {1200,   2400,   4800,    9600,    19200,   38400,   57600,   115200,  230400,  460800, 500000,
                            576000, 921600, 1000000, 1152000, 1500000, 2500000, 3000000, 3500000, 4000000, 0};

static int check_baud(int baud, const char *address, struct error *error) {
    char list[200] = "";
    for (const int *b = modbus_bauds; *b; b++) {
        if (*b == baud) return STATUS_OK;
        snprintf(list + strlen(list), sizeof list - strlen(list), " %d", *b);
    }
    return error_set(error, STATUS_USAGE, "modbus:%.100s: libmodbus cannot set %d baud; possible are%s", address, baud, list);
}

static int parse_rtu(const char *rest, const char *address, struct modbus_address_parts *p, struct error *error) {
    const char *query = strstr(rest, "?baud=");
    long baud;
    bool named = query && query != rest && query - rest < MODBUS_NAME_SIZE;
    if (!named || !number(query + 6, 1, INT_MAX, &baud)) return misused(address, error);
    snprintf(p->name, sizeof p->name, "%.*s", (int)(query - rest), rest);
    p->baud = (int)baud;
    return check_baud(p->baud, address, error);
}

int modbus_parse(const char *address, struct modbus_address_parts *p, struct error *error) {
    *p = (struct modbus_address_parts){.serial = !strncmp(address, "rtu:", 4)};
    if (p->serial) return parse_rtu(address + 4, address, p, error);
    return strncmp(address, "tcp://", 6) ? misused(address, error) : parse_tcp(address + 6, address, p, error);
}

/* ANSWER_MIN: size of the shortest answer, an exception with its framing; fewer bytes are noise. */
enum { ANSWER_MIN = 5, ADU_SIZE = 260 };

struct modbus_link {
    modbus_t *modbus;
    bool serial;
    int64_t silence_ns, free_ns; /* serial only. silence_ns: silence kept before a request; free_ns:
                                  * time from which the next request may be sent */
    int64_t begun_ns;            /* time at which the last request began to be sent */
    bool answered;               /* the last request was answered */
    unsigned unasked;
};

static modbus_t *context(struct modbus_link *link) { return link->modbus; }

/* Returns the reason why the host has no address; "" if it has one. libmodbus itself would report a
 * refused connection. */
static const char *unknown_host(const struct modbus_address_parts *p) {
    struct addrinfo *found = NULL, wanted = {.ai_socktype = SOCK_STREAM};
    int reason = getaddrinfo(p->name, p->port, &wanted, &found);
    if (found) freeaddrinfo(found);
    return reason ? gai_strerror(reason) : "";
}

int modbus_line_refused(const struct modbus_address_parts *p, int reason, struct error *error) {
    if (p->serial)
        return error_set(error, STATUS_IO, "modbus:rtu:%s: cannot be opened: %s; %s", p->name, modbus_strerror(reason),
                         reason == EACCES   ? "join the group that owns it (`ls -l` says which, often dialout)"
                         : reason == EINVAL ? "this driver does not know the baud rate"
                                            : "name a serial device that is there");
    const char *unknown = unknown_host(p);
    if (*unknown)
        return error_set(error, STATUS_IO, "modbus:tcp://%s:%s: no such host: %s; give its number, or a name that `getent hosts` knows",
                         p->name, p->port, unknown);
    return error_set(error, STATUS_IO, "modbus:tcp://%s:%s: %s; %s", p->name, p->port, modbus_strerror(reason),
                     reason == EACCES          ? "ports below 1024 are for root: name a higher one"
                     : reason == EADDRINUSE    ? "name another port, or 0 for a free one"
                     : reason == EADDRNOTAVAIL ? "name an address of this machine"
                                               : "is the device on, and is this its address and port?");
}

int modbus_link_open(struct modbus_link **link, const struct modbus_address_parts *p, int unit, double timeout_s, struct error *error) {
    modbus_t *m = p->serial ? modbus_new_rtu(p->name, p->baud, 'N', 8, 1) : modbus_new_tcp_pi(p->name, p->port);
    if (!m) return error_set(error, STATUS_IO, "modbus: out of memory");
    modbus_set_error_recovery(m, MODBUS_ERROR_RECOVERY_NONE); /* libmodbus's own recovery would
                                                               * sleep */
    modbus_set_response_timeout(m, 1, 0);       /* limits libmodbus's wait for a connection to 1
                                                 * s */
    if (modbus_set_slave(m, unit) || modbus_connect(m)) {
        int reason = errno;
        modbus_free(m);
        return modbus_line_refused(p, reason, error);
    }
    modbus_set_byte_timeout(m, 0, 0);
    *link = calloc(1, sizeof **link);
    if (!*link) {
        modbus_close(m);
        modbus_free(m);
        return error_set(error, STATUS_IO, "modbus: out of memory");
    }
    (*link)->modbus = m;
    (*link)->serial = p->serial;
    if (p->serial) (*link)->silence_ns = ns_from_seconds(modbus_silence_s(p->baud));
    (*link)->free_ns = monotonic_ns() + (*link)->silence_ns;
    modbus_link_set_timeout(*link, timeout_s);
    return STATUS_OK;
}

unsigned modbus_link_unasked(const struct modbus_link *link) { return link->unasked; }

void modbus_link_not_answered(struct modbus_link *link) { link->answered = false; }

void modbus_link_set_timeout(struct modbus_link *link, double timeout_s) {
    uint32_t whole_s = (uint32_t)timeout_s;
    modbus_set_response_timeout(context(link), whole_s, (uint32_t)((timeout_s - (double)whole_s) * 1e6));
}

void modbus_link_close(struct modbus_link *link) {
    if (!link) return;
    modbus_close(context(link));
    modbus_free(context(link));
    free(link);
}

/* Discards received bytes and returns their number. The bytes are read one buffer at a time,
 * because tcflush() would also discard bytes that are still to be sent. */
static size_t drain(int fd) {
    enum { MOST = 4096 }; /* bytes; a limit is needed because a device may never stop sending */
    uint8_t rest[ADU_SIZE];
    size_t count = 0;
    for (struct pollfd p = {.fd = fd, .events = POLLIN}; count < MOST && poll_any(&p, 1, 0, NULL) > 0 && p.revents & POLLIN;) {
        ssize_t got = read(fd, rest, sizeof rest);
        if (got <= 0) break;
        count += (size_t)got;
    }
    return count;
}

/* Waits until a serial line is silent, in at most three tries; does not wait on TCP. Discards
 * received bytes and returns their number. */
static size_t await_silence(struct modbus_link *link) {
    enum { TRIES = 3 };
    size_t count = 0;
    for (int i = 0; i < TRIES; i++) {
        const struct timespec until = {.tv_sec = link->free_ns / NS_PER_S, .tv_nsec = link->free_ns % NS_PER_S};
        if (link->serial) clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
        size_t got = drain(modbus_get_socket(context(link)));
        count += got;
        if (!got || !link->serial) break;
        link->free_ns = monotonic_ns() + link->silence_ns;
    }
    return count;
}

/* Discards bytes received since the last request: they cannot answer the next one. SAFETY: if the
 * last request was already answered, these bytes are the answer of a second device. */
static modbus_t *cleared(struct modbus_link *link) {
    link->unasked += await_silence(link) >= ANSWER_MIN && link->answered;
    link->begun_ns = monotonic_ns();
    return context(link);
}

int64_t modbus_link_begun_ns(const struct modbus_link *link) { return link->begun_ns; }

/* Records whether a request was answered; an exception is an answer, too. */
static int ended(struct modbus_link *link, bool good) {
    int reason = errno;
    link->answered = good || (reason >= EMBXILFUN && reason <= EMBXGTAR);
    link->free_ns = monotonic_ns() + link->silence_ns;
    errno = reason;
    return good ? 0 : -1;
}

int modbus_link_read(struct modbus_link *link, int address, int count, uint16_t *to) {
    return ended(link, modbus_read_registers(cleared(link), address, count, to) == count);
}

/* Tests whether the device answers a request that follows an answer after the shorter silence. Each
 * of two tries sends one request after the usual silence, and another after the shorter silence.
 * Returns false, with the usual silence restored, if in both tries the first request was answered
 * and the second timed out; otherwise true, with the shorter silence. */
static bool shorten_silence(struct modbus_link *link, double silence_s) {
    const int64_t before_ns = link->silence_ns, shorter_ns = ns_from_seconds(silence_s);
    uint16_t who[2];
    for (int tries = 0; tries < 2; tries++) {
        link->silence_ns = shorter_ns; /* applies from the next answer on */
        if (modbus_link_read(link, MODBUS_IDENTITY, 2, who)) return true;
        if (!modbus_link_read(link, MODBUS_IDENTITY, 2, who) || errno != ETIMEDOUT) return true;
        link->silence_ns = before_ns;
        link->free_ns = monotonic_ns() + before_ns;
    }
    return false;
}

int modbus_link_keep_silence(struct modbus_link *link, const struct modbus_address_parts *parts, double period_s, struct error *error) {
    double recommended_s = modbus_silence_s(parts->baud), kept_s = modbus_kept_silence_s(parts->baud, period_s);
    if (!parts->serial || kept_s >= recommended_s || shorten_silence(link, kept_s)) return STATUS_OK;
    double strict_s = modbus_load(parts->baud).strict_cycle_s;
    return error_set(error, STATUS_USAGE,
                     "modbus:%.100s: this device misses a request that follows its answer by %.2g ms; with the %.3g ms that the standard "
                     "recommends a cycle takes %.1f ms: raise loop.period_s to %.3g or more (with sim.substeps where simulated)",
                     parts->name, kept_s * 1e3, recommended_s * 1e3, strict_s * 1e3, ceil(strict_s / 0.9 * 1e4) / 1e4);
}

int modbus_link_write(struct modbus_link *link, int address, int count, const uint16_t *from) {
    return ended(link, modbus_write_registers(cleared(link), address, count, from) == count);
}

int modbus_link_exchange(struct modbus_link *link, int write_address, int writes, const uint16_t *from, int read_address, int reads,
                         uint16_t *to) {
    return ended(link, modbus_write_and_read_registers(cleared(link), write_address, writes, from, read_address, reads, to) == reads);
}

/* True if the serial adapter receives what it sends: a request comes back byte for byte before the
 * answer. */
static bool echoes(struct modbus_link *link) {
    uint8_t sent[] = {0, 0x03, 0, 0, 0, 2}, heard[sizeof sent];
    size_t count = 0;
    /* lets a late answer to the previous request come, which cleared() then discards */
    nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
    sent[0] = (uint8_t)modbus_get_slave(context(link));
    if (!link->serial || modbus_send_raw_request(cleared(link), sent, sizeof sent) < 0) return false;
    for (struct pollfd p = {.fd = modbus_get_socket(context(link)), .events = POLLIN};
         count < sizeof heard && poll_any(&p, 1, 100, NULL) > 0;) {
        ssize_t got = read(p.fd, heard + count, sizeof heard - count);
        if (got <= 0) break;
        count += (size_t)got;
    }
    ended(link, false);
    return count == sizeof heard && !memcmp(heard, sent, sizeof heard);
}

static int refused_first(const char *name, int reason, bool echo, struct error *error) {
    bool exception = reason >= EMBXILFUN && reason <= EMBXGTAR;
    if (exception)
        return error_set(error, STATUS_IO, "modbus:%.100s: the first question was answered: %s", name, modbus_link_reason(reason));
    if (echo)
        return error_set(
            error, STATUS_IO,
            "modbus:%.100s: what is sent comes back: the adapter echoes; switch its echo off (RS485: let RE follow DE), or use "
            "another adapter",
            name);
    if (reason == ETIMEDOUT)
        return error_set(error, STATUS_IO,
                         "modbus:%.100s: no answer to the first question: %s; check unit (modbus.unit), baud rate and wiring", name,
                         modbus_link_reason(reason));
    return error_set(error, STATUS_IO, "modbus:%.100s: no good answer to the first question: %s; check baud rate, wiring and %s", name,
                     modbus_link_reason(reason), "whether two devices have that unit (modbus.unit)");
}

int modbus_link_greet(struct modbus_link *link, const char *name, uint16_t who[2], struct error *error) {
    if (!modbus_link_read(link, MODBUS_IDENTITY, 2, who)) return STATUS_OK;
    int reason = errno;
    bool echo = link->serial && reason >= MODBUS_ENOBASE && echoes(link);
    if (link->serial && !echo && !modbus_link_gone(reason)) {
        if (!modbus_link_read(link, MODBUS_IDENTITY, 2, who)) return STATUS_OK;
        reason = errno;
    }
    return refused_first(name, reason, echo, error);
}

bool modbus_link_gone(int error) { return error != ETIMEDOUT && error != EBADMSG && error < MODBUS_ENOBASE; }

bool modbus_link_lost(int error) { return error == ETIMEDOUT || error == EBADMSG || error == EMBBADCRC || error == EMBBADDATA; }

bool modbus_link_busy(int error) { return error == EMBXSBUSY; }

bool modbus_link_value(int error) { return error == EMBXILVAL; }

const char *modbus_link_reason(int error) {
    static const struct {
        int error;
        const char *text;
    } texts[] = {
        {EBUSY, "another master tried to command this machine"},
        {EBADMSG, "an answer to another request"},
        {ENOTUNIQ, "a second answer to one request: two devices have this unit's number"},
        {ETIMEDOUT, "no answer in time"},
        {EMBXILFUN, "exception 1, illegal function: another device, or another map than `hexid doctor --modbus-map` has"},
        {EMBXILADD, "exception 2, illegal address: no such registers there; another map than `hexid doctor --modbus-map` has, or one that "
                    "is counted from another number"},
        {EMBXILVAL, "exception 3, illegal value: the device does not take that value or quantity"},
        {EMBXSFAIL, "exception 4, device failure: the device itself has failed; look at its own diagnosis, switch it off and on"},
        {EMBXACK, "exception 5, acknowledge: the device takes longer; hexid needs one that answers at once"},
        {EMBXSBUSY, "another master commands this machine"},
        {EMBXNACK, "exception 7, negative acknowledge: the device refuses; look at its own diagnosis"},
        {EMBXMEMPAR, "exception 8, memory parity error: the device's memory has failed; replace it"},
        {MODBUS_ENOBASE + 9, "exception 9, which no standard defines: look into the device's manual"},
        {EMBXGPATH, "exception 10, gateway path: the gateway has no way to that unit; look at its settings and modbus.unit"},
        {EMBXGTAR, "exception 11, gateway target: nobody behind the gateway answers for that unit; look at the device, its wiring and "
                   "modbus.unit"},
        {EMBBADCRC, "a wrong checksum: noise, another baud rate or parity, or two that speak at once"},
        {EMBBADDATA, "an answer of a wrong length, or to another request"},
        {EMBBADEXC, "an exception code that no standard has: another device, or noise"},
        {EMBUNKEXC, "an exception code that no standard has: another device, or noise"},
        {EMBMDATA, "an answer with more data than was asked for: another device, or noise"},
        {EMBBADSLAVE, "an answer of another unit: two masters on one line, or a device with a wrong number (modbus.unit)"},
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        if (texts[i].error == error) return texts[i].text;
    return modbus_strerror(error);
}
