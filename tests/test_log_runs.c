/* One or several runs in a log: which events separate them, which do not, and which logs contain no
 * run. */
#include "support.h"

#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "log.h"
#include "log_runs.h"
#include "messages.h"

static char path[] = "/tmp/log_runs.XXXXXX";
static struct log_writer *log_;
static struct log_runs runs;
static struct error error;
static const int64_t PERIOD_NS = 2000000;

static int begin(void **unused) {
    (void)unused;
    unlink(path);
    return log_create(&log_, path, &error);
}

/* Writes cycle `seq`, received at a time (utime_us) of a clock that started began_s before the
 * daemon. */
static void cycle_at(uint64_t seq, double began_s) {
    unsigned char buffer[STATE_MESSAGE_MAX];
    struct cycle c = {.seq = seq, .in.time_ns = (int64_t)seq * PERIOD_NS, .test = -1, .dof = DOF_NONE};
    log_write(log_, (int64_t)(began_s * 1e6) + c.in.time_ns / 1000, CHANNEL_STATE, buffer, state_encode(&c, buffer), &error);
}

static void cycles(uint64_t first, uint64_t end, uint64_t step, double began_s) {
    for (uint64_t seq = first; seq < end; seq += step) cycle_at(seq, began_s);
}

static void event(const char *kind, const char *text) {
    unsigned char buffer[200];
    log_write(log_, 0, CHANNEL_EVENT, buffer, event_encode(0, 0, kind, text, buffer, sizeof buffer), &error);
}

static int found(void) {
    assert_int_equal(log_close(log_, &error), STATUS_OK);
    assert_int_equal(log_runs_find(path, &runs, &error), STATUS_OK);
    return runs.count;
}

/* Reads run `run` alone, and returns its number of cycles; -1 if it is refused. */
static int read_alone(int run) {
    struct log_reader *reader;
    struct log_event e;
    struct cycle c;
    int count = 0;
    if (log_open_run(&reader, path, run, &error)) return -1;
    while (log_next(reader, &e)) count += !strcmp(e.channel, CHANNEL_STATE) && state_decode(e.data, e.size, &c);
    log_release(reader);
    return count;
}

static void a_run_is_one_whatever_it_has_lost(void **unused) {
    (void)unused;
    event("config", "a");
    cycles(0, 500, 1, 0);
    cycles(700, 900, 1, 0);
    event("config", "a"), event("part", "2"); /* the log was joined with its next part */
    cycles(900, 1200, 1, 0);
    cycle_at(1199, 0); /* received twice */
    cycles(1200, 1300, 1, 0);
    assert_int_equal(found(), 1);
    assert_int_equal(read_alone(0), 1101);
    assert_int_equal(read_alone(1), 1101);
    assert_int_equal(read_alone(2), -1);
    assert_int_equal(error.status, STATUS_USAGE);
}

static void a_number_that_goes_back_begins_another_run(void **unused) {
    (void)unused;
    cycles(300, 1000, 10, 5.0); /* lcm-logger began to receive during the run */
    cycles(0, 2000, 10, 60.0);
    cycles(0, 100, 10, 90.0);
    assert_int_equal(found(), 3);
    assert_false(runs.mixed || runs.disordered || runs.configurations);
    assert_int_equal(read_alone(0), -1);
    assert_int_equal(error.status, STATUS_IO);
    assert_non_null(strstr(error.text, "is of 3 runs of the daemon; take one with --run N (1: 1.4 s; 2: 4.0 s; 3: 0.2 s)"));
    assert_int_equal(read_alone(1) + read_alone(2) + read_alone(3), 70 + 200 + 10);
    assert_int_equal(read_alone(2), 200);
}

static void so_does_another_configuration_and_it_belongs_to_its_run(void **unused) {
    (void)unused;
    struct log_reader *reader;
    struct log_event e;
    const char *text;
    size_t size;
    event("config", "a");
    cycles(0, 100, 1, 0);
    event("config", "b");
    cycles(200, 300, 1, 0); /* beyond the first */
    assert_int_equal(found(), 2);
    assert_true(runs.configurations && !runs.disordered);
    assert_int_equal(log_open_run(&reader, path, 2, &error), STATUS_OK);
    assert_int_equal(log_next(reader, &e), 1);
    assert_true(event_decode_config(e.data, e.size, &text, &size) && *text == 'b');
    log_release(reader);
}

static void a_run_whose_beginning_was_not_heard_has_another_clock(void **unused) {
    (void)unused;
    cycles(0, 500, 1, 0);
    cycles(3000, 4000, 1, 100.0);
    assert_int_equal(found(), 2);
    assert_int_equal(read_alone(2), 1000);
}

static void a_cycle_that_is_damaged_begins_nothing(void **unused) {
    (void)unused;
    cycles(0, 500, 1, 0);
    cycle_at(7, 0);
    cycles(501, 700, 1, 0);
    cycle_at(9000000, 0);
    cycles(701, 900, 1, 0);
    assert_int_equal(found(), 1);
    assert_false(runs.mixed);
    assert_int_equal(read_alone(0), 900);
}

