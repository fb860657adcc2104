/* The whole Modbus back-end and the whole device at the ends of a serial line that the test
 * carries: it echoes, loses requests, or is as strict about silence as a device may be. Measured
 * times are lower bounds only, so they do not depend on the host's speed. */
#include "support.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#include "backends.h"
#include "device.h"
#include "hal.h"
#include "modbus_adu.h"
#include "modbus_map.h"
#include "monotonic.h"
#include "units.h"

enum { BAUD = 4000000, HOST = 0, DEVICE = 1, ENDS = 2 };

struct line {
    struct params params;
    struct hal *hal;
    struct device *device;
    struct error error;
    int wire[ENDS], kept[ENDS];    /* the test's ends of both lines; the other ends, kept open so
                                    * that no line hangs up */
    char name[ENDS][64];
    pthread_t wire_thread, device_thread;
    _Atomic bool wire_stop, device_stop;
    bool echoes_to_device;
    int64_t strict_ns;             /* silence that the device requires before a request; 0: none */
    _Atomic int lose;              /* number of requests to lose from now on */
    _Atomic int lose_exchanges;    /* number of requests of function 23 to lose from now on */
    _Atomic int garble;            /* number of answers to function 23 to garble from now on */
    _Atomic int requests, claims, lost;
    uint8_t request[ADU_MAX];      /* the part of a request received so far */
    size_t filled;
    int64_t answered_ns;           /* time before the last byte of an answer was passed on */
};

static void wire_open(struct line *l, int end) {
    struct termios raw;
    l->wire[end] = posix_openpt(O_RDWR | O_NOCTTY);
    assert_true(l->wire[end] >= 0 && !grantpt(l->wire[end]) && !unlockpt(l->wire[end]) && !tcgetattr(l->wire[end], &raw));
    cfmakeraw(&raw);
    tcsetattr(l->wire[end], TCSANOW, &raw);
    snprintf(l->name[end], sizeof l->name[end], "%s", ptsname(l->wire[end]));
    l->kept[end] = open(l->name[end], O_RDWR | O_NOCTTY);
    assert_true(l->kept[end] >= 0);
}

/* Returns the size of the request that starts here; 0: not known yet. */
static size_t request_size(const uint8_t *request, size_t filled) {
    size_t head = filled < 2 ? 0 : request[1] == FUNCTION_EXCHANGE ? 11 : request[1] == FUNCTION_WRITE ? 7 : 6;
    if (!head || filled < head) return 0;
    return head + (head > 6 ? request[head - 1] : 0u) + 2;
}

static void hand_on(struct line *l, size_t size) {
    bool early = l->answered_ns && monotonic_ns() - l->answered_ns < l->strict_ns;
    l->requests++;
    l->claims += l->request[1] == FUNCTION_WRITE;
    bool exchange = l->request[1] == FUNCTION_EXCHANGE && l->lose_exchanges > 0;
    bool lost = early || exchange || l->lose > 0;
    if (l->lose > 0) l->lose--;
    if (exchange) l->lose_exchanges--;
    if (lost) l->lost++;
    else assert_int_equal(write(l->wire[DEVICE], l->request, size), (ssize_t)size);
    l->filled -= size;
    memmove(l->request, l->request + size, l->filled);
}

static void carry_requests(struct line *l) {
    ssize_t got = read(l->wire[HOST], l->request + l->filled, sizeof l->request - l->filled);
    if (got > 0) l->filled += (size_t)got;
    for (size_t size; (size = request_size(l->request, l->filled)) && l->filled >= size;) hand_on(l, size);
}

static void carry_answers(struct line *l) {
    uint8_t bytes[ADU_MAX];
    ssize_t got = read(l->wire[DEVICE], bytes, sizeof bytes);
    if (got <= 0) return;
    if (l->echoes_to_device) assert_int_equal(write(l->wire[DEVICE], bytes, (size_t)got), got);
    if (got > 3 && bytes[1] == FUNCTION_EXCHANGE && l->garble > 0) {
        l->garble--;
        bytes[3] ^= 1;
    }
    l->answered_ns = monotonic_ns();
    assert_int_equal(write(l->wire[HOST], bytes, (size_t)got), got);
}

static void *wire_run(void *argument) {
    struct line *l = argument;
    while (!l->wire_stop) {
        struct pollfd p[] = {{.fd = l->wire[HOST], .events = POLLIN}, {.fd = l->wire[DEVICE], .events = POLLIN}};
        poll(p, 2, 1);
        if (p[DEVICE].revents & POLLIN) carry_answers(l);
        if (p[HOST].revents & POLLIN) carry_requests(l);
    }
    return NULL;
}

static void *device_run(void *argument) {
    struct line *l = argument;
    char address[96];
    struct error error;
    snprintf(address, sizeof address, "rtu:%s?baud=%d", l->name[DEVICE], BAUD);
    device_modbus.serve(address, &l->params, l->device, &l->device_stop, &error);
    return NULL;
}

static int line_open_hal(struct line *l) {
    char url[96];
    snprintf(url, sizeof url, "modbus:rtu:%s?baud=%d", l->name[HOST], BAUD);
    int status = hal_open(&l->hal, url, &l->params, 1, &l->error);
    if (!status) assert_int_equal(l->hal->ops->reopens, HAL_REOPENS_SERIAL);
    return status;
}

/* Ages and watchdogs are at their maximum, because no claim concerns them. */
static void line_begin(struct line *l, double period_s) {
    config_default(&l->params);
    l->params.sensors.enabled = false;
    l->params.sim.engine = ENGINE_CLOSED_FORM;
    l->params.loop.period_s = period_s;
    l->params.limits.sensor_age_s = 1.0;
    l->params.device.watchdog_s = 10.0;
    l->device = device_create(&l->params, 1, &l->error);
    assert_non_null(l->device);
    for (int end = 0; end < ENDS; end++) wire_open(l, end);
    assert_int_equal(pthread_create(&l->wire_thread, NULL, wire_run, l), 0);
    assert_int_equal(pthread_create(&l->device_thread, NULL, device_run, l), 0);
}

