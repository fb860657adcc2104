/* The Modbus device without its line: one master, the watchdog, and the exceptions. Time is an
 * argument, so nothing sleeps. */
#include "support.h"

#include <string.h>

#include "modbus_server.h"
#include "units.h"

static const int64_t start_ns = 1000 * NS_PER_S, ms_ns = NS_PER_S / 1000;
static const struct modbus_peer first = {.connection = 1, .ipv4 = 0x0a000005}, second = {.connection = 2, .ipv4 = 0x0a000006}, line = {0};
enum { TOKEN = 0x12345678, OTHER_TOKEN = 0x0badcafe, OWN_WATCHDOG_MS = 20, FAILED = -1000 };

struct rig {
    struct params params;
    struct device *device;
    struct modbus_server server;
    int64_t now_ns;
    uint8_t answer[ADU_PDU_MAX];
    size_t size;
};

static void rig_init(struct rig *r) {
    struct error error;
    config_default(&r->params);
    r->params.sensors.enabled = false;
    r->params.sim.engine = ENGINE_CLOSED_FORM;
    r->params.device.watchdog_s = OWN_WATCHDOG_MS * 1e-3;
    r->device = device_create(&r->params, 1, &error);
    assert_non_null(r->device);
    r->now_ns = start_ns;
    modbus_server_init(&r->server, &r->params, r->device, r->now_ns);
}

static void rig_free(struct rig *r) { device_destroy(r->device); }

static void pass(struct rig *r, int ms) {
    for (int i = 0; i < ms; i++) modbus_server_tick(&r->server, r->now_ns += ms_ns);
}

static void put(uint8_t *to, unsigned value) { to[0] = (uint8_t)(value >> 8), to[1] = (uint8_t)value; }

/* Sends a request. Returns 0 or the negative exception. */
static int ask(struct rig *r, const struct modbus_peer *from, const uint8_t *request, size_t size) {
    memset(r->answer, 0xee, sizeof r->answer);
    r->size = modbus_server_answer(&r->server, from, request, size, r->now_ns, r->answer);
    assert_int_equal(r->answer[0] & 0x7f, request[0] & 0x7f);
    if (!(r->answer[0] & FUNCTION_FAILED)) return 0;
    assert_int_equal(r->size, 2);
    return -r->answer[1];
}

/* Returns the register's value, or FAILED plus the exception. */
static int read_one(struct rig *r, unsigned address) {
    uint8_t request[5] = {FUNCTION_READ};
    put(request + 1, address), put(request + 3, 1);
    int refused = ask(r, &line, request, sizeof request);
    return refused ? FAILED + refused : r->answer[2] << 8 | r->answer[3];
}

static int write_values(struct rig *r, const struct modbus_peer *from, unsigned address, unsigned count, const uint16_t *values) {
    uint8_t request[ADU_PDU_MAX] = {FUNCTION_WRITE};
    put(request + 1, address), put(request + 3, count);
    request[5] = (uint8_t)(2 * count);
    for (unsigned i = 0; i < count; i++) put(request + 6 + 2 * i, values[i]);
    return ask(r, from, request, 6 + 2 * count);
}

static int write_single(struct rig *r, const struct modbus_peer *from, unsigned address, uint16_t value) {
    uint8_t request[5] = {FUNCTION_WRITE_ONE};
    put(request + 1, address), put(request + 3, value);
    return ask(r, from, request, sizeof request);
}

static int claim(struct rig *r, const struct modbus_peer *from, uint32_t token, uint16_t watchdog_ms) {
    uint16_t claimed[MODBUS_CLAIMED];
    modbus_put_claim(watchdog_ms, token, claimed);
    return write_values(r, from, MODBUS_WATCHDOG_MS, MODBUS_CLAIMED, claimed);
}

