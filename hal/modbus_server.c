#include "modbus_server.h"

#include <math.h>
#include <string.h>

#include "params.h"
#include "units.h"

/* READ_MAX, WRITE_MAX, EXCHANGE_WRITE_MAX: largest numbers of registers in a request (Application
 * Protocol V1.1b3, 6.3, 6.12 and 6.17) */
enum { READ_MAX = 125, WRITE_MAX = 123, EXCHANGE_WRITE_MAX = 121 };

struct span {
    unsigned from, count;
};

static struct span get_span(const uint8_t *from) { return (struct span){adu_get_16(from), adu_get_16(from + 2)}; }

static bool within(struct span s, unsigned from, unsigned end) { return s.from >= from && s.from + s.count <= end; }

static bool has(struct span s, unsigned from, unsigned end) { return s.from <= from && s.from + s.count >= end; }

static bool touches(struct span s, unsigned from, unsigned end) { return s.from < end && s.from + s.count > from; }

static bool is_readable(struct span s) { return within(s, 0, MODBUS_END); }

/* True if the registers may be written. Writing half a token is refused. */
static bool is_writable(struct span s) {
    bool half = touches(s, MODBUS_TOKEN, MODBUS_VALVE) && !has(s, MODBUS_TOKEN, MODBUS_VALVE);
    return within(s, MODBUS_WATCHDOG_MS, MODBUS_COMMAND + 1) && !half;
}

static uint32_t get_token(struct span s, const uint8_t *values) {
    const uint8_t *token = values + 2 * (MODBUS_TOKEN - s.from);
    return (uint32_t)adu_get_16(token) << 16 | adu_get_16(token + 2);
}

static int64_t watchdog_ns(const struct modbus_server *s) { return s->registers[MODBUS_WATCHDOG_MS] * 1000 * NS_PER_US; }

static void set_watchdog(struct modbus_server *s, unsigned watchdog_ms) {
    s->registers[MODBUS_WATCHDOG_MS] = (uint16_t)watchdog_ms;
    device_set_watchdog(s->device, watchdog_ms * 1e-3);
}

static void latch(struct modbus_server *s, int64_t now_ns) {
    struct hal_sample sample = {0};
    uint16_t *registers = s->registers;
    bool fresh = device_latch(s->device, now_ns, &sample);
    bool owned = s->token && now_ns - s->heard_ns <= watchdog_ns(s);
    struct modbus_reading r = {.number = registers[MODBUS_COMMAND],
                               .sample = (uint16_t)(registers[MODBUS_SAMPLE] + fresh),
                               .status = (uint16_t)((s->silent ? MODBUS_SILENT : 0u) | (owned ? MODBUS_OWNED : 0u)),
                               .foreign = registers[MODBUS_FOREIGN],
                               .inputs = (uint16_t)sample.inputs};
    memcpy(r.length_m, sample.length_m, sizeof r.length_m);
    memcpy(r.p1_pa, sample.p1_pa, sizeof r.p1_pa);
    memcpy(r.p2_pa, sample.p2_pa, sizeof r.p2_pa);
    modbus_put_reading(s->params, &r, registers + MODBUS_READ_FROM);
}

/* Applies a command if its number is new, and simulates the next period. */
static void obey(struct modbus_server *s, int64_t now_ns) {
    struct hal_command command = {.enable = true};
    if (s->registers[MODBUS_COMMAND] == s->number) return;
    s->number = s->registers[MODBUS_COMMAND];
    modbus_get_command(s->params, s->registers + MODBUS_WRITE_FROM, &command);
    device_live(s->device, &command, now_ns);
}

/* SAFETY: the new owner inherits neither the commands nor the watchdog of the previous one. */
static void hand_over(struct modbus_server *s, uint32_t token) {
    static const double centre[LEGS] = {0};
    s->token = token;
    memset(s->registers + MODBUS_VALVE, 0, LEGS * sizeof *s->registers);
    device_valves(s->device, centre);
    set_watchdog(s, s->registers[MODBUS_WATCHDOG_MAX_MS]);
}

