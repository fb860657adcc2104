/* The live page's server without its sockets: it keeps a bounded and true record of its messages
 * whoever sent them, and answers requests only under its own names. */
#include "support.h"

#include <jansson.h>
#include <stdio.h>

#include "kinematics.h"
#include "live_request.h"
#include "live_state.h"
#include "messages.h"
#include "units.h"

static struct live_state state;
static struct params params;

static int start(void **unused) {
    struct error error;
    (void)unused;
    config_default(&params);
    return live_state_init(&state, &params, &error);
}

static int end(void **unused) {
    (void)unused;
    live_state_free(&state);
    return 0;
}

static void hear(const char *channel, const void *data, int size, int64_t now_ms) {
    struct bus_message m = {.data = data, .size = size};
    snprintf(m.channel, sizeof m.channel, "%s", channel);
    live_state_take(&state, &m, now_ms);
}

static double stretch_m; /* stretch of the legs in the cycles */

static void hear_cycle(uint64_t seq, uint32_t faults, int64_t now_ms) {
    unsigned char buffer[STATE_MESSAGE_MAX];
    struct cycle c = {.seq = seq,
                      .in.time_ns = (int64_t)seq * 2000000,
                      .state = STATE_TESTING,
                      .test = 0,
                      .faults = faults,
                      .first_fault = faults & FAULT_ANY};
    c.force_n[2] = (double)NAN;
    ik_lengths(&state.kinematics, c.pose, c.in.length_m);
    for (int i = 0; i < LEGS; i++) c.in.length_m[i] += stretch_m;
    hear(CHANNEL_STATE, buffer, state_encode(&c, buffer), now_ms);
}

static void hear_event(uint64_t seq, const char *kind, const char *text) {
    unsigned char buffer[4096];
    hear(CHANNEL_EVENT, buffer, event_encode(0, seq, kind, text, buffer, sizeof buffer), 0);
}

/* Parses the text; the caller frees the result with json_decref(). */
static json_t *parsed(const struct json_text *j) {
    json_error_t error;
    json_t *root = json_loadb(j->text, j->size, 0, &error);
    if (!root) fail_msg("no JSON: %s in %.*s", error.text, (int)j->size, j->text);
    return root;
}

static double health(const char *name, int64_t now_ms) {
    struct json_text j = {0};
    live_state_health(&state, now_ms, &j);
    json_t *root = parsed(&j), *value = json_object_get(root, name);
    double number = json_is_number(value) ? json_number_value(value) : (double)NAN;
    json_decref(root);
    json_text_free(&j);
    return number;
}

static void says_of_the_fault(const char *name, const char *words) {
    assert_true(state.place[LIVE_FAULT].size > 0);
    json_t *fault = parsed(&state.place[LIVE_FAULT]);
    assert_string_equal(json_string_value(json_object_get(fault, "name")), name);
    assert_non_null(strstr(json_string_value(json_object_get(fault, "cause")), words));
    assert_true(strlen(json_string_value(json_object_get(fault, "remedy"))) > 5);
    json_decref(fault);
}

/* ---- received messages ---- */

static void the_machine_is_described_by_its_configuration(void **unused) {
    (void)unused;
    json_t *m = parsed(&state.machine);
    assert_int_equal(json_array_size(json_object_get(m, "upper_m")), 18);
    assert_int_equal(json_array_size(json_object_get(m, "nominal_mt_si")), 36);
    assert_int_equal(json_array_size(json_object_get(m, "tests")), params.tests.count);
    assert_string_equal(json_string_value(json_object_get(m, "mechanism")), "stewart");
    json_decref(m);
}

static void a_cycle_is_json_and_what_it_does_not_know_is_null(void **unused) {
    (void)unused;
    hear_cycle(10, 0, 0);
    json_t *c = parsed(&state.cycle[state.cycles % LIVE_CYCLES]), *forces = json_object_get(c, "force_n");
    assert_int_equal(json_integer_value(json_object_get(c, "seq")), 10);
    assert_close(json_number_value(json_object_get(c, "time_s")), 0.02, 1e-12);
    assert_true(json_is_null(json_array_get(forces, 2)) && json_is_number(json_array_get(forces, 3)));
    assert_below(health("misfit_m", 0), 1e-9);
    json_decref(c);
}

static void another_machine_than_the_configured_one_is_noticed(void **unused) {
    (void)unused;
    stretch_m = 0.02;
    hear_cycle(10, 0, 0);
    /* tolerance: lengths are rounded to 1e-16 m, JSON's six digits to 1e-8 m at most */
    assert_close(health("misfit_m", 0), stretch_m, 1e-9);
    hear_cycle(20, FAULT_LEG_RATE, 0); /* with this fault the pose is an older one, and nothing is
                                        * compared */
    assert_close(health("misfit_m", 0), 0.0, 1e-9);
    stretch_m = 0.0;
}

