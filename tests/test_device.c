/* The device side's core: one instant a latch, a period of life a command, and the watchdog. Time is an argument: nothing sleeps. */
#include "support.h"

#include "device.h"
#include "units.h"

static const double out_of_rest[LEGS] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, centre[LEGS] = {0};
static const int64_t start_ns = 1000 * NS_PER_S, period_ns = 2000000;

static struct device *make(struct params *p) {
    struct error error;
    config_default(p);
    p->sensors.enabled = false;
    p->sim.engine = ENGINE_CLOSED_FORM;
    struct device *d = device_create(p, 1, &error);
    assert_non_null(d);
    return d;
}

static double leg(struct device *d) {
    struct hal_sample s = {0};
    device_latch(d, &s);
    return s.length_m[0];
}

/* Extends for half a second; returns the time. */
static int64_t extend(struct device *d) {
    int64_t now_ns = start_ns;
    for (int i = 0; i < 250; i++) device_live(d, 1, out_of_rest, now_ns += period_ns);
    return now_ns;
}

static void latching_twice_reads_the_same_instant(void **state) {
    struct params p;
    struct device *d = make(&p);
    (void)state;
    extend(d);
    struct hal_sample a = {0}, b = {0};
    device_latch(d, &a);
    device_latch(d, &b);
    assert_memory_equal(&a, &b, sizeof a); /* sensors are exact here: no noise drawn */
    device_destroy(d);
}

static void commands_move_the_legs_and_the_centre_holds_them(void **state) {
    struct params p;
    struct device *d = make(&p);
    (void)state;
    double rest = leg(d);
    int64_t now_ns = extend(d);
    assert_true(leg(d) > rest + 0.05);
    for (int i = 0; i < 100; i++) device_live(d, 1, centre, now_ns += period_ns);
    double held = leg(d);
    for (int i = 0; i < 50; i++) device_live(d, 1, centre, now_ns += period_ns);
    assert_close(leg(d), held, 1e-3); /* oil is trapped: what leaks across the piston shifts pressures; the rest is the swing dying out */
    device_destroy(d);
}

static void ticks_do_nothing_while_the_bus_lives(void **state) {
    struct params p;
    struct device *d = make(&p);
    (void)state;
    int64_t now_ns = extend(d);
    double length = leg(d);
    assert_false(device_tick(d, now_ns + period_ns));
    assert_false(device_tick(d, now_ns + 2 * period_ns));
    assert_true(leg(d) == length);
    device_destroy(d);
}

/* The platform is not frozen when the bus is: it goes on with the last command until the watchdog centres the valves, and stops. */
static void a_silent_bus_lets_the_machine_live_on_and_then_stops_it(void **state) {
    struct params p;
    struct device *d = make(&p);
    (void)state;
    int64_t now_ns = extend(d), silent_ns = now_ns;
    double length = leg(d);
    while (!device_tick(d, now_ns)) now_ns += NS_PER_S / 1000;
    int64_t ridden_ns = now_ns - silent_ns, watchdog_ns = ns_from_seconds(p.device.watchdog_s);
    assert_true(ridden_ns > watchdog_ns && ridden_ns <= watchdog_ns + NS_PER_S / 1000);
    double moved = leg(d) - length;
    assert_true(moved > 0.001 && moved < p.limits.leg_rate_mps * p.device.watchdog_s * 1.5);
    for (int i = 0; i < 300; i++) device_tick(d, now_ns += NS_PER_S / 1000);
    double stopped = leg(d);
    for (int i = 0; i < 100; i++) assert_true(device_tick(d, now_ns += NS_PER_S / 1000));
    assert_close(leg(d), stopped, 1e-3);
    device_destroy(d);
}

static void a_stopped_process_does_not_catch_up(void **state) {
    struct params p;
    struct device *d = make(&p);
    (void)state;
    int64_t now_ns = extend(d);
    assert_true(device_tick(d, now_ns + 3600 * NS_PER_S)); /* an hour at once would be 1.8 million periods */
    device_destroy(d);
}

static void an_unknown_bus_is_refused(void **state) {
    struct params p;
    struct device *d = make(&p);
    struct error error;
    _Atomic bool stop = true;
    (void)state;
    assert_int_equal(device_serve("carrier-pigeon:1", &p, d, &stop, &error), STATUS_USAGE);
    assert_int_equal(device_serve("can:nowhere0", &p, d, &stop, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "nowhere0"));
    device_destroy(d);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(latching_twice_reads_the_same_instant),
        cmocka_unit_test(commands_move_the_legs_and_the_centre_holds_them),
        cmocka_unit_test(ticks_do_nothing_while_the_bus_lives),
        cmocka_unit_test(a_silent_bus_lets_the_machine_live_on_and_then_stops_it),
        cmocka_unit_test(a_stopped_process_does_not_catch_up),
        cmocka_unit_test(an_unknown_bus_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