static bool is_claim(struct span span) { return within(span, MODBUS_WATCHDOG_MS, MODBUS_VALVE) && has(span, MODBUS_TOKEN, MODBUS_VALVE); }

/* SAFETY: a watchdog is never longer than the device's own (MODBUS_WATCHDOG_MAX_MS). It may be
 * lengthened only by a new owner, or while it keeps the valves centred. */
static bool is_good_watchdog(const struct modbus_server *s, bool handed_over, unsigned watchdog_ms) {
    unsigned now_ms = s->registers[handed_over || s->silent ? MODBUS_WATCHDOG_MAX_MS : MODBUS_WATCHDOG_MS];
    return watchdog_ms >= MODBUS_WATCHDOG_MIN_MS && watchdog_ms <= now_ms;
}

static enum modbus_exception claim(struct modbus_server *s, const struct modbus_peer *from, struct span span, const uint8_t *values,
                                   int64_t now_ns) {
    uint32_t token = get_token(span, values);
    bool another = token != s->token, held = s->token && now_ns - s->heard_ns <= watchdog_ns(s);
    if (token == 0) return EXCEPTION_VALUE;
    if (another && held) return EXCEPTION_BUSY;
    bool sets_watchdog = span.from == MODBUS_WATCHDOG_MS;
    if (sets_watchdog && !is_good_watchdog(s, another, adu_get_16(values))) return EXCEPTION_VALUE;
    if (another) hand_over(s, token);
    if (sets_watchdog) set_watchdog(s, adu_get_16(values));
    s->connection = from->connection;
    s->heard_ns = now_ns;
    s->registers[MODBUS_OWNER] = (uint16_t)(from->ipv4 >> 16), s->registers[MODBUS_OWNER + 1] = (uint16_t)from->ipv4;
    return EXCEPTION_NONE;
}

/* True if the client owns the machine: its connection is the one that made the claim, and the
 * token, if the write contains one, is the owner's. On a serial line, which has no connections,
 * every write must contain the token. */
static bool owns(const struct modbus_server *s, const struct modbus_peer *from, struct span span, const uint8_t *values) {
    bool tells = has(span, MODBUS_TOKEN, MODBUS_VALVE);
    if (!s->token || from->connection != s->connection) return false;
    return tells ? get_token(span, values) == s->token : from->connection != 0;
}

static enum modbus_exception write_registers(struct modbus_server *s, const struct modbus_peer *from, struct span span,
                                             const uint8_t *values, int64_t now_ns) {
    if (!is_writable(span)) return EXCEPTION_ADDRESS;
    if (is_claim(span)) return claim(s, from, span, values, now_ns);
    if (!owns(s, from, span, values)) {
        s->registers[MODBUS_FOREIGN]++;
        return EXCEPTION_BUSY;
    }
    bool sets_watchdog = span.from == MODBUS_WATCHDOG_MS;
    if (sets_watchdog && !is_good_watchdog(s, false, adu_get_16(values))) return EXCEPTION_VALUE;
    if (sets_watchdog) set_watchdog(s, adu_get_16(values));
    for (unsigned i = 0; i < span.count; i++)
        if (span.from + i >= MODBUS_VALVE) s->registers[span.from + i] = (uint16_t)adu_get_16(values + 2 * i);
    s->heard_ns = now_ns;
    obey(s, now_ns);
    return EXCEPTION_NONE;
}

static size_t put_registers(const struct modbus_server *s, struct span span, uint8_t answer[ADU_PDU_MAX]) {
    answer[1] = (uint8_t)(2 * span.count);
    for (unsigned i = 0; i < span.count; i++) adu_put_16(answer + 2 + 2 * i, s->registers[span.from + i]);
    return 2 + 2 * span.count;
}

static enum modbus_exception read_few(struct modbus_server *s, const uint8_t *request, int64_t now_ns, uint8_t *answer, size_t *size) {
    struct span read = get_span(request + 1);
    if (read.count < 1 || read.count > READ_MAX) return EXCEPTION_VALUE;
    if (!is_readable(read)) return EXCEPTION_ADDRESS;
    if (s->silent) latch(s, now_ns);
    *size = put_registers(s, read, answer);
    return EXCEPTION_NONE;
}