/* The server keeps 50 cycles per second of the loop's time, and never more than the ring has room
 * for. */
static void a_flood_of_cycles_is_thinned_and_bounded(void **unused) {
    (void)unused;
    for (uint64_t seq = 1; seq <= 500 * 60; seq++) hear_cycle(seq, 0, (int64_t)seq * 2);
    assert_in_range(state.cycles, 60 * 50 - 2, 60 * 50 + 2);
    assert_int_equal((int)health("messages", 60000), 500 * 60);
    assert_int_equal((int)health("lost", 60000), 0);
}

static void gaps_are_counted_as_lost(void **unused) {
    (void)unused;
    for (uint64_t seq = 0; seq < 1000; seq += 10)
        if (seq < 300 || seq > 340) hear_cycle(seq, 0, (int64_t)seq * 2);
    assert_int_equal((int)health("lost", 2000), 5);
}

static void a_new_start_is_noticed_and_clears_what_was_of_the_old_one(void **unused) {
    (void)unused;
    for (uint64_t seq = 0; seq < 1000; seq += 10) hear_cycle(seq, 0, (int64_t)seq * 2);
    hear_cycle(1000, FAULT_STROKE, 2000);
    assert_true(state.place[LIVE_FAULT].size > 0);
    hear_cycle(990, FAULT_STROKE, 2001); /* a delayed message is no new start */
    assert_int_equal((int)health("run", 2001), 1);
    hear_cycle(0, 0, 2010);
    assert_int_equal((int)health("run", 2010), 2);
    assert_int_equal(state.place[LIVE_FAULT].size, 0);
    assert_int_equal((int)health("messages", 2010), 1);
    assert_close(health("silence_s", 3510), 1.5, 1e-9);
}

static void a_fault_is_known_from_a_cycle_alone_until_one_has_none(void **unused) {
    (void)unused;
    hear_cycle(10, FAULT_FOLLOWING | fault_leg(2), 0);
    says_of_the_fault("following_error, leg 3", "valve that sticks");
    hear_cycle(20, FAULT_FOLLOWING | FAULT_STROKE | fault_leg(2) | fault_leg(4), 20);
    assert_int_equal(state.fault.legs, 1u << 2 | 1u << 4);
    hear_cycle(30, 0, 40);
    assert_int_equal(state.place[LIVE_FAULT].size, 0);
}

/* A run that ends with a fault sends no cycle that has it, only events. */
static void a_fault_is_known_from_its_events_alone(void **unused) {
    (void)unused;
    hear_cycle(10, 0, 0);
    hear_event(15, "fault", "overrun, legs 2 6: 10 missed, limit 15 missed (loop.overrun_limit)");
    hear_event(15, "cause", "12 deadlines missed in a row");
    hear_event(15, "remedy", "free the host");
    says_of_the_fault("overrun, legs 2 6", "12 deadlines");
    assert_int_equal(state.fault.legs, 1u << 1 | 1u << 5);
    assert_string_equal(state.fault.measured, "10 missed, limit 15 missed (loop.overrun_limit)");
    hear_cycle(20, 0, 20);
    assert_int_equal(state.place[LIVE_FAULT].size, 0);
}

static void texts_of_strangers_are_text(void **unused) {
    (void)unused;
    hear_event(1, "no\033te", "\"</script>\\\xff\xe2\x80\xae\n");
    json_t *e = parsed(&state.event[state.events % LIVE_EVENTS]);
    assert_string_equal(json_string_value(json_object_get(e, "kind")), "no?te");
    assert_string_equal(json_string_value(json_object_get(e, "text")), "\"</script>\\???");
    json_decref(e);
    for (int i = 0; i < 1000; i++) hear_event(1, "config", "kept out");
    assert_int_equal(state.events, 1);
}

static void no_message_is_counted_and_kept_out(void **unused) {
    static const unsigned char bytes[LIVE_MESSAGE_MAX + 1];
    static const char *const channels[] = {CHANNEL_STATE, CHANNEL_EVENT, CHANNEL_TEST_RESULT, CHANNEL_IDENTIFICATION, CHANNEL_GAP};
    static const int sizes[] = {0, 1, 417, LIVE_MESSAGE_MAX, LIVE_MESSAGE_MAX + 1};
    (void)unused;
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 5; k++) hear(channels[i], bytes, sizes[k], 0);
    assert_int_equal((int)health("dropped", 0), 25);
    assert_false(state.heard);
    /* a message of a foreign channel is not counted as dropped */
    hear(CHANNEL_COMMAND, bytes, 10, 0);
    assert_int_equal((int)health("dropped", 0), 25);
}

/* Impossible sequence numbers and times in any order cause no overflow (sanitizers check), and the
 * output is always JSON. */