/* Sends one cycle's request as the daemon does. */
static int command(struct rig *r, const struct modbus_peer *from, uint32_t token, uint16_t number, double opening) {
    const struct hal_command sent = {.valve = {opening, opening, opening, opening, opening, opening}, .supply = number % 2};
    uint16_t written[MODBUS_WRITTEN];
    uint8_t request[10 + 2 * MODBUS_WRITTEN] = {FUNCTION_EXCHANGE};
    modbus_put_command(&r->params, token, number, &sent, written);
    put(request + 1, MODBUS_READ_FROM), put(request + 3, MODBUS_READ);
    put(request + 5, MODBUS_WRITE_FROM), put(request + 7, MODBUS_WRITTEN);
    request[9] = 2 * MODBUS_WRITTEN;
    for (int i = 0; i < MODBUS_WRITTEN; i++) put(request + 10 + 2 * i, written[i]);
    return ask(r, from, request, sizeof request);
}

static struct modbus_reading reading(const struct rig *r) {
    uint16_t read[MODBUS_READ];
    struct modbus_reading out;
    assert_int_equal(r->size, 2 + 2 * MODBUS_READ);
    for (int i = 0; i < MODBUS_READ; i++) read[i] = (uint16_t)(r->answer[2 + 2 * i] << 8 | r->answer[3 + 2 * i]);
    modbus_get_reading(&r->params, read, &out);
    return out;
}

static double length_m(struct rig *r) {
    struct hal_sample s = {0};
    device_latch(r->device, r->now_ns, &s);
    return s.length_m[0];
}

static void nobody_commands_who_has_not_claimed(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    assert_int_equal(command(&r, &first, 0, 1, 1.0), -EXCEPTION_BUSY);
    assert_int_equal(command(&r, &first, TOKEN, 1, 1.0), -EXCEPTION_BUSY);
    assert_int_equal(command(&r, &line, 0, 1, 1.0), -EXCEPTION_BUSY);
    assert_int_equal(write_single(&r, &first, MODBUS_VALVE, 32767), -EXCEPTION_BUSY);
    assert_int_equal(write_single(&r, &first, MODBUS_WATCHDOG_MS, 5), -EXCEPTION_BUSY);
    assert_int_equal(read_one(&r, MODBUS_COMMAND), 0);
    assert_int_equal(read_one(&r, MODBUS_VALVE), 0);
    rig_free(&r);
}

static void who_claims_commands(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    double rest_m = length_m(&r);
    assert_int_equal(claim(&r, &first, TOKEN, OWN_WATCHDOG_MS), 0);
    for (uint16_t n = 1; n <= 100; n++, pass(&r, 2)) {
        assert_int_equal(command(&r, &first, TOKEN, n, 0.5), 0);
        assert_int_equal(reading(&r).number, n);
    }
    assert_true(length_m(&r) > rest_m + 0.01);
    assert_int_equal(reading(&r).foreign, 0);
    assert_int_equal(reading(&r).status, MODBUS_OWNED);
    assert_int_equal(read_one(&r, MODBUS_OWNER) << 16 | read_one(&r, MODBUS_OWNER + 1), 0x0a000005);
    rig_free(&r);
}