static enum modbus_exception write_one(struct modbus_server *s, const struct modbus_peer *from, const uint8_t *request, int64_t now_ns,
                                       uint8_t *answer, size_t *size) {
    memcpy(answer, request, *size = 5);
    return write_registers(s, from, (struct span){adu_get_16(request + 1), 1}, request + 3, now_ns);
}

static enum modbus_exception write_few(struct modbus_server *s, const struct modbus_peer *from, const uint8_t *request, int64_t now_ns,
                                       uint8_t *answer, size_t *size) {
    struct span write = get_span(request + 1);
    if (write.count < 1 || write.count > WRITE_MAX || request[5] != 2 * write.count) return EXCEPTION_VALUE;
    memcpy(answer, request, *size = 5);
    return write_registers(s, from, write, request + 6, now_ns);
}

/* Function 23: writes, then reads. If the owner writes, the readings are latched first, before the
 * command simulates the next period; the answer contains them and the command's number. */
static enum modbus_exception exchange(struct modbus_server *s, const struct modbus_peer *from, const uint8_t *request, int64_t now_ns,
                                      uint8_t *answer, size_t *size) {
    struct span read = get_span(request + 1), write = get_span(request + 5);
    bool counts = read.count >= 1 && read.count <= READ_MAX && write.count >= 1 && write.count <= EXCHANGE_WRITE_MAX;
    if (!counts || request[9] != 2 * write.count) return EXCEPTION_VALUE;
    if (!is_readable(read)) return EXCEPTION_ADDRESS;
    bool owner = is_writable(write) && owns(s, from, write, request + 10);
    if (owner) latch(s, now_ns);
    enum modbus_exception exception = write_registers(s, from, write, request + 10, now_ns);
    *size = put_registers(s, read, answer);
    return exception;
}

size_t modbus_server_refuse(uint8_t function, enum modbus_exception exception, uint8_t answer[ADU_PDU_MAX]) {
    answer[0] = function | FUNCTION_FAILED;
    answer[1] = (uint8_t)exception;
    return 2;
}

size_t modbus_server_answer(struct modbus_server *s, const struct modbus_peer *from, const uint8_t *request, size_t size, int64_t now_ns,
                            uint8_t answer[ADU_PDU_MAX]) {
    enum modbus_exception exception = EXCEPTION_FUNCTION;
    size_t answered = 0;
    (void)size;
    answer[0] = request[0];
    switch (request[0]) {
    case FUNCTION_READ: exception = read_few(s, request, now_ns, answer, &answered); break;
    case FUNCTION_WRITE_ONE: exception = write_one(s, from, request, now_ns, answer, &answered); break;
    case FUNCTION_WRITE: exception = write_few(s, from, request, now_ns, answer, &answered); break;
    case FUNCTION_EXCHANGE: exception = exchange(s, from, request, now_ns, answer, &answered); break;
    default: break;
    }
    return exception ? modbus_server_refuse(request[0], exception, answer) : answered;
}

bool modbus_server_owned_by(const struct modbus_server *s, uint64_t connection) { return s->token && s->connection == connection; }

void modbus_server_tick(struct modbus_server *s, int64_t now_ns) { s->silent = device_tick(s->device, now_ns); }

void modbus_server_init(struct modbus_server *s, const struct params *params, struct device *device, int64_t now_ns) {
    *s = (struct modbus_server){.params = params, .device = device, .silent = true};
    s->registers[MODBUS_IDENTITY] = MODBUS_IS_HEXID;
    s->registers[MODBUS_VERSION] = MODBUS_MAP_VERSION;
    s->registers[MODBUS_WATCHDOG_MAX_MS] = (uint16_t)lround(params->device.watchdog_s * 1e3);
    set_watchdog(s, s->registers[MODBUS_WATCHDOG_MAX_MS]);
    latch(s, now_ns);
}
