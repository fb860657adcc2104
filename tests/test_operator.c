/* Operators' requests to a loop that reads them when the test lets it: a stop is never lost,
 * whatever comes with it, and an operator who leaves never leaves a moving machine behind. */
#include "support.h"

#include "config.h"
#include "gains.h"
#include "operator.h"
#include "units.h"

enum { A = 1, B = 2, C = 3, ANSWERS = 256 };

static struct loop loop;
static struct params params;
static struct operator operator;
static int said, answers;
static char last_said[600];
static struct {
    uint64_t peer;
    struct command_answer a;
} answered[ANSWERS];

static void say(void *context, const char *text) {
    (void)context;
    said++;
    snprintf(last_said, sizeof last_said, "%s", text);
}
static void take_answer(void *context, uint64_t peer, const struct command_answer *a) {
    (void)context;
    answered[answers % ANSWERS].peer = peer;
    answered[answers++ % ANSWERS].a = *a;
}

/* Reports that the loop has acted on every request and is in this state. */
static void loop_acts(enum state state, bool taken) {
    struct loop_acted acted = {.request_id = mailbox_read(&loop.requests).id, .state = state, .taken = taken};
    atomic_store(&loop.acted, loop_acted_word(&acted));
}

static void ask_as(uint64_t peer, bool may_move, enum command command, int64_t now_ns) {
    struct command_request r = {.id = 7, .command = command, .renew = command == COMMAND_NONE};
    operator_take(&operator, peer, &r, may_move, now_ns);
}
static void ask(uint64_t peer, enum command command, int64_t now_ns) { ask_as(peer, true, command, now_ns); }

static enum command asked(void) { return mailbox_read(&loop.requests).command; }
static uint32_t posted(void) { return mailbox_read(&loop.requests).id; }

/* Asserts that the last answer went to this peer with this outcome. */
static void expect(uint64_t peer, enum outcome outcome) {
    assert_true(answers > 0);
    assert_int_equal(answered[(answers - 1) % ANSWERS].peer, peer);
    assert_int_equal(answered[(answers - 1) % ANSWERS].a.outcome, outcome);
    assert_int_equal(answered[(answers - 1) % ANSWERS].a.id, 7);
}

static void begin(enum state state) {
    memset(&loop, 0, sizeof loop);
    config_default(&params);
    params.lcm.commands = true;
    loop_acts(state, false);
    operator_init(&operator, &params, &loop, &(struct operator_ports){.answer = take_answer, .say = say});
    said = answers = 0;
}

/* Sets up this state with client A holding the lease for the command that leads to it. */
static void lease(enum command command, enum state state) {
    begin(command == COMMAND_ENGAGE ? STATE_SETTLED : STATE_READY);
    ask(A, command, 1);
    loop_acts(state, true);
    operator_tick(&operator, 2);
    expect(A, OUTCOME_DONE);
}

static void a_move_does_not_take_the_place_of_a_stop(void **unused) {
    (void)unused;
    static const enum command stops[] = {COMMAND_STOP, COMMAND_PARK};
    for (int i = 0; i < 2; i++) {
        begin(STATE_READY);
        ask(A, stops[i], 2);
        ask(B, COMMAND_START, 3);
        expect(B, OUTCOME_REFUSED);
        operator_tick(&operator, 2 * NS_PER_S); /* the loop stalls, however long */
        ask(B, COMMAND_START, 2 * NS_PER_S);
        assert_int_equal(asked(), stops[i]);
        loop_acts(STATE_PARKING, true);
        operator_tick(&operator, 4);
        expect(A, OUTCOME_DONE);
    }
}

static void a_stop_does_not_undo_a_park_and_takes_the_place_of_a_move(void **unused) {
    (void)unused;
    begin(STATE_TESTING);
    ask(A, COMMAND_PARK, 1);
    ask_as(0, false, COMMAND_STOP, 2);
    assert_int_equal(asked(), COMMAND_PARK);
    begin(STATE_READY);
    ask(A, COMMAND_START, 1);
    ask(B, COMMAND_STOP, 2);
    assert_int_equal(asked(), COMMAND_STOP);
    operator_tick(&operator, 3);
    expect(A, OUTCOME_REFUSED);
}

