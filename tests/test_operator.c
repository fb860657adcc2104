/* Requests of operators against a loop that has not come to look at them yet: a stop is not lost,
 * whatever comes with it. In a network of its own. */
#include "support.h"

#include <sched.h>
#include <stdlib.h>
#include <unistd.h>

#include "operator.h"
#include "units.h"

static struct loop loop;
static struct params params;
static struct bus *bus;
static struct operator operator;
static int said;

static void say(void *context, const char *text) {
    (void)context, (void)text;
    said++;
}

static bool connect_bus(void) {
    struct error error;
    if (unshare(CLONE_NEWNET) && unshare(CLONE_NEWUSER | CLONE_NEWNET)) return false;
    if (system("ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo 2>/dev/null")) return false;
    return bus_open(&bus, "udpm://", &error) == STATUS_OK;
}

/* The loop has acted on all that was asked, and is in this state. */
static void loop_acts(enum state state, bool taken) {
    struct loop_acted acted = {.request_id = mailbox_read(&loop.requests).id, .state = state, .taken = taken};
    atomic_store(&loop.acted, loop_acted_word(&acted));
}

static void ask(enum command command, int64_t token, int64_t now_ns) {
    unsigned char buffer[COMMAND_MESSAGE_MAX];
    struct operator_request r = {.id = 7, .token = token, .command = command, .renew = command == COMMAND_NONE};
    struct bus_message m = {.channel = CHANNEL_COMMAND, .data = buffer, .size = request_encode(&r, buffer)};
    operator_take(&operator, &m, now_ns);
}

static enum command asked(void) { return mailbox_read(&loop.requests).command; }

static void begin(enum state state) {
    if (!bus) skip_because("this system allows no network namespace");
    memset(&loop, 0, sizeof loop);
    config_default(&params);
    params.lcm.commands = true;
    loop_acts(state, false);
    operator_init(&operator, &params, &loop, bus, say, NULL);
    said = 0;
}

static int64_t token_at(int64_t now_ns) {
    ask(COMMAND_START, 0, now_ns);
    assert_int_equal(asked(), COMMAND_NONE); /* a token is no permission yet */
    assert_true(operator.token != 0);
    return operator.token;
}

static void a_move_does_not_take_the_place_of_a_stop(void **unused) {
    (void)unused;
    static const enum command stops[] = {COMMAND_STOP, COMMAND_PARK};
    for (int i = 0; i < 2; i++) {
        begin(STATE_READY);
        int64_t token = token_at(1);
        ask(stops[i], 0, 2);
        ask(COMMAND_START, token, 3);
        assert_int_equal(asked(), stops[i]);
        operator_tick(&operator, 2 * NS_PER_S); /* the loop stalls, for however long */
        ask(COMMAND_START, 0, 2 * NS_PER_S);
        ask(COMMAND_START, operator.token, 2 * NS_PER_S + 1);
        assert_int_equal(asked(), stops[i]);
        loop_acts(STATE_PARKING, true);
        operator_tick(&operator, 4);
    }
}

static void a_stop_does_not_undo_a_park(void **unused) {
    (void)unused;
    begin(STATE_TESTING);
    ask(COMMAND_PARK, 0, 1);
    ask(COMMAND_STOP, 0, 2);
    assert_int_equal(asked(), COMMAND_PARK);
}

static void a_token_is_good_once_and_for_a_second(void **unused) {
    (void)unused;
    begin(STATE_READY);
    ask(COMMAND_START, 12345, 1);
    assert_int_equal(asked(), COMMAND_NONE);
    ask(COMMAND_START, operator.token, 1 + NS_PER_S + 1);
    assert_int_equal(asked(), COMMAND_NONE); /* too late */
    int64_t token = operator.token;
    ask(COMMAND_START, token, 2 * NS_PER_S);
    assert_int_equal(asked(), COMMAND_START);
    loop_acts(STATE_TESTING, true);
    operator_tick(&operator, 2 * NS_PER_S + 1);
    uint32_t id = mailbox_read(&loop.requests).id;
    ask(COMMAND_START, token, 2 * NS_PER_S + 2);
    assert_int_equal(mailbox_read(&loop.requests).id, id); /* used */
}

static void a_lease_that_ran_out_parks_until_the_loop_has_seen_it(void **unused) {
    (void)unused;
    begin(STATE_READY);
    ask(COMMAND_START, token_at(1), 2);
    loop_acts(STATE_TESTING, true);
    operator_tick(&operator, 3);
    int64_t lease = operator.lease, lease_ns = ns_from_seconds(params.lcm.lease_s);
    assert_true(lease != 0);
    ask(COMMAND_NONE, lease, lease_ns); /* renewed */
    operator_tick(&operator, 2 * lease_ns - 1);
    assert_int_equal(asked(), COMMAND_START);
    ask(COMMAND_NONE, lease + 1, 2 * lease_ns - 1); /* another's token renews nothing */
    operator_tick(&operator, 2 * lease_ns + 1);
    assert_int_equal(asked(), COMMAND_PARK);
    mailbox_post(&loop.requests, COMMAND_STOP); /* whatever takes its place */
    operator_tick(&operator, 2 * lease_ns + 2);
    assert_int_equal(asked(), COMMAND_PARK);
    assert_int_equal(said, 1);
    loop_acts(STATE_PARKING, true);
    uint32_t id = mailbox_read(&loop.requests).id;
    operator_tick(&operator, 2 * lease_ns + 3);
    loop_acts(STATE_SETTLED, true);
    operator_tick(&operator, 2 * lease_ns + 4);
    assert_int_equal(mailbox_read(&loop.requests).id, id);
    assert_true(operator.lease == 0);
}

static void without_lcm_commands_nothing_moves_and_stops_stop(void **unused) {
    (void)unused;
    begin(STATE_READY);
    params.lcm.commands = false;
    ask(COMMAND_START, 0, 1);
    assert_true(operator.token == 0 && asked() == COMMAND_NONE && said == 1);
    ask(COMMAND_PARK, 0, 2);
    assert_int_equal(asked(), COMMAND_PARK);
}

int main(void) {
    connect_bus();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_move_does_not_take_the_place_of_a_stop),
        cmocka_unit_test(a_stop_does_not_undo_a_park),
        cmocka_unit_test(a_token_is_good_once_and_for_a_second),
        cmocka_unit_test(a_lease_that_ran_out_parks_until_the_loop_has_seen_it),
        cmocka_unit_test(without_lcm_commands_nothing_moves_and_stops_stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