static void line_end(struct line *l) {
    if (l->hal) l->hal->ops->close(l->hal);
    l->device_stop = true;
    pthread_join(l->device_thread, NULL);
    l->wire_stop = true;
    pthread_join(l->wire_thread, NULL);
    for (int end = 0; end < ENDS; end++) close(l->kept[end]), close(l->wire[end]);
    device_destroy(l->device);
}

/* Runs cycles of the loop, each until its request was on the line; returns the flags of all
 * samples. */
static uint32_t line_cycles(struct line *l, int count) {
    static const struct hal_command moving = {.enable = true, .valve = {0.1, 0.1, 0.1, 0.1, 0.1, 0.1}};
    struct hal_sample sample;
    uint32_t flags = 0;
    for (int i = 0; i < count; i++) {
        int before = l->requests;
        assert_int_equal(l->hal->ops->write(l->hal, &moving), 0);
        while (l->requests == before) sched_yield();
        assert_int_equal(l->hal->ops->read(l->hal, monotonic_ns(), &sample), 0);
        flags |= sample.flags;
    }
    return flags;
}

/* The device receives each of its own answers, and must not take them for requests of the
 * master. */
static void an_adapter_of_the_device_that_hears_itself_disturbs_nothing(void **unused) {
    (void)unused;
    struct line l = {.echoes_to_device = true};
    line_begin(&l, 0.002);
    if (line_open_hal(&l)) fail_msg("%s", l.error.text);
    uint32_t flags = line_cycles(&l, 200);
    int claims = l.claims;
    line_end(&l);
    assert_false(flags & (SAMPLE_FOREIGN | SAMPLE_TWIN));
    assert_int_equal(claims, 1);
}

static void a_device_that_misses_the_first_request_is_asked_again(void **unused) {
    (void)unused;
    struct line l = {.lose = 1};
    line_begin(&l, 0.002);
    if (line_open_hal(&l)) fail_msg("%s", l.error.text);
    line_cycles(&l, 5);
    int lost = l.lost;
    line_end(&l);
    assert_int_equal(lost, 1);
}

static void a_first_exchange_that_is_lost_or_garbled_is_repeated(void **unused) {
    (void)unused;
    struct line l = {.lose_exchanges = 2, .garble = 1};
    line_begin(&l, 0.002);
    if (line_open_hal(&l)) fail_msg("%s", l.error.text);
    int lost = l.lost, claims = l.claims, garble = l.garble;
    line_end(&l);
    assert_int_equal(lost, 2);
    assert_int_equal(garble, 0);
    assert_int_equal(claims, 1);
}

/* The loss costs two periods, however old a reading may be; half a second of silence would cost the
 * connection. */
static void a_request_lost_on_the_line_does_not_cost_the_connection(void **unused) {
    (void)unused;
    struct line l = {0};
    line_begin(&l, 0.002);
    if (line_open_hal(&l)) fail_msg("%s", l.error.text);
    line_cycles(&l, 5);
    l.lose = 1;
    while (l.lose) line_cycles(&l, 1);
    uint32_t flags = line_cycles(&l, 20);
    int claims = l.claims;
    line_end(&l);
    assert_false(flags & (SAMPLE_FOREIGN | SAMPLE_TWIN));
    assert_int_equal(claims, 1);
}

/* If the host stalls, an answer may come so late that the next request follows at once; the test
 * then tries again. */
static void a_strict_device_hears_every_request_where_the_period_has_room(void **unused) {
    (void)unused;
    struct line l = {.strict_ns = ns_from_seconds(modbus_silence_s(BAUD))};
    uint32_t flags = 0;
    int before = -1, lost = 0;
    line_begin(&l, 0.010);
    if (line_open_hal(&l)) fail_msg("%s", l.error.text);
    for (int tries = 0; tries < 20 && lost != before; tries++) {
        before = l.lost;
        flags |= line_cycles(&l, 50);
        lost = l.lost;
    }
    line_end(&l);
    assert_false(flags & (SAMPLE_FOREIGN | SAMPLE_TWIN));
    assert_int_equal(lost, before);
}

/* If the host stalls, the device may accept a request by chance, or miss all of the first exchange,
 * which is a lost connection; the test then tries again. */
static void a_strict_device_is_refused_where_the_period_has_no_room(void **unused) {
    (void)unused;
    struct line l = {.strict_ns = ns_from_seconds(modbus_silence_s(BAUD))};
    int status = STATUS_OK;
    line_begin(&l, 0.002);
    for (int tries = 0; tries < 100 && status != STATUS_USAGE; tries++) {
        status = line_open_hal(&l);
        if (!status) l.hal->ops->close(l.hal);
        l.hal = NULL;
    }
    line_end(&l);
    assert_int_equal(status, STATUS_USAGE);
    if (!strstr(l.error.text, "misses a request") || !strstr(l.error.text, "loop.period_s to 0.0042")) fail_msg("%s", l.error.text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_adapter_of_the_device_that_hears_itself_disturbs_nothing),
        cmocka_unit_test(a_device_that_misses_the_first_request_is_asked_again),
        cmocka_unit_test(a_first_exchange_that_is_lost_or_garbled_is_repeated),
        cmocka_unit_test(a_request_lost_on_the_line_does_not_cost_the_connection),
        cmocka_unit_test(a_strict_device_hears_every_request_where_the_period_has_room),
        cmocka_unit_test(a_strict_device_is_refused_where_the_period_has_no_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