/* Covers every function, with and without the master's token. */
static void anybody_elses_write_moves_nothing_and_is_counted(void **unused) {
    (void)unused;
    struct rig r;
    uint16_t values[MODBUS_COMMAND + 1 - MODBUS_WATCHDOG_MS] = {5,     TOKEN >> 16, TOKEN & 0xffff, 32767, 32767,
                                                                32767, 32767,       32767,          32767, 77};
    rig_init(&r);
    claim(&r, &first, TOKEN, OWN_WATCHDOG_MS);
    assert_int_equal(command(&r, &first, TOKEN, 1, 0.0), 0);
    double before_m = length_m(&r);
    int counted = 0;
    assert_int_equal(command(&r, &second, OTHER_TOKEN, 2, 1.0), -EXCEPTION_BUSY), counted++;
    assert_int_equal(command(&r, &second, TOKEN, 2, 1.0), -EXCEPTION_BUSY), counted++;
    assert_int_equal(command(&r, &first, OTHER_TOKEN, 2, 1.0), -EXCEPTION_BUSY), counted++;
    for (unsigned from = MODBUS_WATCHDOG_MS; from <= MODBUS_COMMAND; from++) {
        if (from == MODBUS_TOKEN || from == MODBUS_TOKEN + 1) continue;
        assert_int_equal(write_single(&r, &second, from, 77), -EXCEPTION_BUSY), counted++;
    }
    assert_int_equal(write_values(&r, &second, MODBUS_WATCHDOG_MS, sizeof values / sizeof *values, values), -EXCEPTION_BUSY), counted++;
    assert_int_equal(command(&r, &line, TOKEN, 2, 1.0), -EXCEPTION_BUSY), counted++;
    assert_int_equal(read_one(&r, MODBUS_COMMAND), 1);
    assert_int_equal(read_one(&r, MODBUS_WATCHDOG_MS), OWN_WATCHDOG_MS);
    pass(&r, 2);
    assert_int_equal(command(&r, &first, TOKEN, 2, 0.0), 0);
    assert_int_equal(reading(&r).foreign, counted);
    assert_close(length_m(&r), before_m, 1e-4);
    rig_free(&r);
}

/* A second daemon asks for the machine, and the first one does not notice. */
static void a_claim_of_an_owned_machine_is_refused_without_a_trace(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, OWN_WATCHDOG_MS);
    for (uint16_t n = 1; n <= 50; n++, pass(&r, 2)) {
        assert_int_equal(claim(&r, &second, OTHER_TOKEN, 5), -EXCEPTION_BUSY);
        assert_int_equal(command(&r, &first, TOKEN, n, 0.1), 0);
        assert_int_equal(reading(&r).foreign, 0);
    }
    assert_int_equal(read_one(&r, MODBUS_WATCHDOG_MS), OWN_WATCHDOG_MS);
    assert_int_equal(read_one(&r, MODBUS_OWNER + 1), 5);
    rig_free(&r);
}

/* The time is exact to the millisecond. The former master then has no rights. */
static void a_master_silent_for_the_watchdogs_time_can_be_replaced(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, 10);
    command(&r, &first, TOKEN, 1, 1.0);
    pass(&r, 10);
    assert_int_equal(claim(&r, &second, OTHER_TOKEN, 10), -EXCEPTION_BUSY);
    pass(&r, 1);
    assert_int_equal(claim(&r, &second, OTHER_TOKEN, 10), 0);
    assert_int_equal(command(&r, &first, TOKEN, 2, 1.0), -EXCEPTION_BUSY);
    assert_int_equal(command(&r, &second, OTHER_TOKEN, 2, 0.0), 0);
    assert_int_equal(reading(&r).foreign, 1);
    rig_free(&r);
}

/* Nobody else has claimed the machine, so the master continues. */
static void a_master_that_was_silent_is_still_the_master(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, 10);
    command(&r, &first, TOKEN, 1, 1.0);
    pass(&r, 500);
    assert_int_equal(command(&r, &first, TOKEN, 2, 0.0), 0);
    /* the status at the time when the command came */
    assert_int_equal(reading(&r).status, MODBUS_SILENT);
    rig_free(&r);
}

static void who_only_reads_loses_the_machine(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, 10);
    for (int i = 0; i < 20; i++, pass(&r, 1)) read_one(&r, MODBUS_LENGTH);
    assert_int_equal(claim(&r, &second, OTHER_TOKEN, 10), 0);
    rig_free(&r);
}

/* The connection was lost and made again within the watchdog's time. The old connection, half open,
 * no longer belongs to the owner. */
