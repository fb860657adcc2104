#include "modbus_link.h"

#include <errno.h>
#include <fcntl.h>
#include <modbus/modbus.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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
    snprintf(p->name, sizeof p->name, "%.*s", (int)(colon - rest) - 2 * bracketed, rest + bracketed);
    snprintf(p->port, sizeof p->port, "%ld", port);
    return STATUS_OK;
}

static int parse_rtu(const char *rest, const char *address, struct modbus_address_parts *p, struct error *error) {
    const char *query = strstr(rest, "?baud=");
    long baud;
    if (!query || query == rest || query - rest >= MODBUS_NAME_SIZE || !number(query + 6, 1200, 4000000, &baud)) return misused(address, error);
    snprintf(p->name, sizeof p->name, "%.*s", (int)(query - rest), rest);
    p->baud = (int)baud;
    return STATUS_OK;
}

int modbus_parse(const char *address, struct modbus_address_parts *p, struct error *error) {
    *p = (struct modbus_address_parts){.serial = !strncmp(address, "rtu:", 4)};
    if (p->serial) return parse_rtu(address + 4, address, p, error);
    return strncmp(address, "tcp://", 6) ? misused(address, error) : parse_tcp(address + 6, address, p, error);
}

static modbus_t *context(struct modbus_link *link) { return (modbus_t *)link; }

static int refused(const struct modbus_address_parts *p, int reason, struct error *error) {
    if (p->serial)
        return error_set(error, STATUS_IO, "modbus:rtu:%s: cannot be opened: %s; %s", p->name, modbus_strerror(reason),
                         reason == EACCES  ? "join the group that owns it (`ls -l` says which, often dialout)"
                         : reason == EINVAL ? "this driver does not know the baud rate"
                                            : "name a serial device that is there");
    return error_set(error, STATUS_IO, "modbus:tcp://%s:%s: cannot connect: %s; is the device on, and is this its address and port?", p->name, p->port,
                     reason ? modbus_strerror(reason) : "no such host");
}

/* libmodbus prints nothing of its own, but takes no open error of a device that is none. */
static int check_device(const char *name) {
    int fd = open(name, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) return errno;
    bool terminal = isatty(fd);
    close(fd);
    return terminal ? 0 : ENOTTY;
}

int modbus_link_open(struct modbus_link **link, const struct modbus_address_parts *p, int unit, double timeout_s, struct error *error) {
    int reason = p->serial ? check_device(p->name) : 0;
    if (reason) return refused(p, reason, error);
    modbus_t *m = p->serial ? modbus_new_rtu(p->name, p->baud, 'N', 8, 1) : modbus_new_tcp_pi(p->name, p->port);
    if (!m) return error_set(error, STATUS_IO, "modbus: out of memory");
    modbus_set_error_recovery(m, MODBUS_ERROR_RECOVERY_NONE); /* its recovery sleeps */
    modbus_set_response_timeout(m, 1, 0);                     /* to connect */
    errno = 0;
    if (modbus_set_slave(m, unit) || modbus_connect(m)) {
        reason = errno;
        modbus_free(m);
        return refused(p, reason, error);
    }
    modbus_set_response_timeout(m, (uint32_t)timeout_s, (uint32_t)((timeout_s - (double)(uint32_t)timeout_s) * 1e6));
    modbus_set_byte_timeout(m, 0, 0);
    *link = (struct modbus_link *)m;
    return STATUS_OK;
}

void modbus_link_close(struct modbus_link *link) {
    if (!link) return;
    modbus_close(context(link));
    modbus_free(context(link));
}

static int outcome(struct modbus_link *link, bool good) {
    if (good) return 0;
    int reason = errno;
    modbus_flush(context(link)); /* a late or broken answer must not be taken for the next one's */
    errno = reason;
    return -1;
}

int modbus_link_read(struct modbus_link *link, int address, int count, uint16_t *to) {
    return outcome(link, modbus_read_registers(context(link), address, count, to) == count);
}

int modbus_link_write(struct modbus_link *link, int address, uint16_t value) {
    return outcome(link, modbus_write_registers(context(link), address, 1, &value) == 1);
}

int modbus_link_exchange(struct modbus_link *link, int write_address, int writes, const uint16_t *from, int read_address, int reads, uint16_t *to) {
    return outcome(link, modbus_write_and_read_registers(context(link), write_address, writes, from, read_address, reads, to) == reads);
}

bool modbus_link_gone(int error) { return error == ECONNRESET || error == EPIPE || error == EBADF || error == ENOTCONN || error == EIO || error == ECONNREFUSED; }

const char *modbus_link_reason(int error) { return modbus_strerror(error); }
