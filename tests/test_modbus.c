/* The register map and addresses of Modbus, pure functions without a line;
 * tests/scenarios/modbus.sh tests the line. */
#include "support.h"

#include <errno.h>
#include <string.h>

#include "hal.h"
#include "modbus_link.h"
#include "modbus_map.h"

static struct params default_params(void) {
    struct params p;
    config_default(&p);
    return p;
}

static void readings_come_back_to_the_resolution_of_their_registers(void **unused) {
    (void)unused;
    struct params p = default_params();
    struct modbus_reading r = {.number = 512,
                               .sample = 65535,
                               .status = MODBUS_SILENT,
                               .foreign = 4711,
                               .inputs = INPUT_DOOR | INPUT_SUPPLY},
                          back;
    uint16_t registers[MODBUS_READ];
    for (int i = 0; i < LEGS; i++) {
        r.length_m[i] = 1.431 + 0.1234567 * i;
        r.p1_pa[i] = 1.2345e6 * i - 1e5;
        r.p2_pa[i] = 3.2e7 - 1e6 * i; /* up to 32 MPa, which 16 bits of kPa can express */
    }
    modbus_put_reading(&p, &r, registers);
    modbus_get_reading(&p, registers, &back);
    assert_int_equal(back.number, 512);
    assert_int_equal(back.sample, 65535);
    assert_int_equal(back.status, MODBUS_SILENT);
    assert_int_equal(back.foreign, 4711);
    assert_int_equal(back.inputs, INPUT_DOOR | INPUT_SUPPLY);
    for (int i = 0; i < LEGS; i++) {
        assert_close(back.length_m[i], r.length_m[i], 0.5001e-6);
        assert_close(back.p1_pa[i], r.p1_pa[i], 500.001);
        assert_close(back.p2_pa[i], r.p2_pa[i], 500.001);
    }
}

static void what_the_device_does_not_have_is_no_number(void **unused) {
    (void)unused;
    struct params p = default_params();
    struct modbus_reading r = {0}, back;
    uint16_t registers[MODBUS_READ];
    for (int i = 0; i < LEGS; i++) r.length_m[i] = r.p1_pa[i] = r.p2_pa[i] = (double)NAN;
    modbus_put_reading(&p, &r, registers);
    modbus_get_reading(&p, registers, &back);
    for (int i = 0; i < LEGS; i++) {
        assert_true(isnan(back.length_m[i]));
        assert_true(isnan(back.p1_pa[i]));
        assert_true(isnan(back.p2_pa[i]));
    }
}

static void no_register_content_gives_an_implausible_reading(void **unused) {
    (void)unused;
    struct params p = default_params();
    struct modbus_reading r;
    uint16_t registers[MODBUS_READ];
    for (unsigned x = 0; x < 65536; x++) {
        for (int i = 0; i < MODBUS_READ; i++) registers[i] = (uint16_t)(x * (unsigned)(2 * i + 1));
        modbus_get_reading(&p, registers, &r);
        for (int i = 0; i < LEGS; i++) {
            assert_true(isnan(r.length_m[i]) || (r.length_m[i] >= p.length_channel.low[i] && r.length_m[i] <= p.length_channel.high[i]));
            assert_true(isnan(r.p1_pa[i]) || (r.p1_pa[i] >= p.p1_channel.low[i] && r.p1_pa[i] <= p.p1_channel.high[i]));
        }
    }
}

static void commands_come_back_and_what_is_none_is_the_centre(void **unused) {
    (void)unused;
    struct params p = default_params();
    const struct hal_command sent = {.valve = {0.0, 1.0, -1.0, 0.123456, (double)NAN, 7.0}, .supply = true};
    uint16_t written[MODBUS_WRITTEN];
    struct hal_command back;
    modbus_put_command(&p, 0x12345678, 9, &sent, written);
    modbus_get_command(&p, written, &back);
    assert_int_equal(written[MODBUS_TOKEN - MODBUS_WRITE_FROM], 0x1234);
    assert_int_equal(written[MODBUS_TOKEN + 1 - MODBUS_WRITE_FROM], 0x5678);
    assert_int_equal(written[MODBUS_COMMAND - MODBUS_WRITE_FROM], 9);
    assert_true(back.supply);
    for (int i = 0; i < 4; i++) assert_close(back.valve[i], sent.valve[i], 0.5 / 32767);
    assert_true(back.valve[4] == 0.0);
    assert_close(back.valve[5], 1.0, 1e-12); /* clipped to full opening */
}

