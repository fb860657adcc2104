/* libFuzzer. The bytes are first a Modbus device's answer, which goes through libmodbus and the
 * register map to a reading; its first two bytes, the transaction's number, are corrected, because
 * nearly all inputs would be refused for them. Then they are a client's stream of requests, on TCP
 * and on a serial line, which goes through the framing to the device's registers. */
#include <arpa/inet.h>
#include <assert.h>
#include <math.h>
#include <modbus/modbus.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "config.h"
#include "modbus_adu.h"
#include "modbus_link.h"
#include "modbus_map.h"
#include "modbus_server.h"
#include "params.h"

enum { TRANSACTION = 2 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* The device's answer to the next request. */
static struct {
    const uint8_t *data;
    size_t size;
    int device; /* the device's end of the connection */
} next;

/* Replaces the C library's send() under libmodbus: a request is answered as it is sent, with its
 * own number. */
ssize_t send(int fd, const void *request, size_t size, int flags) {
    (void)fd, (void)flags;
    if (write(next.device, request, TRANSACTION) != TRANSACTION) return -1;
    return write(next.device, next.data, next.size) == (ssize_t)next.size ? (ssize_t)size : -1;
}

/* Checks that a reading is plausible or NaN, whatever the registers contain. */
static void look(const struct params *p, const struct modbus_reading *r) {
    for (int i = 0; i < LEGS; i++) {
        assert(isnan(r->length_m[i]) || (r->length_m[i] >= p->length_channel.low[i] && r->length_m[i] <= p->length_channel.high[i]));
        assert(isnan(r->p1_pa[i]) || (r->p1_pa[i] >= p->p1_channel.low[i] && r->p1_pa[i] <= p->p1_channel.high[i]));
        assert(isnan(r->p2_pa[i]) || (r->p2_pa[i] >= p->p2_channel.low[i] && r->p2_pa[i] <= p->p2_channel.high[i]));
    }
}

/* Sends a request. Checks that an unclaimed client moves nothing, and that the watchdog stays
 * within its bounds. */
static void ask(struct modbus_server *s, const struct modbus_peer *from, const struct adu *a, int64_t now_ns, bool serial) {
    /* exact size, so that a sanitizer sees an overrun */
    uint8_t pdu[ADU_PDU_MAX], bytes[ADU_MAX], *exact = malloc(a->pdu_size);
    uint16_t before[MODBUS_END];
    memcpy(before, s->registers, sizeof before);
    memcpy(exact, a->pdu, a->pdu_size);
    bool master = modbus_server_owned_by(s, from->connection);
    size_t size = modbus_server_answer(s, from, exact, a->pdu_size, now_ns, pdu);
    free(exact);
    assert(size >= 2 && size <= ADU_PDU_MAX);
    assert((serial ? adu_put_rtu : adu_put_tcp)(a, pdu, size, bytes) <= ADU_MAX);
    assert(s->registers[MODBUS_WATCHDOG_MS] >= MODBUS_WATCHDOG_MIN_MS);
    assert(s->registers[MODBUS_WATCHDOG_MS] <= s->registers[MODBUS_WATCHDOG_MAX_MS]);
    if (!master) assert(s->registers[MODBUS_COMMAND] == before[MODBUS_COMMAND]);
    if (size == 2 && pdu[0] & FUNCTION_FAILED)
        assert(!memcmp(s->registers + MODBUS_WATCHDOG_MS, before + MODBUS_WATCHDOG_MS, 2 * (MODBUS_SAMPLE - MODBUS_WATCHDOG_MS)));
}

/* Sends the bytes in segments whose sizes are taken from the bytes themselves. */
static void stream(struct modbus_server *s, const uint8_t *data, size_t size, bool serial) {
    static const uint8_t claim[] = {FUNCTION_WRITE, 0, MODBUS_WATCHDOG_MS, 0, 3, 6, 0, 10, 0, 0, 0, 1};
    const struct modbus_peer peer[2] = {{.connection = !serial}, {.connection = serial ? 0 : 2}};
    uint8_t bytes[2 * ADU_MAX], answer[ADU_PDU_MAX];
    size_t filled = 0;
    int64_t now_ns = 1000000000;
    if (size && data[0] & 1) modbus_server_answer(s, &peer[0], claim, sizeof claim, now_ns, answer);
    for (size_t at = 0; at < size;) {
        size_t piece = 1 + data[at];
        if (piece > size - at) piece = size - at;
        if (piece > sizeof bytes - filled) piece = sizeof bytes - filled;
        memcpy(bytes + filled, data + at, piece);
        filled += piece, at += piece;
        struct adu a;
        enum adu_result result = ADU_DISCARD;
        while (filled && result != ADU_MORE) {
            result = serial ? adu_take_rtu(bytes, filled, filled % 2, &a) : adu_take_tcp(bytes, filled, &a);
            if (result == ADU_BROKEN) return;
            if (result == ADU_MORE) assert(filled < ADU_MAX);
            else {
                assert(a.used > 0 && a.used <= filled);
                if (result == ADU_REQUEST) ask(s, &peer[filled % 2], &a, now_ns += 1000000, serial);
                filled -= a.used;
                memmove(bytes, bytes + a.used, filled);
            }
        }
    }
}

/* Sends requests to a server whose machine all inputs share; its registers are reset each time. */
static void requests(struct params *params, const uint8_t *data, size_t size) {
    static struct device *device;
    struct error error;
    struct modbus_server server;
    params->sim.engine = ENGINE_CLOSED_FORM;
    if (!device) device = device_create(params, 1, &error);
    for (int serial = 0; serial <= 1; serial++) {
        modbus_server_init(&server, params, device, 1000000000);
        stream(&server, data, size, serial);
    }
}

/* Opens a connection to a device that is this process. */
static struct modbus_link *connected(int *device) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t length = sizeof address;
    struct modbus_address_parts parts = {.name = "127.0.0.1"};
    struct modbus_link *link = NULL;
    struct error error;
    int listener = socket(AF_INET, SOCK_STREAM, 0);
    if (listener < 0 || bind(listener, (struct sockaddr *)&address, sizeof address) || listen(listener, 1)) abort();
    if (getsockname(listener, (struct sockaddr *)&address, &length)) abort();
    snprintf(parts.port, sizeof parts.port, "%d", ntohs(address.sin_port));
    if (modbus_link_open(&link, &parts, 1, 1e-3, &error)) abort();
    *device = accept(listener, NULL, NULL);
    close(listener);
    return link;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct params params;
    static struct modbus_link *link;
    static const uint16_t written[MODBUS_WRITTEN] = {1};
    uint16_t read[MODBUS_READ];
    struct modbus_reading reading;
    if (!link) {
        config_default(&params);
        link = connected(&next.device);
    }
    requests(&params, data, size);
    if (size > MODBUS_TCP_MAX_ADU_LENGTH - TRANSACTION) return 0;
    next.data = data, next.size = size;
    if (!modbus_link_exchange(link, MODBUS_WRITE_FROM, MODBUS_WRITTEN, written, MODBUS_READ_FROM, MODBUS_READ, read)) {
        modbus_get_reading(&params, read, &reading);
        look(&params, &reading);
    }
    return 0;
}