static void the_same_token_takes_the_machine_over_to_a_new_connection(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, OWN_WATCHDOG_MS);
    command(&r, &first, TOKEN, 1, 0.5);
    assert_int_equal(claim(&r, &second, TOKEN, OWN_WATCHDOG_MS), 0);
    assert_int_equal(command(&r, &second, TOKEN, 2, 0.5), 0);
    assert_int_equal(command(&r, &first, TOKEN, 3, 0.5), -EXCEPTION_BUSY);
    assert_true(modbus_server_owned_by(&r.server, 2));
    assert_false(modbus_server_owned_by(&r.server, 1));
    rig_free(&r);
}

/* On a serial line all requests come from the same end, so the token in each write proves the
 * master. */
static void on_a_serial_line_the_token_is_the_proof(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    assert_int_equal(claim(&r, &line, TOKEN, OWN_WATCHDOG_MS), 0);
    assert_int_equal(command(&r, &line, TOKEN, 1, 0.0), 0);
    assert_int_equal(command(&r, &line, OTHER_TOKEN, 2, 1.0), -EXCEPTION_BUSY);
    assert_int_equal(write_single(&r, &line, MODBUS_COMMAND, 3), -EXCEPTION_BUSY);
    assert_int_equal(write_single(&r, &line, MODBUS_WATCHDOG_MS, 3), -EXCEPTION_BUSY);
    assert_int_equal(read_one(&r, MODBUS_FOREIGN), 3);
    rig_free(&r);
}

/* The former master's commands are dropped: the legs stay where they were. */
static void a_new_master_finds_the_valves_centred_and_the_devices_own_watchdog(void **unused) {
    (void)unused;
    struct rig r;
    uint16_t token[] = {1, 2};
    rig_init(&r);
    claim(&r, &first, TOKEN, 3);
    for (uint16_t n = 1; n < 100; n++, pass(&r, 2)) command(&r, &first, TOKEN, n, 1.0);
    assert_int_equal(read_one(&r, MODBUS_VALVE), 32767);
    pass(&r, 2);
    assert_int_equal(write_values(&r, &second, MODBUS_TOKEN, 2, token), 0);
    assert_int_equal(read_one(&r, MODBUS_VALVE), 0);
    assert_int_equal(read_one(&r, MODBUS_WATCHDOG_MS), OWN_WATCHDOG_MS);
    pass(&r, 100); /* the oscillation decays */
    double held_m = length_m(&r);
    pass(&r, 100);
    assert_close(length_m(&r), held_m, 1e-3);
    rig_free(&r);
}

/* The former owner was silent for the watchdog's time that it set last. By the time in force when
 * it was sent, its last command would act for longer, but it ends with the hand-over. */
static void a_hand_over_ends_a_command_that_still_holds(void **unused) {
    (void)unused;
    struct rig r;
    uint16_t token[] = {1, 2};
    rig_init(&r);
    claim(&r, &first, TOKEN, OWN_WATCHDOG_MS);
    for (uint16_t n = 1; n < 100; n++, pass(&r, 2)) command(&r, &first, TOKEN, n, 1.0);
    assert_int_equal(write_single(&r, &first, MODBUS_WATCHDOG_MS, 3), 0);
    pass(&r, 4);
    assert_int_equal(write_values(&r, &second, MODBUS_TOKEN, 2, token), 0);
    pass(&r, 6); /* the valve closes */
    double closed_m = length_m(&r);
    pass(&r, 6);
    double moved_m = length_m(&r) - closed_m;
    rig_free(&r);
    assert_below(moved_m, 1e-3);
}

static void a_token_of_nought_is_none_and_half_a_one_neither(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    assert_int_equal(claim(&r, &first, 0, 10), -EXCEPTION_VALUE);
    assert_int_equal(write_single(&r, &first, MODBUS_TOKEN, 1), -EXCEPTION_ADDRESS);
    assert_int_equal(write_single(&r, &first, MODBUS_TOKEN + 1, 1), -EXCEPTION_ADDRESS);
    assert_false(modbus_server_owned_by(&r.server, 1));
    assert_int_equal(read_one(&r, MODBUS_STATUS), MODBUS_SILENT);
    rig_free(&r);
}

