/* The core of the device side: each latch is of one instant, the plant follows the clock, and the
 * watchdog works. Time is an argument, so nothing sleeps. */
#include "support.h"

#include "device.h"
#include "units.h"

static const double out_of_rest[LEGS] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, centre[LEGS] = {0};
static const int64_t start_ns = 1000 * NS_PER_S, period_ns = 2000000;

/* Sends a command; the life sign for the supply toggles every period. */
static void live(struct device *d, const double valve[LEGS], int64_t now_ns) {
    struct hal_command command = {.enable = true, .supply = (now_ns + period_ns / 2) / period_ns % 2};
    memcpy(command.valve, valve, sizeof command.valve);
    device_live(d, &command, now_ns);
}

static struct device *make(struct params *p) {
    struct error error;
    config_default(p);
    p->sensors.enabled = false;
    p->sim.engine = ENGINE_CLOSED_FORM;
    struct device *d = device_create(p, 1, &error);
    assert_non_null(d);
    return d;
}

static double leg(struct device *d, int64_t now_ns) {
    struct hal_sample s = {0};
    device_latch(d, now_ns, &s);
    return s.length_m[0];
}

/* Extends the legs for half a second; returns the time of the next latch. */
static int64_t extend(struct device *d) {
    int64_t now_ns = start_ns;
    for (int i = 0; i < 250; i++) live(d, out_of_rest, now_ns), now_ns += period_ns;
    return now_ns;
}

static void a_request_that_comes_twice_reads_the_same_and_takes_no_time(void **state) {
    struct params p;
    struct device *d = make(&p), *once = make(&p);
    struct hal_sample first = {0}, again = {0};
    (void)state;
    p.sensors.enabled = true; /* with noise on, a second reading would differ */
    int64_t now_ns = extend(d);
    extend(once);
    assert_true(device_latch(d, now_ns, &first));
    live(d, out_of_rest, now_ns);
    assert_false(device_latch(d, now_ns + period_ns / 5, &again));
    assert_memory_equal(&first, &again, sizeof first);
    live(d, centre, now_ns + period_ns / 5);
    assert_true(device_latch(d, now_ns + period_ns, &again));
    p.sensors.enabled = false;
    live(once, out_of_rest, now_ns);
    double moved = leg(once, now_ns + period_ns);
    assert_true(leg(d, now_ns + period_ns) == moved);
    /* the second device's command is in force from the next period on */
    assert_true(leg(d, now_ns + 3 * period_ns) < leg(once, now_ns + 3 * period_ns));
    device_destroy(once);
    device_destroy(d);
}

static void commands_move_the_legs_and_the_centre_holds_them(void **state) {
    struct params p;
    struct device *d = make(&p);
    (void)state;
    double rest = leg(d, start_ns);
    int64_t now_ns = extend(d);
    assert_true(leg(d, now_ns) > rest + 0.05);
    for (int i = 0; i < 100; i++) live(d, centre, now_ns), now_ns += period_ns;
    double held = leg(d, now_ns);
    for (int i = 0; i < 50; i++) live(d, centre, now_ns), now_ns += period_ns;
    /* trapped oil holds the leg: leakage across the piston shifts the pressures, and the
     * oscillation decays */
    assert_close(leg(d, now_ns), held, 1e-3);
    device_destroy(d);
}

/* Checks that a late or early request reads the same as one in time. */
static void request_both(struct device *d, int64_t came_ns, struct device *in_time, int64_t due_ns, const double valve[LEGS]) {
    assert_true(leg(d, came_ns) == leg(in_time, due_ns));
    live(d, valve, came_ns);
    live(in_time, valve, due_ns);
}

static void the_hosts_jitter_is_not_in_the_readings(void **state) {
    struct params p;
    struct device *d = make(&p), *in_time = make(&p);
    unsigned dice = 1;
    (void)state;
    int64_t due_ns = extend(d);
    extend(in_time);
    for (int i = 0; i < 500; i++, due_ns += period_ns) {
        dice = dice * 1103515245u + 12345u;
        int64_t came_ns = due_ns + (int64_t)(dice >> 16 & 1023) * period_ns * 8 / 10240 - period_ns * 4 / 10;
        for (int64_t ns = due_ns - period_ns / 2; ns < came_ns; ns += NS_PER_S / 1000) device_tick(d, ns);
        request_both(d, came_ns, in_time, due_ns, i % 2 ? out_of_rest : centre);
    }
    device_destroy(in_time);
    device_destroy(d);
}

/* The daemon's clock is 0.5 % slow. The grid of the device follows it, so that there is one period
 * per request. */
static void the_grid_follows_the_daemon(void **state) {
    struct params p;
    struct device *d = make(&p), *in_time = make(&p);
    (void)state;
    int64_t due_ns = extend(d), came_ns = due_ns;
    extend(in_time);
    for (int i = 0; i < 2000; i++, due_ns += period_ns, came_ns += period_ns + period_ns / 200) {
        request_both(d, came_ns, in_time, due_ns, i % 2 ? out_of_rest : centre);
    }
    device_destroy(in_time);
    device_destroy(d);
}

/* The daemon pauses to distinguish late answers from lost ones, or it stalls and returns. The
 * machine never waits for it, whether device_tick() is called or not. */
static void requests_left_out_do_not_hold_the_machine_up(void **state) {
    (void)state;
    for (int left_out = 1; left_out <= 5; left_out++)
        for (int ticked = 0; ticked <= 1; ticked++) {
            struct params p;
            struct device *d = make(&p), *in_time = make(&p);
            int64_t now_ns = extend(d), came_ns = now_ns + left_out * period_ns;
            extend(in_time);
            for (int64_t ns = now_ns; ticked && ns < came_ns; ns += NS_PER_S / 1000) device_tick(d, ns);
            for (; now_ns < came_ns; now_ns += period_ns) live(in_time, out_of_rest, now_ns);
            assert_true(leg(d, came_ns) == leg(in_time, came_ns));
            device_destroy(in_time);
            device_destroy(d);
        }
}

