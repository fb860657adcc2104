/* The process that creates the parts of a log, and the writer that continues in them. */
#include "support.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "log.h"
#include "log_directory.h"
#include "log_keeper.h"

enum { WAIT_MS = 60000, OLD_BYTES = 65536 };

static char directory[] = "/tmp/log_keeper.XXXXXX";
static char first[PATH_MAX];
static struct log_keeper keeper;
static struct error error;

static int begin(void **unused) {
    (void)unused;
    char command[PATH_MAX];
    snprintf(command, sizeof command, "rm -rf %s && mkdir %s", directory, directory);
    return system(command) || log_directory_create(directory, true, first, sizeof first, &error);
}

/* Waits for all child processes of this test, which are keepers. */
static int end(void **unused) {
    (void)unused;
    log_keeper_stop(&keeper);
    while (waitpid(-1, NULL, 0) > 0 || errno == EINTR) continue;
    return 0;
}

static pid_t process(void) {
    char path[64];
    int pid = 0;
    snprintf(path, sizeof path, "/proc/self/task/%d/children", (int)getpid());
    FILE *file = fopen(path, "r");
    if (!file || fscanf(file, "%d", &pid) != 1) pid = 0;
    if (file) fclose(file);
    return pid;
}

static struct log_part next(void) {
    struct log_part part;
    log_keeper_ask(&keeper);
    assert_int_equal(log_keeper_take(&keeper, WAIT_MS, &part, &error), 1);
    return part;
}

static int events(const char *path, char *last) {
    struct log_reader *log;
    struct log_event event;
    int count = 0;
    assert_int_equal(log_open(&log, path, &error), STATUS_OK);
    for (; log_next(log, &event); count++) *last = *(const char *)event.data;
    log_release(log);
    return count;
}

static void a_log_goes_on_in_its_parts_without_a_loss(void **unused) {
    (void)unused;
    struct log_writer *log;
    struct log_part part[2];
    char last;
    assert_int_equal(log_keeper_start(&keeper, first, 0, &error), STATUS_OK);
    assert_int_equal(log_create(&log, first, &error), STATUS_OK);
    for (int p = 0; p < 3; p++) {
        for (char c = 'a'; c <= 'c'; c++) assert_int_equal(log_write(log, p, "CHANNEL", &(char){(char)(c + 3 * p)}, 1, &error), STATUS_OK);
        assert_int_equal(log_bytes(log), 3 * (int64_t)log_event_size("CHANNEL", 1));
        if (p == 2) break;
        part[p] = next();
        assert_int_equal(log_continue(log, part[p].file, part[p].path, &error), STATUS_OK);
        assert_int_equal(log_bytes(log), 0);
    }
    assert_int_equal(log_close(log, &error), STATUS_OK);
    assert_int_equal(events(first, &last), 3);
    assert_int_equal(last, 'c');
    assert_int_equal(events(part[0].path, &last), 3);
    assert_int_equal(last, 'f');
    assert_int_equal(events(part[1].path, &last), 3);
    assert_int_equal(last, 'i');
    assert_non_null(strstr(part[1].path, ".0003.lcm"));
}

static void make_old(const char *name) {
    static char bytes[OLD_BYTES];
    char path[PATH_MAX];
    memset(bytes, 'x', sizeof bytes);
    snprintf(path, sizeof path, "%s/%s", directory, name);
    int file = open(path, O_WRONLY | O_CREAT, 0666);
    assert_int_equal(write(file, bytes, sizeof bytes), sizeof bytes);
    const struct timespec long_ago[2] = {{.tv_sec = 1000000}, {.tv_sec = 1000000}};
    assert_int_equal(futimens(file, long_ago), 0);
    fsync(file);
    close(file);
}

static int logs(void) {
    struct dirent **found;
    int count = scandir(directory, &found, NULL, NULL), files = 0;
    for (int i = 0; i < count; i++) files += found[i]->d_name[0] != '.', free(found[i]);
    free(found);
    return files;
}

static void earlier_runs_make_room_and_the_one_in_progress_never_does(void **unused) {
    (void)unused;
    static char bytes[2 * OLD_BYTES];
    struct log_writer *log;
    make_old("2026-01-01T00-00-00Z.lcm");
    make_old("2026-01-02T00-00-00Z.0001.lcm");
    make_old("2026-01-02T00-00-00Z.0002.lcm");
    /* Each old log takes one unit; a part takes two plus its events' headers. */
    assert_int_equal(log_keeper_start(&keeper, first, 4 * OLD_BYTES + OLD_BYTES / 2, &error), STATUS_OK);
    assert_int_equal(log_create(&log, first, &error), STATUS_OK);
    for (int p = 0; p < 3; p++) {
        /* 5 units are more than the 4.5 allowed, so one old log is deleted; at 6 units the others
         * are; then no old log is left to delete */
        static const int left[] = {4, 3, 4};
        static const bool over[] = {false, false, true};
        assert_int_equal(log_write(log, 0, "CHANNEL", bytes, sizeof bytes, &error), STATUS_OK);
        assert_int_equal(log_flush(log, &error), STATUS_OK);
        sync();
        struct log_part part = next();
        assert_int_equal(log_continue(log, part.file, part.path, &error), STATUS_OK);
        assert_true(part.over == over[p]);
        assert_int_equal(logs(), left[p]);
    }
    assert_int_equal(access(first, F_OK), 0);
    assert_int_equal(log_close(log, &error), STATUS_OK);
}