static void registers_of_the_map_follow_each_other_and_are_those_of_the_transaction(void **unused) {
    (void)unused;
    unsigned next = 0;
    int written = 0, read = 0;
    for (const struct modbus_register *r = modbus_map; r->type; r++) {
        assert_true(r->address >= next);
        next = r->address + (unsigned)r->count;
        if (r->address >= MODBUS_WRITE_FROM && r->address < MODBUS_WRITE_FROM + MODBUS_WRITTEN) written += r->count;
        if (r->address >= MODBUS_READ_FROM) read += r->count;
    }
    assert_int_equal(next, MODBUS_END);
    assert_int_equal(written, MODBUS_WRITTEN);
    assert_int_equal(read, MODBUS_READ);
}

/* 33 + 63 bytes of 10 bits at 115200 baud take 8.33 ms, and the silences 7 bytes more. */
static void a_cycle_on_a_serial_line_takes_its_bits(void **unused) {
    (void)unused;
    struct modbus_load l = modbus_load(115200.0);
    assert_int_equal(l.request_bytes, 33);
    assert_int_equal(l.response_bytes, 63);
    assert_close(l.request_s + l.response_s, 96 * 10 / 115200.0, 1e-12);
    assert_close(l.cycle_s, 103 * 10 / 115200.0, 1e-12);
}

/* Serial Line V1.02, 2.5.1.1: 3.5 characters, above 19200 baud 1.75 ms; less only if the period has
 * no room for that. */
static void the_silence_between_frames_is_the_standards_where_the_period_has_room(void **unused) {
    (void)unused;
    assert_close(modbus_silence_s(9600.0), 35 / 9600.0, 1e-12);
    assert_close(modbus_silence_s(19200.0), 35 / 19200.0, 1e-12);
    for (const int *baud = modbus_bauds; *baud; baud++) {
        struct modbus_load l = modbus_load(*baud);
        if (*baud > 19200) assert_close(modbus_silence_s(*baud), 1.75e-3, 1e-12);
        assert_close(l.strict_cycle_s - l.request_s - l.response_s, 2 * modbus_silence_s(*baud), 1e-12);
        assert_close(modbus_kept_silence_s(*baud, 1.001 * l.strict_cycle_s / 0.9), modbus_silence_s(*baud), 1e-12);
        assert_close(modbus_kept_silence_s(*baud, 0.999 * l.strict_cycle_s / 0.9), 35.0 / *baud, 1e-12);
    }
}

enum { ENOBASE = 112345678 }; /* libmodbus' MODBUS_ENOBASE */

static void every_exception_is_told_with_its_number_and_what_it_means(void **unused) {
    (void)unused;
    static const char *const means[12] = {"",        "another map",       "no such registers", "value",  "device itself",
                                          "at once", "another master",    "refuses",           "memory", "no standard",
                                          "gateway", "behind the gateway"};
    for (int code = 1; code <= 11; code++) {
        const char *text = modbus_link_reason(ENOBASE + code);
        char number[20];
        snprintf(number, sizeof number, "exception %d,", code);
        if (!strstr(text, means[code]) || (code != 6 && !strstr(text, number))) fail_msg("%d: %s", code, text);
        assert_true(strlen(text) < 200);
    }
    assert_non_null(strstr(modbus_link_reason(ENOBASE + 12), "checksum")); /* EMBBADCRC */
    assert_non_null(strstr(modbus_link_reason(ENOTUNIQ), "two devices"));
}