static void times_of_strangers_do_no_harm(void **unused) {
    static const uint64_t seqs[] = {0, INT64_MAX, 1, INT64_MAX - 1, 5, INT64_MAX, 0};
    static const int64_t times[] = {INT64_MIN, INT64_MAX, 0, INT64_MIN, INT64_MAX};
    unsigned char buffer[STATE_MESSAGE_MAX];
    (void)unused;
    for (int i = 0; i < 35; i++) {
        struct cycle c = {.seq = seqs[i % 7], .in.time_ns = times[i % 5], .test = -1, .dof = DOF_NONE, .faults = UINT32_MAX};
        hear(CHANNEL_STATE, buffer, state_encode(&c, buffer), i % 3 * 1000);
        json_decref(parsed(&state.cycle[state.cycles % LIVE_CYCLES]));
    }
    health("lost", INT64_MAX);
}

static void a_single_cylinder_has_one_of_everything(void **unused) {
    struct error error;
    (void)unused;
    live_state_free(&state);
    params.mechanism = MECHANISM_AXIS;
    assert_int_equal(live_state_init(&state, &params, &error), STATUS_OK);
    json_t *m = parsed(&state.machine);
    assert_string_equal(json_string_value(json_object_get(m, "mechanism")), "axis");
    assert_null(json_object_get(m, "nominal_mt_si"));
    json_decref(m);
    hear_cycle(10, 0, 0);
    json_t *c = parsed(&state.cycle[state.cycles % LIVE_CYCLES]);
    assert_int_equal(json_array_size(json_object_get(c, "force_n")), 1);
    assert_int_equal(json_array_size(json_object_get(c, "pose_m_rad")), 1);
    json_decref(c);
}

/* ---- requests ---- */

static void addresses_are_read_or_refused(void **unused) {
    static const struct {
        const char *text, *host;
        int port;
    } good[] = {
        {"127.0.0.1:8321", "127.0.0.1", 8321}, {"8321", "127.0.0.1", 8321}, {"localhost:0", "localhost", 0}, {"[::1]:80", "::1", 80},
        {"0.0.0.0:65535", "0.0.0.0", 65535},
    };
    static const char *const bad[] = {
        "",      ":",       "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536",          "127.0.0.1:-1",   "127.0.0.1:80x", "::1:80",
        "[::1]", "[::1]80", "[]:80",     ":80",        "a b:99999999999999999999", "127.0.0.1:8321/"};
    struct live_address a;
    struct error error;
    (void)unused;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        assert_int_equal(live_address_parse(good[i].text, &a, &error), STATUS_OK);
        assert_string_equal(a.host, good[i].host);
        assert_int_equal(a.port, good[i].port);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(live_address_parse(bad[i], &a, &error), STATUS_USAGE);
        assert_non_null(strstr(error.text, "--http"));
    }
}

static void hosts_that_a_stranger_could_name_are_refused(void **unused) {
    static const char *const good[] = {"127.0.0.1:8321",   "localhost", "LOCALHOST:9000", "[::1]:8321", "192.168.1.7:8321",
                                       "rig.example:8321", "pc7"};
    static const char *const bad[] = {"evil.example:8321",
                                      "evil.example",
                                      "127.0.0.1.evil.example",
                                      "localhost.evil.example:80",
                                      "",
                                      ":80",
                                      "localhost:80:80",
                                      "[::1",
                                      "127.0.0.1:x",
                                      "rig.example.",
                                      "0x7f000001",
                                      "127.1"};
    (void)unused;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        if (!live_host_allowed(good[i], "rig.example", "pc7")) fail_msg("%s is refused", good[i]);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        if (live_host_allowed(bad[i], "rig.example", "pc7")) fail_msg("%s is allowed", bad[i]);
    assert_false(live_host_allowed(NULL, "rig.example", "pc7"));
    assert_false(live_host_allowed("", "rig.example", ""));
}

int main(void) {
#define OF(test) cmocka_unit_test_setup_teardown(test, start, end)
    const struct CMUnitTest tests[] = {
        OF(the_machine_is_described_by_its_configuration),
        OF(a_cycle_is_json_and_what_it_does_not_know_is_null),
        OF(another_machine_than_the_configured_one_is_noticed),
        OF(a_flood_of_cycles_is_thinned_and_bounded),
        OF(gaps_are_counted_as_lost),
        OF(a_new_start_is_noticed_and_clears_what_was_of_the_old_one),
        OF(a_fault_is_known_from_a_cycle_alone_until_one_has_none),
        OF(a_fault_is_known_from_its_events_alone),
        OF(texts_of_strangers_are_text),
        OF(no_message_is_counted_and_kept_out),
        OF(times_of_strangers_do_no_harm),
        OF(a_single_cylinder_has_one_of_everything),
        cmocka_unit_test(addresses_are_read_or_refused),
        cmocka_unit_test(hosts_that_a_stranger_could_name_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
