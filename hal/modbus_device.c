/* The device side of Modbus, for `hexid plant`: one device with modbus_map.h's registers, for up to four TCP clients or one serial line.
 *
 * SAFETY: whatever arrives, a malformed request gets an exception or nothing; a peer that stops in the middle of one for
 * WHOLE_REQUEST_MS, or reads no answers, is cut off: by so much at most the watchdog is late. It is device_tick()'s: without a new
 * command for MODBUS_WATCHDOG_MS the valves are centred. */
#include <errno.h>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "backends.h"
#include "device.h"
#include "modbus_link.h"
#include "modbus_map.h"

enum { CLIENTS = 4, FUNCTION_23 = 0x17, WHOLE_REQUEST_MS = 20 };

struct modbus_device {
    const struct params *params;
    struct device *device;
    modbus_t *modbus;
    modbus_mapping_t *map;
    int listener, client[CLIENTS]; /* -1: none. A serial line is client[0] */
    bool serial, silent;
    uint16_t number;               /* of the last command */
};

/* Readings of this instant into the registers. */
static void latch(struct modbus_device *d, int64_t now_ns) {
    struct hal_sample s = {0};
    uint16_t *registers = d->map->tab_registers;
    bool fresh = device_latch(d->device, now_ns, &s);
    struct modbus_reading r = {.number = registers[MODBUS_COMMAND], .sample = (uint16_t)(registers[MODBUS_SAMPLE] + fresh),
                               .status = d->silent ? MODBUS_SILENT : 0};
    memcpy(r.length_m, s.length_m, sizeof r.length_m);
    memcpy(r.p1_pa, s.p1_pa, sizeof r.p1_pa);
    memcpy(r.p2_pa, s.p2_pa, sizeof r.p2_pa);
    modbus_put_reading(d->params, &r, registers + MODBUS_READ_FROM);
}

/* A command with a new number comes into force, and the machine lives through the period that begins. */
static void obey(struct modbus_device *d, int64_t now_ns) {
    const uint16_t *registers = d->map->tab_registers;
    double valve[LEGS];
    if (registers[MODBUS_COMMAND] == d->number) return;
    d->number = registers[MODBUS_COMMAND];
    modbus_get_command(d->params, registers + MODBUS_WRITE_FROM, valve);
    device_live(d->device, valve, now_ns);
}

/* What is for the device to say cannot be written. */
static void keep_own(struct modbus_device *d, const uint16_t before[MODBUS_END]) {
    uint16_t *registers = d->map->tab_registers;
    memcpy(registers + MODBUS_SAMPLE, before + MODBUS_SAMPLE, (MODBUS_END - MODBUS_SAMPLE) * sizeof *before);
    registers[MODBUS_IDENTITY] = MODBUS_IS_HEXID;
    registers[MODBUS_VERSION] = MODBUS_MAP_VERSION;
    if (registers[MODBUS_WATCHDOG_MS]) device_set_watchdog(d->device, registers[MODBUS_WATCHDOG_MS] * 1e-3);
}

/* One request. False: the client is gone or broken. */
static bool serve(struct modbus_device *d) {
    uint8_t request[MODBUS_MAX_ADU_LENGTH];
    uint16_t before[MODBUS_END];
    int size = modbus_receive(d->modbus, request);
    int64_t now_ns = device_now_ns();
    if (size == 0) return true; /* not for this unit */
    if (size < 0) {
        modbus_flush(d->modbus);
        return d->serial;
    }
    if (request[modbus_get_header_length(d->modbus)] == FUNCTION_23 || d->silent) latch(d, now_ns);
    memcpy(before, d->map->tab_registers, sizeof before);
    bool answered = modbus_reply(d->modbus, request, size, d->map) >= 0;
    keep_own(d, before);
    obey(d, now_ns);
    return answered || d->serial;
}