static void a_move_does_not_take_the_place_of_another_operators(void **unused) {
    (void)unused;
    begin(STATE_READY);
    ask(A, COMMAND_START, 1);
    uint32_t first = posted();
    ask(B, COMMAND_ENGAGE, 2);
    expect(B, OUTCOME_REFUSED);
    assert_int_equal(posted(), first);
    assert_int_equal(asked(), COMMAND_START);
    loop_acts(STATE_TESTING, true);
    operator_tick(&operator, 3);
    expect(A, OUTCOME_DONE);
}

/* While the loop parks because nobody takes stops, a stop is still taken. */
static void nothing_moves_where_stops_were_not_taken(void **unused) {
    (void)unused;
    begin(STATE_SETTLED);
    atomic_store(&loop.unattended, true);
    ask(A, COMMAND_ENGAGE, 0);
    expect(A, OUTCOME_REFUSED);
    assert_non_null(strstr(answered[(answers - 1) % ANSWERS].a.text, "stops could not be taken for a while"));
    assert_int_equal(posted(), 0);
    ask(A, COMMAND_STOP, 0);
    assert_int_equal(asked(), COMMAND_STOP);
    atomic_store(&loop.unattended, false);
}

static void stops_of_many_at_once_are_all_done(void **unused) {
    (void)unused;
    begin(STATE_TESTING);
    for (uint64_t peer = 1; peer <= OPERATOR_STOPS; peer++) ask_as(peer, false, COMMAND_STOP, 1);
    /* a flooding client takes no other client's place */
    for (int n = 0; n < 1000; n++) ask_as(5, false, COMMAND_STOP, 2);
    operator_tick(&operator, 3);
    assert_int_equal(answers, 0);
    loop_acts(STATE_TESTING, true);
    operator_tick(&operator, 4);
    assert_int_equal(answers, OPERATOR_STOPS);
    for (int i = 0; i < answers; i++) assert_int_equal(answered[i].a.outcome, OUTCOME_DONE);
    assert_false(operator_waits(&operator));
}

static void what_moves_comes_from_who_may_move_it_alone(void **unused) {
    (void)unused;
    static const enum command moves[] = {COMMAND_ENGAGE, COMMAND_START, COMMAND_RESET};
    for (int i = 0; i < 3; i++) {
        begin(STATE_SETTLED);
        ask_as(A, false, moves[i], 1);
        expect(A, OUTCOME_REFUSED);
        ask_as(0, true, moves[i], 2); /* LCM */
        params.lcm.commands = false;
        ask(A, moves[i], 3);
        expect(A, OUTCOME_REFUSED);
        assert_int_equal(posted(), 0);
        ask_as(A, false, COMMAND_PARK, 4);
        assert_int_equal(asked(), COMMAND_PARK);
    }
}

/* Somebody without the right sends ten thousand requests per second. Each is refused with an
 * answer, and the terminal shows five per second and their number. */
static void refusals_are_answered_and_do_not_flood_the_terminal(void **unused) {
    (void)unused;
    begin(STATE_READY);
    for (int n = 0; n < 10000; n++) ask_as(B, false, COMMAND_ENGAGE, 1 + n * (NS_PER_S / 10000));
    assert_int_equal(answers, 10000);
    assert_in_range(said, 1, 6);
    ask_as(B, false, COMMAND_ENGAGE, 2 * NS_PER_S);
    assert_non_null(strstr(last_said, "commands before it"));
    ask_as(B, false, COMMAND_ENGAGE, 4 * NS_PER_S);
    assert_null(strstr(last_said, "before it"));
}

static struct gain_change change_of(double kp) {
    struct gain_change c = {.digest = config_digest(&params), .from = gains_of(&params.control), .to = gains_of(&params.control)};
    c.to.value[GAIN_KP] = kp;
    return c;
}

static void set_as(uint64_t peer, const struct gain_change *c, int64_t now_ns) {
    operator_take(&operator, peer, &(struct command_request){.id = 7, .command = COMMAND_SET, .sets = true, .change = *c}, true, now_ns);
}

/* The loop's gains are those that it drives with; the test acts as the loop. */
static void begin_with_gains(enum state state) {
    begin(state);
    struct gains gains = gains_of(&params.control);
    gains_box_put(&loop.present, &gains);
}