static void addresses_are_taken_apart(void **unused) {
    (void)unused;
    struct modbus_address_parts a;
    struct error error;
    assert_int_equal(modbus_parse("tcp://10.0.0.5:502", &a, &error), 0);
    assert_string_equal(a.name, "10.0.0.5");
    assert_string_equal(a.port, "502");
    assert_int_equal(modbus_parse("tcp://[::1]:1502", &a, &error), 0);
    assert_string_equal(a.name, "::1");
    assert_int_equal(modbus_parse("rtu:/dev/ttyS0?baud=115200", &a, &error), 0);
    assert_true(a.serial);
    assert_string_equal(a.name, "/dev/ttyS0");
    assert_int_equal(a.baud, 115200);
}

static void addresses_that_are_none_are_refused_with_the_right_form(void **unused) {
    (void)unused;
    /* clang-format off */
    static const char *const bad[] = {"", "tcp:", "tcp://", "tcp://:502", "tcp://host", "tcp://host:", "tcp://host:x", "tcp://host:65536",
                                      "tcp://host:-1", "tcp://[]:502", "tcp://host:5 02", "rtu:", "rtu:/dev/ttyS0", "rtu:?baud=9600",
                                      "rtu:/dev/ttyS0?baud=", "rtu:/dev/ttyS0?baud=1e5", "rtu:/dev/ttyS0?baud=99999999999999999999",
                                      "udp://host:502"};
    /* clang-format on */
    struct modbus_address_parts a;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct error error = {0};
        assert_int_equal(modbus_parse(bad[i], &a, &error), STATUS_USAGE);
        assert_non_null(strstr(error.text, "modbus:tcp://HOST:PORT"));
    }
    char longest[400] = "tcp://";
    memset(longest + 6, 'a', 380);
    memcpy(longest + 386, ":502", 5);
    struct error error = {0};
    assert_int_equal(modbus_parse(longest, &a, &error), STATUS_USAGE);
}

static void rates_that_the_line_cannot_have_are_refused_with_those_it_can(void **unused) {
    (void)unused;
    static const int bad[] = {1, 9599, 9601, 9700, 13500, 14400, 100000, 128000, 2000000, 4000001};
    struct modbus_address_parts a;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct error error = {0};
        char address[60];
        snprintf(address, sizeof address, "rtu:/dev/ttyS0?baud=%d", bad[i]);
        assert_int_equal(modbus_parse(address, &a, &error), STATUS_USAGE);
        assert_non_null(strstr(error.text, " 9600 19200 "));
        assert_non_null(strstr(error.text, " 4000000"));
    }
}

static void limits_too_tight_for_a_slow_cycle_are_refused(void **unused) {
    (void)unused;
    static const struct {
        double period_s, age_s, watchdog_s;
        const char *word;
    } bad[] = {{0.002, 0.1, 1.0, "115200"}, {0.01, 0.02, 1.0, "limits.sensor_age_s"}, {0.01, 0.1, 0.02, "device.watchdog_s"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct params p = default_params();
        struct error error = {0};
        struct hal *hal;
        p.loop.period_s = bad[i].period_s, p.limits.sensor_age_s = bad[i].age_s, p.device.watchdog_s = bad[i].watchdog_s;
        assert_int_equal(hal_open(&hal, "modbus:rtu:/dev/null?baud=115200", &p, 1, &error), STATUS_USAGE);
        assert_non_null(strstr(error.text, bad[i].word));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(readings_come_back_to_the_resolution_of_their_registers),
        cmocka_unit_test(what_the_device_does_not_have_is_no_number),
        cmocka_unit_test(no_register_content_gives_an_implausible_reading),
        cmocka_unit_test(commands_come_back_and_what_is_none_is_the_centre),
        cmocka_unit_test(registers_of_the_map_follow_each_other_and_are_those_of_the_transaction),
        cmocka_unit_test(a_cycle_on_a_serial_line_takes_its_bits),
        cmocka_unit_test(the_silence_between_frames_is_the_standards_where_the_period_has_room),
        cmocka_unit_test(every_exception_is_told_with_its_number_and_what_it_means),
        cmocka_unit_test(addresses_are_taken_apart),
        cmocka_unit_test(addresses_that_are_none_are_refused_with_the_right_form),
        cmocka_unit_test(rates_that_the_line_cannot_have_are_refused_with_those_it_can),
        cmocka_unit_test(limits_too_tight_for_a_slow_cycle_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
