/* The recorder's log when gains are changed, when it cannot hold the configuration, and when the
 * platform parks or an automatic run ends for no command. */
#include "support.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "gains.h"
#include "hal.h"
#include "log_directory.h"
#include "messages.h"
#include "recorder.h"

enum { CYCLES = 16, TOO_LONG = 1 << 18 };

static char directory[] = "/tmp/recorder.XXXXXX";
static char first[PATH_MAX];
static const struct hal_ops no_ops;
static struct hal hal = {.ops = &no_ops};
static struct params params;
static struct loop loop;
static struct ring records;
static struct log_keeper keeper;
static struct progress progress;
static struct recorder recorder;
static struct error error;
static char *config;
static uint64_t seq;

static int begin(void **unused) {
    (void)unused;
    char command[PATH_MAX];
    params = brisk();
    seq = 0;
    loop = (struct loop){.params = &params, .hal = &hal, .clock.kind = CLOCK_VIRTUAL};
    snprintf(command, sizeof command, "rm -rf %s && mkdir %s", directory, directory);
    if (system(command) || log_directory_create(directory, true, first, sizeof first, &error)) return -1;
    config = config_text(&params);
    recorder = (struct recorder){
        .params = &params, .loop = &loop, .records = &records, .progress = &progress, .loop_says = "", .notify.socket = -1};
    return !config || ring_init(&records, sizeof(struct cycle), CYCLES) || log_create(&recorder.log, first, &error) ||
           progress_open(&progress, &params, open("/dev/null", O_WRONLY), true);
}

static int end(void **unused) {
    (void)unused;
    log_close(recorder.log, &error);
    progress_close(&progress);
    analysis_free(&recorder.analysis);
    free(recorder.changed);
    free(config);
    ring_free(&records);
    return 0;
}

/* Gives the recorder a cycle driven with this kp. */
static void drive(double kp, uint32_t fault) {
    struct cycle c = {.seq = seq, .in.time_ns = (int64_t)seq * 2000000, .test = -1, .dof = DOF_NONE, .first_fault = fault, .faults = fault};
    c.gains = gains_of(&params.control);
    c.gains.value[GAIN_KP] = kp;
    c.measure.leg = -1;
    seq++;
    assert_true(ring_push(&records, &c));
}

static void run(void) {
    assert_int_equal(recorder_start(&recorder, config, &error), STATUS_OK);
    atomic_store(&loop.ended, true);
    assert_true(recorder_join(&recorder));
    assert_int_equal(recorder.error.status, STATUS_OK);
    assert_int_equal(log_flush(recorder.log, &error), STATUS_OK);
}

/* Copies the text of the log's first event of this kind; "": there is none. */
static void read_event(const char *kind, char *text, size_t size) {
    struct log_reader *log;
    struct log_event e;
    struct event event;
    *text = '\0';
    assert_int_equal(log_open(&log, first, &error), STATUS_OK);
    while (!*text && log_next(log, &e))
        if (!strcmp(e.channel, CHANNEL_EVENT) && event_decode(e.data, e.size, &event) && !strcmp(event.kind, kind))
            snprintf(text, size, "%s", event.text);
    log_release(log);
}

static void a_configuration_that_does_not_fit_is_a_failure_of_the_log(void **unused) {
    (void)unused;
    char *longer = malloc(TOO_LONG + 1);
    assert_non_null(longer);
    memset(longer, '#', TOO_LONG);
    longer[TOO_LONG] = '\0';
    assert_int_equal(recorder_start(&recorder, longer, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "the log cannot keep the configuration: 262144 bytes"));
    assert_true(atomic_load(&loop.quit));
    free(longer);
}

static void without_a_log_it_does_not_matter(void **unused) {
    (void)unused;
    char *longer = malloc(TOO_LONG + 1);
    assert_non_null(longer);
    memset(longer, '#', TOO_LONG);
    longer[TOO_LONG] = '\0';
    struct log_writer *log = recorder.log;
    recorder.log = NULL;
    atomic_store(&loop.ended, true);
    assert_int_equal(recorder_start(&recorder, longer, &error), STATUS_OK);
    assert_true(recorder_join(&recorder));
    recorder.log = log;
    free(longer);
}

static void a_fault_after_a_change_says_to_set_the_gains_back(void **unused) {
    (void)unused;
    char text[FAILURE_TEXT_SIZE];
    recorder.loop_says = "kp 30";
    drive(40, 0), drive(45, 0), drive(50, 0), drive(50, FAULT_FOLLOWING);
    run();
    read_event("remedy", text, sizeof text);
    assert_non_null(strstr(text, "; the gains: changed to control.kp=50, was 40: set them back"));
    read_event("cause", text, sizeof text);
    assert_non_null(strstr(text, "; or the gains, which were changed"));
}

static void a_fault_after_they_were_set_back_says_what_it_said_before(void **unused) {
    (void)unused;
    char text[FAILURE_TEXT_SIZE];
    recorder.loop_says = "kp 30";
    drive(40, 0), drive(45, 0), drive(40, FAULT_FOLLOWING);
    run();
    read_event("remedy", text, sizeof text);
    assert_non_null(strstr(text, "; the gains: kp 30"));
}

static void drive_in(enum state state, bool unattended, uint32_t opened) {
    struct cycle c = {.seq = seq, .in.time_ns = (int64_t)seq * 2000000, .test = -1, .dof = DOF_NONE, .state = state};
    c.gains = gains_of(&params.control);
    c.measure.leg = -1, c.unattended = unattended, c.opened = opened;
    seq++;
    assert_true(ring_push(&records, &c));
}