static void ticks_do_nothing_while_the_bus_lives(void **state) {
    struct params p;
    struct device *d = make(&p), *unticked = make(&p);
    (void)state;
    int64_t now_ns = extend(d);
    extend(unticked);
    assert_false(device_tick(d, now_ns));
    assert_false(device_tick(d, now_ns + period_ns / 2 - 1));
    assert_true(leg(d, now_ns) == leg(unticked, now_ns));
    device_destroy(unticked);
    device_destroy(d);
}

/* A silent bus does not freeze the platform: it follows the last command until the watchdog centres
 * the valves, and then stops. */
static void a_silent_bus_lets_the_machine_live_on_and_then_stops_it(void **state) {
    struct params p;
    struct device *d = make(&p);
    (void)state;
    int64_t now_ns = extend(d), silent_ns = now_ns - period_ns;
    double length = leg(d, now_ns);
    while (!device_tick(d, now_ns)) now_ns += NS_PER_S / 1000;
    int64_t ridden_ns = now_ns - silent_ns, watchdog_ns = ns_from_seconds(p.device.watchdog_s);
    assert_true(ridden_ns > watchdog_ns && ridden_ns <= watchdog_ns + NS_PER_S / 1000);
    double moved = leg(d, now_ns) - length;
    assert_true(moved > 0.001 && moved < p.limits.leg_rate_mps * p.device.watchdog_s * 1.5);
    for (int i = 0; i < 300; i++) device_tick(d, now_ns += NS_PER_S / 1000);
    double stopped = leg(d, now_ns);
    for (int i = 0; i < 100; i++) assert_true(device_tick(d, now_ns += NS_PER_S / 1000));
    assert_close(leg(d, now_ns), stopped, 1e-3);
    device_destroy(d);
}

/* After a gap the device simulates the missed time with the old valve commands, and with centred
 * valves from the watchdog's time on, whether or not it was polled in between. */
static void the_watchdog_holds_in_time_caught_up(void **state) {
    struct params p;
    struct device *d = make(&p), *ticked = make(&p);
    (void)state;
    int64_t now_ns = extend(d), later_ns = now_ns + 4 * ns_from_seconds(p.device.watchdog_s);
    extend(ticked);
    while (now_ns < later_ns) device_tick(ticked, now_ns += NS_PER_S / 1000);
    assert_true(leg(d, later_ns) == leg(ticked, later_ns));
    device_destroy(ticked);
    device_destroy(d);
}

/* An hour would be 1.8 million periods; the device simulates only one, with the valves centred. */
static void a_stopped_process_does_not_catch_up(void **state) {
    struct params p;
    struct device *d = make(&p), *one = make(&p);
    (void)state;
    int64_t now_ns = extend(d), later_ns = now_ns + 3600 * NS_PER_S;
    extend(one);
    assert_true(device_tick(d, later_ns));
    live(one, centre, now_ns);
    assert_true(leg(d, later_ns) == leg(one, now_ns + period_ns));
    device_destroy(one);
    device_destroy(d);
}

/* A watchdog that has fired keeps the valves centred until the next command. */
static void a_longer_watchdog_counts_from_the_next_command_on(void **state) {
    struct params p;
    struct device *d = make(&p);
    (void)state;
    int64_t now_ns = extend(d) - period_ns + ns_from_seconds(p.device.watchdog_s) + 1;
    assert_true(device_tick(d, now_ns));
    device_set_watchdog(d, 2.0);
    assert_true(device_tick(d, now_ns + 1));
    live(d, centre, now_ns += period_ns);
    assert_false(device_tick(d, now_ns + NS_PER_S));
    device_destroy(d);
}

static void a_valve_that_a_node_centres_does_not_wait_for_a_command(void **state) {
    struct params p;
    struct device *d = make(&p), *commanded = make(&p);
    (void)state;
    int64_t now_ns = extend(d);
    extend(commanded);
    device_valves(d, centre);
    device_tick(d, now_ns + period_ns);
    live(commanded, centre, now_ns);
    assert_true(leg(d, now_ns + period_ns) == leg(commanded, now_ns + period_ns));
    device_destroy(commanded);
    device_destroy(d);
}

static void before_the_first_command_the_watchdog_holds(void **state) {
    struct params p;
    struct device *d = make(&p);
    (void)state;
    assert_true(device_tick(d, 1)); /* the machine has just been switched on */
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
        cmocka_unit_test(a_request_that_comes_twice_reads_the_same_and_takes_no_time),
        cmocka_unit_test(commands_move_the_legs_and_the_centre_holds_them),
        cmocka_unit_test(the_hosts_jitter_is_not_in_the_readings),
        cmocka_unit_test(the_grid_follows_the_daemon),
        cmocka_unit_test(requests_left_out_do_not_hold_the_machine_up),
        cmocka_unit_test(ticks_do_nothing_while_the_bus_lives),
        cmocka_unit_test(a_silent_bus_lets_the_machine_live_on_and_then_stops_it),
        cmocka_unit_test(the_watchdog_holds_in_time_caught_up),
        cmocka_unit_test(a_stopped_process_does_not_catch_up),
        cmocka_unit_test(a_longer_watchdog_counts_from_the_next_command_on),
        cmocka_unit_test(a_valve_that_a_node_centres_does_not_wait_for_a_command),
        cmocka_unit_test(before_the_first_command_the_watchdog_holds),
        cmocka_unit_test(an_unknown_bus_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