static void nobody_can_read_the_token(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, 10);
    command(&r, &first, TOKEN, 1, 0.0);
    for (unsigned a = 0; a < MODBUS_END; a++) {
        int value = read_one(&r, a);
        assert_int_not_equal(value, TOKEN >> 16);
        assert_int_not_equal(value, TOKEN & 0xffff);
    }
    rig_free(&r);
}

/* SAFETY: all values are tried. */
static void a_watchdog_outside_its_bounds_is_refused(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    assert_int_equal(read_one(&r, MODBUS_WATCHDOG_MS), OWN_WATCHDOG_MS);
    assert_int_equal(read_one(&r, MODBUS_WATCHDOG_MAX_MS), OWN_WATCHDOG_MS);
    for (unsigned ms = 0; ms < 65536; ms++) {
        int expected = ms >= 2 && ms <= OWN_WATCHDOG_MS ? 0 : -EXCEPTION_VALUE;
        assert_int_equal(claim(&r, &first, TOKEN, (uint16_t)ms), expected);
        if (!expected) assert_int_equal(read_one(&r, MODBUS_WATCHDOG_MS), ms);
        if (ms >= 2) assert_int_equal(write_single(&r, &first, MODBUS_WATCHDOG_MS, (uint16_t)ms), expected);
    }
    rig_free(&r);
}

static void a_claim_with_a_bad_watchdog_claims_nothing(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    assert_int_equal(claim(&r, &first, TOKEN, 65535), -EXCEPTION_VALUE);
    assert_int_equal(command(&r, &first, TOKEN, 1, 1.0), -EXCEPTION_BUSY);
    assert_int_equal(read_one(&r, MODBUS_WATCHDOG_MS), OWN_WATCHDOG_MS);
    rig_free(&r);
}

/* While the valves are driven the watchdog can only become shorter; a claim by the same master does
 * not circumvent this. */
static void a_watchdog_becomes_longer_only_while_the_valves_are_centred(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, 10);
    command(&r, &first, TOKEN, 1, 0.5);
    modbus_server_tick(&r.server, r.now_ns);
    assert_int_equal(write_single(&r, &first, MODBUS_WATCHDOG_MS, 11), -EXCEPTION_VALUE);
    assert_int_equal(claim(&r, &first, TOKEN, 11), -EXCEPTION_VALUE);
    assert_int_equal(write_single(&r, &first, MODBUS_WATCHDOG_MS, 8), 0);
    assert_int_equal(claim(&r, &first, TOKEN, 7), 0);
    assert_int_equal(read_one(&r, MODBUS_WATCHDOG_MS), 7);
    pass(&r, 11);
    assert_true(r.server.silent);
    assert_int_equal(claim(&r, &first, TOKEN, OWN_WATCHDOG_MS), 0);
    rig_free(&r);
}

static void the_watchdog_that_was_set_is_the_one_that_acts(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, 5);
    command(&r, &first, TOKEN, 1, 1.0);
    pass(&r, 5);
    assert_false(r.server.silent);
    pass(&r, 1);
    assert_true(r.server.silent);
    rig_free(&r);
}

static void what_is_the_devices_to_say_cannot_be_written(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, 10);
    for (unsigned a = 0; a <= MODBUS_END; a++)
        if (a < MODBUS_WATCHDOG_MS || a > MODBUS_COMMAND) assert_int_equal(write_single(&r, &first, a, 7), -EXCEPTION_ADDRESS);
    assert_int_equal(read_one(&r, MODBUS_FOREIGN), 0); /* moves nothing anyway */
    rig_free(&r);
}

/* Reads every span of two registers and every address; exactly the missing ones give exception
 * 2. */