static const char *answered_text(void) { return answered[(answers - 1) % ANSWERS].a.text; }

static void gains_are_told_and_set(void **unused) {
    (void)unused;
    begin_with_gains(STATE_READY);
    ask(A, COMMAND_SET, 1); /* a question: nothing is posted */
    expect(A, OUTCOME_DONE);
    assert_string_equal(answered_text(), "sim control.kp=40 control.ki=20 control.kd=0 control.kff=2 control.kpf=2e-05");
    assert_int_equal(posted(), 0);
    struct gain_change c = change_of(45.0);
    struct gains asked_for;
    set_as(A, &c, 2);
    assert_int_equal(asked(), COMMAND_SET);
    assert_true(gains_box_get(&loop.gains, &asked_for) && asked_for.value[GAIN_KP] == 45.0);
    gains_box_put(&loop.present, &c.to);
    loop_acts(STATE_READY, true);
    operator_tick(&operator, 3);
    expect(A, OUTCOME_DONE);
    assert_non_null(strstr(answered_text(), "control.kp=45 "));
    assert_true(answered[(answers - 1) % ANSWERS].a.lease_s == 0.0);
}

/* A set is not posted if its client computed another loop, or if it changes a gain by too much. */
static void gains_of_another_loop_or_too_far_away_are_refused(void **unused) {
    (void)unused;
    static const char *const why[] = {"configuration is not this machine's", "changed in between", "factor of 1.4", "factor of 1.4",
                                      "from 0"};
    for (int i = 0; i < 5; i++) {
        begin_with_gains(STATE_READY);
        struct gain_change c = change_of(45.0);
        if (i == 0) c.digest++;
        if (i == 1) c.from.value[GAIN_KPF] *= 1.1;
        if (i == 2) c.to.value[GAIN_KP] = 57.0;
        if (i == 3) c.to.value[GAIN_KP] = (double)NAN;
        if (i == 4) c.to.value[GAIN_KD] = 0.01;
        set_as(A, &c, 1);
        expect(A, OUTCOME_REFUSED);
        if (!strstr(answered_text(), why[i])) fail_msg("%d: %s", i, answered_text());
        assert_int_equal(posted(), 0);
    }
}

/* SAFETY: a set never takes the place of a stop, and one that the loop does not see is taken back
 * without a stop, which could end another operator's motion. */
static void a_stop_comes_before_gains(void **unused) {
    (void)unused;
    begin_with_gains(STATE_READY);
    struct gain_change c = change_of(45.0);
    ask(A, COMMAND_PARK, 1);
    set_as(B, &c, 2);
    expect(B, OUTCOME_REFUSED);
    assert_int_equal(asked(), COMMAND_PARK);
    begin_with_gains(STATE_READY);
    set_as(A, &c, 1);
    ask(B, COMMAND_STOP, 2);
    assert_int_equal(asked(), COMMAND_STOP);
    loop_acts(STATE_READY, true);
    operator_tick(&operator, 3);
    expect(B, OUTCOME_DONE);
    assert_true(answered[(answers - 2) % ANSWERS].peer == A && answered[(answers - 2) % ANSWERS].a.outcome == OUTCOME_REFUSED);
    begin_with_gains(STATE_READY);
    set_as(A, &c, 1);
    operator_tick(&operator, NS_PER_S); /* the loop stands still */
    expect(A, OUTCOME_REFUSED);
    assert_int_equal(asked(), COMMAND_NONE);
}

/* The loop had read the set when the stop came: the gains are changed, and that is what is said. */
static void gains_that_were_changed_are_told_whatever_came_behind(void **unused) {
    (void)unused;
    begin_with_gains(STATE_READY);
    struct gain_change c = change_of(45.0);
    set_as(A, &c, 1);
    ask(B, COMMAND_STOP, 2);
    gains_box_put(&loop.present, &c.to);
    loop_acts(STATE_READY, true);
    operator_tick(&operator, 3);
    bool told = false;
    for (int i = 0; i < 2; i++) told = told || strstr(answered[(answers - 1 - i) % ANSWERS].a.text, "control.kp=45 ");
    assert_true(told);
}