static void welcome(struct modbus_device *d) {
    /* SAFETY: not blocking, or a client that reads no answers would hold the watchdog. */
    int fd = accept4(d->listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    for (int i = 0; fd >= 0 && i < CLIENTS; i++)
        if (d->client[i] < 0) {
            d->client[i] = fd;
            return;
        }
    if (fd >= 0) close(fd);
}

/* False: the serial line is gone. */
static bool attend(struct modbus_device *d) {
    struct pollfd p[1 + CLIENTS] = {{.fd = d->listener, .events = POLLIN}};
    for (int i = 0; i < CLIENTS; i++) p[1 + i] = (struct pollfd){.fd = d->client[i], .events = POLLIN};
    if (poll(p, 1 + CLIENTS, 1) > 0) {
        for (int i = 0; i < CLIENTS; i++) {
            if (!p[1 + i].revents) continue;
            if (d->serial && !(p[1 + i].revents & POLLIN)) return false;
            modbus_set_socket(d->modbus, d->client[i]);
            if (serve(d)) continue;
            if (!d->serial) close(d->client[i]), d->client[i] = -1;
        }
        if (p[0].revents) welcome(d);
    }
    d->silent = device_tick(d->device, device_now_ns());
    return true;
}

static int listen_tcp(struct modbus_device *d, const struct modbus_address_parts *a, struct error *error) {
    struct sockaddr_storage bound;
    socklen_t size = sizeof bound;
    d->modbus = modbus_new_tcp_pi(a->name, a->port);
    if (!d->modbus) return error_set(error, STATUS_IO, "plant: out of memory");
    d->listener = modbus_tcp_pi_listen(d->modbus, CLIENTS);
    if (d->listener < 0 || getsockname(d->listener, (struct sockaddr *)&bound, &size))
        return modbus_line_refused(a, errno, error);
    int port = ntohs(bound.ss_family == AF_INET6 ? ((struct sockaddr_in6 *)&bound)->sin6_port : ((struct sockaddr_in *)&bound)->sin_port);
    printf("plant: ready on modbus:tcp://%s:%d\n", a->name, port);
    return STATUS_OK;
}

static int open_serial(struct modbus_device *d, const struct modbus_address_parts *a, struct error *error) {
    d->serial = true;
    d->modbus = modbus_new_rtu(a->name, a->baud, 'N', 8, 1);
    if (!d->modbus) return error_set(error, STATUS_IO, "plant: out of memory");
    if (modbus_connect(d->modbus)) return modbus_line_refused(a, errno, error);
    d->client[0] = modbus_get_socket(d->modbus);
    printf("plant: ready on modbus:rtu:%s\n", a->name);
    return STATUS_OK;
}

static int start(struct modbus_device *d, const char *address, struct error *error) {
    struct modbus_address_parts a;
    int status = modbus_parse(address, &a, error);
    if (!status) status = a.serial ? open_serial(d, &a, error) : listen_tcp(d, &a, error);
    if (status) return status;
    modbus_set_slave(d->modbus, d->params->modbus.unit);
    modbus_set_indication_timeout(d->modbus, 0, WHOLE_REQUEST_MS * 1000);
    modbus_set_byte_timeout(d->modbus, 0, 0); /* or each byte would start the time anew, and the watchdog would wait */
    modbus_set_response_timeout(d->modbus, 0, 1); /* libmodbus sleeps for it before it sends some exceptions */
    d->map = modbus_mapping_new(0, 0, MODBUS_END, 0);
    if (!d->map) return error_set(error, STATUS_IO, "plant: out of memory");
    keep_own(d, d->map->tab_registers);
    d->silent = true;
    latch(d, device_now_ns());
    fflush(stdout);
    return STATUS_OK;
}

static int modbus_serve(const char *address, const struct params *params, struct device *device, const _Atomic bool *stop,
                        struct error *error) {
    struct modbus_device d = {.params = params, .device = device, .listener = -1, .client = {-1, -1, -1, -1}};
    int status = start(&d, address, error);
    while (!status && !atomic_load_explicit(stop, memory_order_relaxed))
        if (!attend(&d)) status = error_set(error, STATUS_IO, "plant: modbus:%s: the line is gone; start again when it is back", address);
    for (int i = 0; i < CLIENTS && !d.serial; i++)
        if (d.client[i] >= 0) close(d.client[i]);
    if (d.listener >= 0) close(d.listener);
    if (d.serial && d.modbus) modbus_close(d.modbus);
    if (d.map) modbus_mapping_free(d.map);
    if (d.modbus) modbus_free(d.modbus);
    return status;
}

const struct device_bus device_modbus = {
    .scheme = "modbus",
    .usage = "modbus:tcp://HOST:PORT     one Modbus device with all legs (port 0: a free one); or modbus:rtu:DEVICE?baud=N",
    .serve = modbus_serve,
};