/* The recorder reports from the records, whatever the loop does meanwhile, that nobody took stops;
 * the run ends with that error only if the platform was up. */
static void that_nobody_took_stops_is_said(enum state before, enum state then, int status) {
    char text[sizeof error.text];
    drive_in(before, false, 0), drive_in(then, true, 0), drive_in(then, true, 0);
    run();
    read_event("unattended", text, sizeof text);
    assert_non_null(strstr(text, "at 0.0 s stops could not be taken for 1 s"));
    assert_int_equal(recorder.unattended.status, status);
}

static void the_run_ends_with_stops_that_were_not_taken(void **unused) {
    (void)unused;
    that_nobody_took_stops_is_said(STATE_READY, STATE_PARKING, STATUS_IO);
}

static void nothing_was_up_when_nobody_took_stops(void **unused) {
    (void)unused;
    that_nobody_took_stops_is_said(STATE_SETTLED, STATE_SETTLED, STATUS_OK);
}

static void an_input_that_ends_an_automatic_run_is_named(void **unused) {
    (void)unused;
    char text[400];
    drive_in(STATE_INIT, false, 0), drive_in(STATE_INIT, false, INPUT_DOOR), drive_in(STATE_SETTLED, false, INPUT_DOOR);
    run();
    read_event("interlock", text, sizeof text);
    assert_non_null(strstr(text, "the automatic run is over: the door is open"));
}

/* Copies the log's events of this kind, at most `most`; returns their number. */
static int read_stamps(const char *kind, uint64_t *stamp, char (*text)[16], int most) {
    struct log_reader *log;
    struct log_event e;
    struct event event;
    int count = 0;
    assert_int_equal(log_open(&log, first, &error), STATUS_OK);
    while (count < most && log_next(log, &e))
        if (!strcmp(e.channel, CHANNEL_EVENT) && event_decode(e.data, e.size, &event) && !strcmp(event.kind, kind)) {
            assert_int_equal(event.time_ns, (int64_t)event.seq * 2000000);
            stamp[count] = event.seq;
            snprintf(text[count++], sizeof *text, "%s", event.text);
        }
    log_release(log);
    return count;
}

/* The records wait in the ring, and the newest request is one that the loop has not seen yet. */
static void a_command_has_the_stamp_of_the_cycle_that_took_it(void **unused) {
    (void)unused;
    static const struct {
        uint32_t id;
        enum command command;
    } taken[] = {{0, COMMAND_NONE}, {0, COMMAND_NONE}, {1, COMMAND_ENGAGE}, {1, COMMAND_ENGAGE}, {3, COMMAND_PARK}, {3, COMMAND_PARK}};
    uint64_t stamp[4];
    char text[4][16];
    for (size_t i = 0; i < sizeof taken / sizeof *taken; i++) {
        struct cycle c = {.seq = seq, .in.time_ns = (int64_t)seq * 2000000, .test = -1, .dof = DOF_NONE, .measure.leg = -1};
        c.gains = gains_of(&params.control);
        c.request_id = taken[i].id, c.request = taken[i].command;
        seq++;
        assert_true(ring_push(&records, &c));
    }
    for (int i = 0; i < 4; i++) mailbox_post(&loop.requests, COMMAND_STOP);
    run();
    assert_int_equal(read_stamps("command", stamp, text, 4), 2);
    assert_int_equal(stamp[0], 2);
    assert_string_equal(text[0], "engage");
    assert_int_equal(stamp[1], 4);
    assert_string_equal(text[1], "park");
}

/* With parts of a byte every cycle but that of a change begins a part. */
static void the_cycle_of_a_change_begins_no_part(void **unused) {
    (void)unused;
    assert_int_equal(log_keeper_start(&keeper, first, 0, &error), STATUS_OK);
    recorder.keeper = &keeper, recorder.part_bytes = 1;
    drive(40, 0), drive(45, 0), drive(45, 0);
    run();
    assert_int_equal(recorder.part, 3);
    assert_int_equal(recorder.keeper_error.status, STATUS_OK);
    log_keeper_stop(&keeper);
    while (waitpid(-1, NULL, 0) > 0) continue;
}

static int make_directory(void **unused) {
    (void)unused;
    return mkdtemp(directory) ? 0 : -1;
}

static int remove_directory(void **unused) {
    (void)unused;
    char command[PATH_MAX];
    snprintf(command, sizeof command, "rm -rf %s", directory);
    return system(command);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_configuration_that_does_not_fit_is_a_failure_of_the_log, begin, end),
        cmocka_unit_test_setup_teardown(without_a_log_it_does_not_matter, begin, end),
        cmocka_unit_test_setup_teardown(a_fault_after_a_change_says_to_set_the_gains_back, begin, end),
        cmocka_unit_test_setup_teardown(a_fault_after_they_were_set_back_says_what_it_said_before, begin, end),
        cmocka_unit_test_setup_teardown(the_cycle_of_a_change_begins_no_part, begin, end),
        cmocka_unit_test_setup_teardown(the_run_ends_with_stops_that_were_not_taken, begin, end),
        cmocka_unit_test_setup_teardown(nothing_was_up_when_nobody_took_stops, begin, end),
        cmocka_unit_test_setup_teardown(a_command_has_the_stamp_of_the_cycle_that_took_it, begin, end),
        cmocka_unit_test_setup_teardown(an_input_that_ends_an_automatic_run_is_named, begin, end),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