static void a_part_that_cannot_be_made_can_be_asked_for_again(void **unused) {
    (void)unused;
    struct log_part part;
    char elsewhere[64];
    snprintf(elsewhere, sizeof elsewhere, "%s.away", directory);
    assert_int_equal(log_keeper_start(&keeper, first, 1, &error), STATUS_OK);
    assert_int_equal(log_keeper_take(&keeper, 0, &part, &error), 0); /* no part was asked for */
    assert_int_equal(rename(directory, elsewhere), 0);
    log_keeper_ask(&keeper);
    assert_int_equal(log_keeper_take(&keeper, WAIT_MS, &part, &error), STATUS_IO);
    assert_non_null(strstr(error.text, ".0002.lcm: cannot be created"));
    assert_int_equal(rename(elsewhere, directory), 0);
    part = next();
    assert_non_null(strstr(part.path, ".0002.lcm"));
    close(part.file);
}

static void a_name_that_is_taken_is_left_alone(void **unused) {
    (void)unused;
    char taken[PATH_MAX];
    struct stat s;
    assert_int_equal(log_directory_part(first, 2, taken, sizeof taken, &error), STATUS_OK);
    make_old(strrchr(taken, '/') + 1);
    assert_int_equal(log_keeper_start(&keeper, first, 0, &error), STATUS_OK);
    struct log_part part = next();
    assert_non_null(strstr(part.path, ".0003.lcm"));
    close(part.file);
    assert_true(!stat(taken, &s) && s.st_size == OLD_BYTES);
}

static void a_part_that_was_made_ahead_goes_with_the_run(void **unused) {
    (void)unused;
    assert_int_equal(log_keeper_start(&keeper, first, 0, &error), STATUS_OK);
    struct log_part used = next();
    assert_int_equal(write(used.file, "x", 1), 1);
    struct log_part unused_part = next();
    close(used.file);
    close(unused_part.file);
    log_keeper_stop(&keeper); /* waits for it */
    assert_int_equal(access(used.path, F_OK), 0);
    assert_int_equal(access(unused_part.path, F_OK), -1);
}

/* SAFETY: a bus that the daemon has open must not stay open after its end. */
static void the_process_has_nothing_of_the_daemons_open_and_hears_no_signals(void **unused) {
    (void)unused;
    char path[64];
    int files = 0;
    /* the keeper has /dev/null three times and the socket open; briefly also the part that was
     * sent */
    enum { ALL = 4 };
    assert_int_equal(log_keeper_start(&keeper, first, 0, &error), STATUS_OK);
    close(next().file);
    pid_t pid = process();
    assert_true(pid > 0);
    snprintf(path, sizeof path, "/proc/%d/fd", (int)pid);
    for (int i = 0; i < 10000 && files != ALL; i++) {
        DIR *open_files = opendir(path);
        assert_non_null(open_files);
        files = 0;
        for (const struct dirent *d; (d = readdir(open_files));) files += d->d_name[0] != '.';
        closedir(open_files);
        sched_yield();
    }
    assert_int_equal(files, ALL);
    kill(pid, SIGTERM), kill(pid, SIGINT), kill(pid, SIGTSTP);
    close(next().file);
}

static void its_death_is_seen(void **unused) {
    (void)unused;
    struct log_part part;
    assert_int_equal(log_keeper_start(&keeper, first, 0, &error), STATUS_OK);
    close(next().file);
    assert_int_equal(kill(process(), SIGKILL), 0);
    log_keeper_ask(&keeper);
    assert_int_equal(log_keeper_take(&keeper, WAIT_MS, &part, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "has ended"));
}

static int make_directory(void **unused) {
    (void)unused;
    return mkdtemp(directory) ? 0 : -1;
}

static int remove_directory(void **unused) { return begin(unused) || unlink(first) || rmdir(directory); }

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_log_goes_on_in_its_parts_without_a_loss, begin, end),
        cmocka_unit_test_setup_teardown(earlier_runs_make_room_and_the_one_in_progress_never_does, begin, end),
        cmocka_unit_test_setup_teardown(a_part_that_cannot_be_made_can_be_asked_for_again, begin, end),
        cmocka_unit_test_setup_teardown(a_name_that_is_taken_is_left_alone, begin, end),
        cmocka_unit_test_setup_teardown(a_part_that_was_made_ahead_goes_with_the_run, begin, end),
        cmocka_unit_test_setup_teardown(the_process_has_nothing_of_the_daemons_open_and_hears_no_signals, begin, end),
        cmocka_unit_test_setup_teardown(its_death_is_seen, begin, end),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