/* In motion nothing enters the mailbox, so that nothing has to be taken back from it. */
static void gains_are_not_asked_of_a_loop_in_motion(void **unused) {
    (void)unused;
    static const enum state moving[] = {STATE_INIT, STATE_PRESSURISING, STATE_ENGAGING, STATE_TESTING, STATE_PARKING, STATE_FAULT};
    for (unsigned i = 0; i < sizeof moving / sizeof *moving; i++) {
        begin_with_gains(moving[i]);
        struct gain_change c = change_of(45.0);
        set_as(A, &c, 1);
        expect(A, OUTCOME_REFUSED);
        assert_int_equal(posted(), 0);
    }
}

static void a_lease_that_ran_out_parks_until_the_loop_has_seen_it(void **unused) {
    (void)unused;
    lease(COMMAND_ENGAGE, STATE_PRESSURISING);
    int64_t lease_ns = ns_from_seconds(params.lcm.lease_s);
    ask(A, COMMAND_NONE, lease_ns); /* renewed */
    expect(A, OUTCOME_DONE);
    loop_acts(STATE_READY, true);
    operator_tick(&operator, 2 * lease_ns - 1);
    assert_int_equal(asked(), COMMAND_ENGAGE);
    ask(B, COMMAND_NONE, 2 * lease_ns - 1); /* another client's renewal does not count */
    expect(B, OUTCOME_REFUSED);
    operator_tick(&operator, 2 * lease_ns + 1);
    assert_int_equal(asked(), COMMAND_PARK);
    mailbox_post(&loop.requests, COMMAND_STOP); /* a stop replaces the park in the mailbox */
    operator_tick(&operator, 2 * lease_ns + 2);
    assert_int_equal(asked(), COMMAND_PARK);
    ask(A, COMMAND_NONE, 2 * lease_ns + 2); /* too late */
    expect(A, OUTCOME_REFUSED);
    assert_int_equal(said, 1);
    loop_acts(STATE_PARKING, true);
    uint32_t id = posted();
    operator_tick(&operator, 2 * lease_ns + 3);
    loop_acts(STATE_SETTLED, true);
    operator_tick(&operator, 2 * lease_ns + 4);
    assert_int_equal(posted(), id);
}

static void the_end_of_a_connection_that_holds_a_lease_parks(void **unused) {
    (void)unused;
    lease(COMMAND_START, STATE_TESTING);
    assert_true(operator_needs(&operator, A));
    operator_gone(&operator, B, 3);
    assert_int_equal(asked(), COMMAND_START);
    operator_gone(&operator, A, 4);
    assert_int_equal(asked(), COMMAND_PARK);
    mailbox_post(&loop.requests, COMMAND_STOP);
    operator_tick(&operator, 5); /* the park is posted again until the loop has seen it */
    assert_int_equal(asked(), COMMAND_PARK);
}

static void each_who_set_it_in_motion_answers_for_it(void **unused) {
    (void)unused;
    for (uint64_t who = A; who <= B; who++) {
        lease(COMMAND_ENGAGE, STATE_READY);
        ask(B, COMMAND_START, 3);
        loop_acts(STATE_TESTING, true);
        operator_tick(&operator, 4);
        operator_gone(&operator, who, 5);
        assert_int_equal(asked(), COMMAND_PARK);
    }
}

static void a_lease_ends_with_what_it_was_for(void **unused) {
    (void)unused;
    lease(COMMAND_START, STATE_TESTING);
    loop_acts(STATE_READY, true);
    operator_tick(&operator, 3);
    ask(A, COMMAND_NONE, 4); /* informed, not refused */
    expect(A, OUTCOME_DONE);
    operator_gone(&operator, A, 5);
    operator_tick(&operator, 2 * ns_from_seconds(params.lcm.lease_s));
    assert_int_equal(asked(), COMMAND_START);
    lease(COMMAND_ENGAGE, STATE_READY);
    loop_acts(STATE_FAULT, true);
    operator_tick(&operator, 3);
    operator_gone(&operator, A, 4);
    assert_int_equal(asked(), COMMAND_ENGAGE);
}

static void who_engaged_and_starts_the_tests_still_answers_for_the_platform(void **unused) {
    (void)unused;
    lease(COMMAND_ENGAGE, STATE_READY);
    ask(A, COMMAND_START, 3);
    loop_acts(STATE_TESTING, true);
    operator_tick(&operator, 4);
    loop_acts(STATE_READY, true);
    operator_tick(&operator, 5);
    operator_gone(&operator, A, 6);
    assert_int_equal(asked(), COMMAND_PARK);
}

