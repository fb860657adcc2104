/* A directory of logs with a quota: which are deleted, which stay, and how a new one is named. */
#include "support.h"

#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "log.h"
#include "log_directory.h"

static char directory[] = "/tmp/log_directory.XXXXXX";
enum { LOG_BYTES = 65536 }; /* size of a log, in whole blocks on any file system */

static const char *in(const char *name) {
    static char path[4][PATH_MAX];
    static int next;
    next = (next + 1) % 4;
    snprintf(path[next], PATH_MAX, "%s/%s", directory, name);
    return path[next];
}

static bool there(const char *name) { return access(in(name), F_OK) == 0; }

/* Makes a log last written age_s ago. */
static void make(const char *name, int age_s) {
    static char bytes[LOG_BYTES];
    memset(bytes, 'x', sizeof bytes);
    int file = open(in(name), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    assert_int_equal(write(file, bytes, sizeof bytes), sizeof bytes);
    struct timespec now, times[2];
    clock_gettime(CLOCK_REALTIME, &now);
    now.tv_sec -= age_s;
    times[0] = times[1] = now;
    assert_int_equal(futimens(file, times), 0);
    fsync(file);
    close(file);
}

static int empty(void **unused) {
    (void)unused;
    char command[PATH_MAX];
    snprintf(command, sizeof command, "rm -rf %s && mkdir %s", directory, directory);
    return system(command);
}

static void the_oldest_go_until_the_rest_is_within_the_quota(void **unused) {
    (void)unused;
    struct error error;
    /* the order is by the last write and not by name, because clocks may be set */
    make("2026-01-01T00-00-00Z.lcm", 10);
    make("2026-01-02T00-00-00Z.lcm", 40);
    make("2026-01-02T00-00-00Zb.lcm", 30);
    make("2026-01-03T00-00-00Z.lcm", 20);
    assert_int_equal(log_directory_prune(directory, 4 * LOG_BYTES, NULL, &error), STATUS_OK);
    assert_true(there("2026-01-02T00-00-00Z.lcm"));
    assert_int_equal(log_directory_prune(directory, 2 * LOG_BYTES, NULL, &error), STATUS_OK);
    assert_false(there("2026-01-02T00-00-00Z.lcm") || there("2026-01-02T00-00-00Zb.lcm"));
    assert_true(there("2026-01-03T00-00-00Z.lcm") && there("2026-01-01T00-00-00Z.lcm"));
}

/* The clock was wrong, so the latest run's name and time are in the past. */
static void the_order_is_that_of_the_numbers_whatever_the_clock_said(void **unused) {
    (void)unused;
    struct error error;
    make("000009_2031-01-01T00-00-00Z.lcm", -90);
    make("000010_1970-01-01T00-00-09Z.0001.lcm", 900000);
    make("000010_1970-01-01T00-00-09Z.0002.lcm", 899990);
    make("000011_2000-01-01T00-00-00Z.lcm", 800000);
    make("2030-01-01T00-00-00Z.lcm", 0); /* a name of an earlier version */
    assert_int_equal(log_directory_prune(directory, 4 * LOG_BYTES, NULL, &error), STATUS_OK);
    assert_false(there("2030-01-01T00-00-00Z.lcm"));
    assert_int_equal(log_directory_prune(directory, 3 * LOG_BYTES, NULL, &error), STATUS_OK);
    assert_false(there("000009_2031-01-01T00-00-00Z.lcm"));
    assert_int_equal(log_directory_prune(directory, 2 * LOG_BYTES, NULL, &error), STATUS_OK);
    assert_false(there("000010_1970-01-01T00-00-09Z.0001.lcm"));
    assert_int_equal(log_directory_prune(directory, 0, NULL, &error), STATUS_OK);
    assert_true(there("000011_2000-01-01T00-00-00Z.lcm") && !there("000010_1970-01-01T00-00-09Z.0002.lcm"));
}

static void the_next_number_is_beyond_all_that_are_there(void **unused) {
    (void)unused;
    struct error error;
    char path[PATH_MAX];
    assert_int_equal(log_directory_create(directory, false, path, sizeof path, &error), STATUS_OK);
    assert_non_null(strstr(path, "/000001_2"));
    make("001234_2026-01-01T00-00-00Z.0007.lcm", 0);
    make("999999999_2026-01-01.lcm", 0);           /* another program's */
    make("9999999999_2026-01-01T00-00-00Z.lcm", 0);
    assert_int_equal(log_directory_create(directory, true, path, sizeof path, &error), STATUS_OK);
    assert_non_null(strstr(path, "/001235_2"));
    make("999999999_2026-01-01T00-00-00Z.lcm", 0);
    assert_int_equal(log_directory_create(directory, true, path, sizeof path, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "number 999999999, the largest"));
}

static void the_newest_stays_whatever_it_takes(void **unused) {
    (void)unused;
    struct error error;
    make("2026-01-01T00-00-00Z.lcm", 20);
    make("2026-01-02T00-00-00Z.lcm", 10);
    assert_int_equal(log_directory_prune(directory, 1, NULL, &error), STATUS_OK);
    assert_false(there("2026-01-01T00-00-00Z.lcm"));
    assert_true(there("2026-01-02T00-00-00Z.lcm"));
}

static void a_log_that_is_being_written_stays(void **unused) {
    (void)unused;
    struct error error;
    struct log_writer *log;
    assert_int_equal(log_create(&log, in("2026-01-01T00-00-00Z.lcm"), &error), STATUS_OK);
    make("2026-01-02T00-00-00Z.lcm", -20); /* newer */
    make("2026-01-03T00-00-00Z.lcm", -30);
    assert_int_equal(log_directory_prune(directory, 1, NULL, &error), STATUS_OK);
    assert_true(there("2026-01-01T00-00-00Z.lcm"));
    assert_false(there("2026-01-02T00-00-00Z.lcm"));
    assert_int_equal(log_close(log, &error), STATUS_OK);
    assert_int_equal(log_directory_prune(directory, 1, NULL, &error), STATUS_OK);
    assert_false(there("2026-01-01T00-00-00Z.lcm")); /* the lock ends with the writer */
}

static void no_part_of_a_run_in_progress_goes(void **unused) {
    (void)unused;
    struct error error;
    struct log_writer *log;
    int64_t left;
    make("2026-01-01T00-00-00Z.0001.lcm", 50);
    make("2026-01-01T00-00-00Z.0002.lcm", 40);
    assert_int_equal(log_create(&log, in("2026-01-01T00-00-00Z.0003.lcm"), &error), STATUS_OK);
    make("2026-01-01T00-00-00Zb.0001.lcm", 30); /* another run that began in the same second, and
                                                 * has ended */
    make("2026-01-01T00-00-00Zb.0002.lcm", 20);
    make("2026-01-02T00-00-00Z.lcm", -10);
    assert_int_equal(log_directory_prune(directory, 1, &left, &error), STATUS_OK);
    assert_true(there("2026-01-01T00-00-00Z.0001.lcm") && there("2026-01-01T00-00-00Z.0002.lcm") && there("2026-01-01T00-00-00Z.0003.lcm"));
    assert_false(there("2026-01-01T00-00-00Zb.0001.lcm") || there("2026-01-01T00-00-00Zb.0002.lcm"));
    assert_int_equal(left, 3 * LOG_BYTES); /* 65,536 bytes each; the present log is empty */
    assert_int_equal(log_close(log, &error), STATUS_OK);
    /* a log that has ended is deleted part by part */
    assert_int_equal(log_directory_prune(directory, 2 * LOG_BYTES, &left, &error), STATUS_OK);
    assert_true(!there("2026-01-01T00-00-00Z.0001.lcm") && there("2026-01-01T00-00-00Z.0002.lcm"));
    assert_int_equal(left, 2 * LOG_BYTES);
}

static void parts_are_numbered_behind_the_name_of_their_run(void **unused) {
    (void)unused;
    struct error error;
    char first[PATH_MAX], other[PATH_MAX], path[PATH_MAX];
    assert_int_equal(log_directory_create(directory, true, first, sizeof first, &error), STATUS_OK);
    assert_int_equal(log_directory_create(directory, true, other, sizeof other, &error), STATUS_OK);
    assert_string_not_equal(first, other);
    assert_non_null(strstr(first, "Z.0001.lcm"));
    assert_int_equal(log_directory_part(first, 12, path, sizeof path, &error), STATUS_OK);
    assert_int_equal(strncmp(path, first, strlen(first) - strlen("0001.lcm")), 0);
    assert_string_equal(path + strlen(first) - strlen("0001.lcm"), "0012.lcm");
    assert_int_equal(log_directory_part(first, LOG_PARTS_MAX + 1, path, sizeof path, &error), STATUS_IO);
}

static void what_is_named_otherwise_or_is_no_file_is_left_alone(void **unused) {
    (void)unused;
    struct error error;
    const char *const others[] = {"a.lcm",
                                  "2026-01-01T00-00-00Z.yaml",
                                  "2026-01-01T00-00-00Za.lcm",
                                  "2026-01-01T00-00-00Z.lcm.gz",
                                  "2026-01-01T00-00-00Z.001.lcm",
                                  "2026-01-01T00-00-00Z.00001.lcm",
                                  "2026-01-01T00-00-00Z.0001",
                                  "x026-01-01T00-00-00Z.lcm"};
    enum { OTHERS = sizeof others / sizeof *others };
    for (int i = 0; i < OTHERS; i++) make(others[i], 100);
    assert_int_equal(symlink(in("a.lcm"), in("2026-01-01T00-00-01Z.lcm")), 0);
    assert_int_equal(mkdir(in("2026-01-01T00-00-02Z.lcm"), 0777), 0);
    assert_int_equal(mkfifo(in("2026-01-01T00-00-03Z.lcm"), 0666), 0);
    make("2026-01-02T00-00-00Z.lcm", 10);
    assert_int_equal(log_directory_prune(directory, 1, NULL, &error), STATUS_OK);
    for (int i = 0; i < OTHERS; i++) assert_true(there(others[i]));
    assert_true(there("2026-01-01T00-00-01Z.lcm") && there("2026-01-01T00-00-02Z.lcm") && there("2026-01-01T00-00-03Z.lcm"));
}

static void a_directory_that_is_not_there_is_named(void **unused) {
    (void)unused;
    struct error error;
    char path[PATH_MAX];
    assert_int_equal(log_directory_prune(in("none"), 1, NULL, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "/none"));
    assert_int_equal(log_directory_create(in("none"), false, path, sizeof path, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "/none"));
}

static void runs_of_the_same_second_have_logs_of_their_own(void **unused) {
    (void)unused;
    struct error error;
    char path[5][PATH_MAX];
    for (int i = 0; i < 5; i++) {
        assert_int_equal(log_directory_create(directory, false, path[i], sizeof path[i], &error), STATUS_OK);
        for (int j = 0; j < i; j++) assert_string_not_equal(path[i], path[j]);
    }
    /* empty files free no space */
    assert_int_equal(log_directory_prune(directory, 0, NULL, &error), STATUS_OK);
    for (int i = 0; i < 5; i++) assert_int_equal(access(path[i], F_OK), 0);
}

static int make_directory(void **unused) {
    (void)unused;
    return mkdtemp(directory) ? 0 : -1;
}

static int remove_directory(void **unused) { return empty(unused) || rmdir(directory); }

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(the_oldest_go_until_the_rest_is_within_the_quota, empty),
        cmocka_unit_test_setup(the_order_is_that_of_the_numbers_whatever_the_clock_said, empty),
        cmocka_unit_test_setup(the_next_number_is_beyond_all_that_are_there, empty),
        cmocka_unit_test_setup(the_newest_stays_whatever_it_takes, empty),
        cmocka_unit_test_setup(a_log_that_is_being_written_stays, empty),
        cmocka_unit_test_setup(no_part_of_a_run_in_progress_goes, empty),
        cmocka_unit_test_setup(parts_are_numbered_behind_the_name_of_their_run, empty),
        cmocka_unit_test_setup(what_is_named_otherwise_or_is_no_file_is_left_alone, empty),
        cmocka_unit_test_setup(a_directory_that_is_not_there_is_named, empty),
        cmocka_unit_test_setup(runs_of_the_same_second_have_logs_of_their_own, empty),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