static void a_sample_that_is_older_than_a_failed_read_begins_nothing(void **unused) {
    (void)unused;
    cycles(0, 2000, 1, 0);
    for (uint64_t seq = 2000; seq < 2020; seq++) { /* a failed read, and then two old samples, again
                                                    * and again */
        int64_t now_ns = (int64_t)seq * PERIOD_NS, age_ns = seq % 3 ? 3 * NS_PER_S : 0;
        struct cycle c = {.seq = seq, .in.time_ns = now_ns - age_ns, .in.age_ns = age_ns, .test = -1, .dof = DOF_NONE};
        unsigned char buffer[STATE_MESSAGE_MAX];
        log_write(log_, (int64_t)seq * PERIOD_NS / 1000, CHANNEL_STATE, buffer, state_encode(&c, buffer), &error);
    }
    assert_int_equal(found(), 1);
    assert_int_equal(read_alone(0), 2020);
}

static void two_machines_at_once_are_refused(void **unused) {
    (void)unused;
    for (int bursts = 1; bursts <= 8; bursts *= 2) {
        begin(NULL);
        for (uint64_t i = 0; i < 400; i += (uint64_t)bursts)
            cycles(i, i + (uint64_t)bursts, 1, 0), cycles(5000 + i, 5000 + i + (uint64_t)bursts, 1, 0);
        found();
        assert_true(runs.mixed);
        assert_int_equal(read_alone(0), -1);
        assert_int_equal(read_alone(1), -1);
        assert_non_null(strstr(error.text, "several daemons that ran at the same time"));
    }
}

static void parts_out_of_their_order_are_refused(void **unused) {
    (void)unused;
    event("config", "a"), event("part", "2"), cycles(500, 900, 1, 0);
    event("config", "a"), cycles(0, 500, 1, 0);
    assert_int_equal(found(), 2);
    assert_true(runs.disordered);
    begin(NULL);
    event("config", "a"), cycles(0, 500, 1, 0);
    event("config", "a"), event("part", "3"), cycles(900, 1200, 1, 0);
    event("config", "a"), event("part", "2"), cycles(500, 900, 1, 0);
    found();
    assert_true(runs.disordered);
    assert_int_equal(read_alone(1), -1);
    assert_non_null(strstr(error.text, "its parts are not in the order of their numbers"));
}

/* Writes `count` runs of 10 cycles, each with another configuration, as the recorder does when
 * gains are changed. */
static void sets(int count) {
    char text[32];
    for (int i = 0; i < count; i++) {
        snprintf(text, sizeof text, "kp: %d", i);
        event("config", text);
        cycles(10 * (uint64_t)i, 10 * (uint64_t)i + 10, 1, 0);
    }
}

static void forty_sets_of_gains_are_forty_runs(void **unused) {
    (void)unused;
    sets(40);
    assert_int_equal(found(), 40);
    assert_false(runs.mixed || runs.more || runs.disordered);
    for (int run = 1; run <= 40; run++) assert_int_equal(read_alone(run), 10);
    assert_int_equal(read_alone(0), -1);
    assert_non_null(strstr(error.text, "is of 40 runs of the daemon, with different configurations; take one with --run N (1: 0.0 s; 2: "));
    assert_non_null(strstr(error.text, "; ...)"));
}

static void so_are_forty_joined_runs_of_one_configuration(void **unused) {
    (void)unused;
    for (int i = 0; i < 40; i++) event("config", "a"), cycles(0, 100, 1, 60.0 * i);
    assert_int_equal(found(), 40);
    assert_false(runs.mixed);
    assert_int_equal(read_alone(40), 100);
}

static void of_too_many_runs_the_first_can_be_read(void **unused) {
    (void)unused;
    sets(LOG_RUNS_MAX + 3);
    assert_int_equal(found(), LOG_RUNS_MAX);
    assert_true(runs.more && !runs.mixed);
    assert_int_equal(read_alone(1), 10);
    assert_int_equal(read_alone(LOG_RUNS_MAX), 10); /* without the runs after it */
    assert_int_equal(read_alone(0), -1);
    assert_non_null(strstr(error.text, "is of more than 1024 runs of the daemon"));
    assert_null(strstr(error.text, "at the same time"));
}

static int make_file(void **unused) {
    (void)unused;
    int file = mkstemp(path);
    return file < 0 ? -1 : close(file);
}

static int remove_file(void **unused) {
    (void)unused;
    return unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_run_is_one_whatever_it_has_lost, begin),
        cmocka_unit_test_setup(a_number_that_goes_back_begins_another_run, begin),
        cmocka_unit_test_setup(so_does_another_configuration_and_it_belongs_to_its_run, begin),
        cmocka_unit_test_setup(a_run_whose_beginning_was_not_heard_has_another_clock, begin),
        cmocka_unit_test_setup(a_cycle_that_is_damaged_begins_nothing, begin),
        cmocka_unit_test_setup(a_sample_that_is_older_than_a_failed_read_begins_nothing, begin),
        cmocka_unit_test(two_machines_at_once_are_refused), /* this test begins each of its logs
                                                             * itself */
        cmocka_unit_test_setup(parts_out_of_their_order_are_refused, begin),
        cmocka_unit_test_setup(forty_sets_of_gains_are_forty_runs, begin),
        cmocka_unit_test_setup(so_are_forty_joined_runs_of_one_configuration, begin),
        cmocka_unit_test_setup(of_too_many_runs_the_first_can_be_read, begin),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