static void a_request_whose_client_went_away_is_taken_back(void **unused) {
    (void)unused;
    static const struct {
        enum command command, instead;
        enum state state;
    } moves[] = {{COMMAND_ENGAGE, COMMAND_PARK, STATE_SETTLED}, {COMMAND_START, COMMAND_STOP, STATE_READY}};
    for (int i = 0; i < 2; i++) {
        begin(moves[i].state);
        ask(A, moves[i].command, 1);
        operator_gone(&operator, A, 2); /* the client leaves before the loop has read its request */
        assert_int_equal(asked(), moves[i].instead);
        ask(B, COMMAND_START, 3); /* no command that moves may replace the stop or park */
        assert_int_equal(asked(), moves[i].instead);
        begin(moves[i].state);
        ask(A, moves[i].command, 1);
        loop_acts(moves[i].command == COMMAND_ENGAGE ? STATE_PRESSURISING : STATE_TESTING, true);
        operator_gone(&operator, A, 2); /* the client leaves after the loop has acted */
        assert_int_equal(asked(), COMMAND_PARK);
    }
}

static void a_request_that_a_stalled_loop_has_not_seen_is_taken_back(void **unused) {
    (void)unused;
    begin(STATE_SETTLED);
    ask(A, COMMAND_ENGAGE, 1);
    operator_tick(&operator, NS_PER_S / 4);
    assert_int_equal(asked(), COMMAND_ENGAGE);
    operator_tick(&operator, NS_PER_S);
    expect(A, OUTCOME_REFUSED);
    assert_int_equal(asked(), COMMAND_PARK);
    ask(B, COMMAND_ENGAGE, NS_PER_S);
    assert_int_equal(asked(), COMMAND_PARK);
}

static void leases_are_bounded(void **unused) {
    (void)unused;
    begin(STATE_READY);
    for (uint64_t peer = 1; peer <= OPERATOR_LEASES; peer++) {
        ask(peer, COMMAND_START, 1);
        loop_acts(STATE_TESTING, true);
        operator_tick(&operator, 2);
        expect(peer, OUTCOME_DONE);
    }
    ask(99, COMMAND_START, 3);
    expect(99, OUTCOME_REFUSED);
    loop_acts(STATE_READY, true); /* all are over */
    operator_tick(&operator, 4);
    ask(99, COMMAND_START, 5);
    loop_acts(STATE_TESTING, true);
    operator_tick(&operator, 6);
    expect(99, OUTCOME_DONE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_move_does_not_take_the_place_of_a_stop),
        cmocka_unit_test(a_stop_does_not_undo_a_park_and_takes_the_place_of_a_move),
        cmocka_unit_test(a_move_does_not_take_the_place_of_another_operators),
        cmocka_unit_test(nothing_moves_where_stops_were_not_taken),
        cmocka_unit_test(stops_of_many_at_once_are_all_done),
        cmocka_unit_test(what_moves_comes_from_who_may_move_it_alone),
        cmocka_unit_test(refusals_are_answered_and_do_not_flood_the_terminal),
        cmocka_unit_test(gains_are_told_and_set),
        cmocka_unit_test(gains_of_another_loop_or_too_far_away_are_refused),
        cmocka_unit_test(a_stop_comes_before_gains),
        cmocka_unit_test(gains_that_were_changed_are_told_whatever_came_behind),
        cmocka_unit_test(gains_are_not_asked_of_a_loop_in_motion),
        cmocka_unit_test(a_lease_that_ran_out_parks_until_the_loop_has_seen_it),
        cmocka_unit_test(the_end_of_a_connection_that_holds_a_lease_parks),
        cmocka_unit_test(each_who_set_it_in_motion_answers_for_it),
        cmocka_unit_test(a_lease_ends_with_what_it_was_for),
        cmocka_unit_test(who_engaged_and_starts_the_tests_still_answers_for_the_platform),
        cmocka_unit_test(a_request_whose_client_went_away_is_taken_back),
        cmocka_unit_test(a_request_that_a_stalled_loop_has_not_seen_is_taken_back),
        cmocka_unit_test(leases_are_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