static void registers_that_are_not_there_are_an_exception(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    for (unsigned a = 0; a < 65536; a++) {
        uint8_t request[5] = {FUNCTION_READ};
        put(request + 1, a), put(request + 3, 2);
        assert_int_equal(ask(&r, &first, request, sizeof request), a + 2 <= MODBUS_END ? 0 : -EXCEPTION_ADDRESS);
    }
    rig_free(&r);
}

static void quantities_and_byte_counts_are_checked(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    claim(&r, &first, TOKEN, 10);
    for (unsigned count = 0; count < 65536; count++) {
        uint8_t request[5] = {FUNCTION_READ};
        put(request + 3, count);
        int expected = count == 0 || count > 125 ? -EXCEPTION_VALUE : count > MODBUS_END ? -EXCEPTION_ADDRESS : 0;
        assert_int_equal(ask(&r, &first, request, sizeof request), expected);
    }
    for (unsigned bytes = 0; bytes < 256; bytes++) {
        uint8_t request[ADU_PDU_MAX + 20] = {FUNCTION_WRITE};
        put(request + 1, MODBUS_VALVE), put(request + 3, 6);
        request[5] = (uint8_t)bytes;
        assert_int_equal(ask(&r, &first, request, 6 + 12), bytes == 12 ? 0 : -EXCEPTION_VALUE);
        uint8_t both[ADU_PDU_MAX + 20] = {FUNCTION_EXCHANGE};
        put(both + 3, 1), put(both + 5, MODBUS_VALVE), put(both + 7, 6);
        both[9] = (uint8_t)bytes;
        assert_int_equal(ask(&r, &first, both, 10 + 12), bytes == 12 ? 0 : -EXCEPTION_VALUE);
    }
    rig_free(&r);
}

static void functions_that_there_are_not_are_an_exception(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r);
    for (int function = 0; function < 256; function++) {
        uint8_t request[ADU_PDU_MAX] = {(uint8_t)function};
        if (function == 3 || function == 6 || function == 16 || function == 23) continue;
        assert_int_equal(ask(&r, &first, request, 1), -EXCEPTION_FUNCTION);
    }
    rig_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nobody_commands_who_has_not_claimed),
        cmocka_unit_test(who_claims_commands),
        cmocka_unit_test(anybody_elses_write_moves_nothing_and_is_counted),
        cmocka_unit_test(a_claim_of_an_owned_machine_is_refused_without_a_trace),
        cmocka_unit_test(a_master_silent_for_the_watchdogs_time_can_be_replaced),
        cmocka_unit_test(a_master_that_was_silent_is_still_the_master),
        cmocka_unit_test(who_only_reads_loses_the_machine),
        cmocka_unit_test(the_same_token_takes_the_machine_over_to_a_new_connection),
        cmocka_unit_test(on_a_serial_line_the_token_is_the_proof),
        cmocka_unit_test(a_new_master_finds_the_valves_centred_and_the_devices_own_watchdog),
        cmocka_unit_test(a_hand_over_ends_a_command_that_still_holds),
        cmocka_unit_test(a_token_of_nought_is_none_and_half_a_one_neither),
        cmocka_unit_test(nobody_can_read_the_token),
        cmocka_unit_test(a_watchdog_outside_its_bounds_is_refused),
        cmocka_unit_test(a_claim_with_a_bad_watchdog_claims_nothing),
        cmocka_unit_test(a_watchdog_becomes_longer_only_while_the_valves_are_centred),
        cmocka_unit_test(the_watchdog_that_was_set_is_the_one_that_acts),
        cmocka_unit_test(what_is_the_devices_to_say_cannot_be_written),
        cmocka_unit_test(registers_that_are_not_there_are_an_exception),
        cmocka_unit_test(quantities_and_byte_counts_are_checked),
        cmocka_unit_test(functions_that_there_are_not_are_an_exception),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
