#include "modbus_link.h"

#include <errno.h>
#include <limits.h>
#include <modbus/modbus.h>
#include <netdb.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

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
    bool bracketed = *rest == '[' && colon[-1] == ']'; /* [::1]:502 */
    if (bracketed && colon - rest <= 2) return misused(address, error);
    snprintf(p->name, sizeof p->name, "%.*s", (int)(colon - rest) - 2 * bracketed, rest + bracketed);
    snprintf(p->port, sizeof p->port, "%ld", port);
    return STATUS_OK;
}

/* What libmodbus 3.1.6 can set. Any other rate it takes without a word, and the
 * line runs at 9600. */
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

static modbus_t *context(struct modbus_link *link) { return (modbus_t *)link; }

/* "" when the host has an address. libmodbus calls a host without one a refused connection. */
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
    modbus_set_error_recovery(m, MODBUS_ERROR_RECOVERY_NONE); /* its recovery sleeps */
    modbus_set_response_timeout(m, 1, 0);                     /* to connect */
    if (modbus_set_slave(m, unit) || modbus_connect(m)) {
        int reason = errno;
        modbus_free(m);
        return modbus_line_refused(p, reason, error);
    }
    modbus_set_byte_timeout(m, 0, 0);
    *link = (struct modbus_link *)m;
    modbus_link_set_timeout(*link, timeout_s);
    return STATUS_OK;
}

void modbus_link_set_timeout(struct modbus_link *link, double timeout_s) {
    uint32_t whole_s = (uint32_t)timeout_s;
    modbus_set_response_timeout(context(link), whole_s, (uint32_t)((timeout_s - (double)whole_s) * 1e6));
}

void modbus_link_close(struct modbus_link *link) {
    if (!link) return;
    modbus_close(context(link));
    modbus_free(context(link));
}

/* What has come since the last answer is none to the next request. */
static modbus_t *cleared(struct modbus_link *link) {
    modbus_flush(context(link));
    return context(link);
}

int modbus_link_read(struct modbus_link *link, int address, int count, uint16_t *to) {
    return modbus_read_registers(cleared(link), address, count, to) == count ? 0 : -1;
}

int modbus_link_write(struct modbus_link *link, int address, int count, const uint16_t *from) {
    return modbus_write_registers(cleared(link), address, count, from) == count ? 0 : -1;
}

int modbus_link_exchange(struct modbus_link *link, int write_address, int writes, const uint16_t *from, int read_address, int reads,
                         uint16_t *to) {
    return modbus_write_and_read_registers(cleared(link), write_address, writes, from, read_address, reads, to) == reads ? 0 : -1;
}

bool modbus_link_gone(int error) { return error != ETIMEDOUT && error != EBADMSG && error < MODBUS_ENOBASE; }

bool modbus_link_busy(int error) { return error == EMBXSBUSY; }

bool modbus_link_value(int error) { return error == EMBXILVAL; }

const char *modbus_link_reason(int error) {
    if (modbus_link_busy(error)) return "another master commands this machine";
    if (error == EBUSY) return "another master tried to command this machine";
    return error == EBADMSG ? "an answer to another request" : modbus_strerror(error);
}
