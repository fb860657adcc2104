/* Outputs: results are written whole or not at all, recordings are never overwritten, a log has one
 * writer. */
#include "support.h"

#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "log.h"
#include "output.h"
#include "recognise.h"

static char directory[] = "/tmp/output.XXXXXX";
static struct output out;
static struct error error;

static const char *in(const char *name) {
    static char path[4][PATH_MAX];
    static int next;
    next = (next + 1) % 4;
    snprintf(path[next], PATH_MAX, "%s/%s", directory, name);
    return path[next];
}

static void make(const char *name, const char *text, size_t size) {
    int file = open(in(name), O_WRONLY | O_CREAT | O_TRUNC, 0640);
    assert_int_equal(write(file, text, size), size);
    close(file);
}

static const char *text_of(const char *name) {
    static char text[100];
    int file = open(in(name), O_RDONLY);
    ssize_t size = file < 0 ? -1 : read(file, text, sizeof text - 1);
    if (file >= 0) close(file);
    text[size < 0 ? 0 : size] = '\0';
    return size < 0 ? NULL : text;
}

static int files(void) {
    char command[PATH_MAX];
    int count = -1;
    snprintf(command, sizeof command, "ls -A %s | wc -l", directory);
    FILE *list = popen(command, "r");
    assert_int_equal(fscanf(list, "%d", &count), 1);
    pclose(list);
    return count;
}

static int empty(void **unused) {
    (void)unused;
    char command[PATH_MAX];
    snprintf(command, sizeof command, "rm -rf %s && mkdir %s", directory, directory);
    return system(command);
}

static const char log_bytes_[] = "\xed\xa1\xda\x01 and so on", table[] = "a,b\n1,2\n";
#define MAKE(name, literal) make(name, literal, sizeof(literal) - 1)

static void recordings_are_recognised_by_what_is_in_them(void **unused) {
    (void)unused;
    static const char *const recordings[] = {"\xed\xa1\xda\x01...",
                                             "\x89MCAP0\r\n",
                                             "MATLAB 5.0 MAT-file, written by hexid",
                                             "# dof: z\n# rate_hz: 500\nt_s,l1_m\n",
                                             "\xef\xbb\xbfZeit;Weg [mm]\r\n0,001;12,5\r\n",
                                             "# of a stand\n\nt\tposition\n0\t1e-3\n",
                                             "time_s,seq\n0,1\n",
                                             "a,b,c\n1,,nan\n"};
    static const char *const others[] = {"",
                                         "{\"schema\": \"hexid.check/1\", \"t\": 1}\n",
                                         "<!doctype html>\n<p>1,2\n",
                                         "a,b\n",
                                         "loop:\n  period_s: 0.002\n",
                                         "# hexid gap, model: x, y\nlcm:\n  url: 1,2\n",
                                         "[1, 2,\n3, 4]\n",
                                         "a, b\nc, d\n"};
    for (size_t i = 0; i < sizeof recordings / sizeof *recordings; i++) {
        make("a", recordings[i], strlen(recordings[i]));
        if (!recognise(in("a"))) fail_msg("not recognised: %s", recordings[i]);
        assert_int_equal(output_prepare(&out, in("a"), OUTPUT_RESULT, &error), STATUS_USAGE);
        assert_non_null(strstr(error.text, "/a: is a"));
    }
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        make("a", others[i], strlen(others[i]));
        if (recognise(in("a"))) fail_msg("taken for a recording: %s", others[i]);
        assert_int_equal(output_prepare(&out, in("a"), OUTPUT_RESULT, &error), STATUS_OK);
    }
    assert_int_equal(files(), 1);
}

static void a_result_takes_the_place_of_the_earlier_one_when_it_is_whole(void **unused) {
    (void)unused;
    struct stat s;
    MAKE("real", "earlier");
    assert_int_equal(mkdir(in("sub"), 0777), 0);
    assert_int_equal(symlink("../real", in("sub/link")), 0);
    assert_int_equal(output_prepare(&out, in("sub/link"), OUTPUT_RESULT, &error), STATUS_OK);
    assert_string_equal(text_of("real"), "earlier");
    assert_int_equal(output_write(&out, "later", &error), STATUS_OK);
    assert_string_equal(text_of("real"), "later");
    assert_true(!lstat(in("sub/link"), &s) && S_ISLNK(s.st_mode));
    assert_true(!stat(in("real"), &s) && (s.st_mode & 0777) == 0640);
    assert_int_equal(files(), 2);
}

/* A limit of the file's size simulates a full disk. */
static void one_that_cannot_be_written_leaves_the_earlier_one(void **unused) {
    (void)unused;
    static char large[100000];
    memset(large, 'x', sizeof large - 1);
    MAKE("page", "earlier");
    pid_t child = fork();
    if (child == 0) {
        signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &(struct rlimit){1000, 1000});
        bool good = !output_prepare(&out, in("page"), OUTPUT_RESULT, &error) && output_write(&out, large, &error) == STATUS_IO &&
                    strstr(error.text, "the earlier one is left") != NULL;
        _exit(!good);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_string_equal(text_of("page"), "earlier");
    assert_int_equal(files(), 1);
}

static void what_has_come_meanwhile_is_not_overwritten(void **unused) {
    (void)unused;
    MAKE("b", "earlier");
    assert_int_equal(output_prepare(&out, in("a"), OUTPUT_RESULT, &error), STATUS_OK);
    MAKE("a", "another's");
    assert_int_equal(output_write(&out, "mine", &error), STATUS_IO);
    assert_string_equal(text_of("a"), "another's");
    assert_int_equal(output_prepare(&out, in("b"), OUTPUT_RESULT, &error), STATUS_OK);
    MAKE("c", "another's");
    assert_int_equal(rename(in("c"), in("b")), 0);
    assert_int_equal(output_write(&out, "mine", &error), STATUS_IO);
    assert_string_equal(text_of("b"), "another's");
    assert_int_equal(files(), 2);
}

static void descriptors_and_devices_are_written_in_place(void **unused) {
    (void)unused;
    char path[40];
    int file = open(in("a"), O_RDWR | O_CREAT, 0666);
    assert_int_equal(write(file, "before, ", 8), 8);
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    assert_int_equal(output_text(path, "after", &error), STATUS_OK);
    assert_string_equal(text_of("a"), "before, after");
    assert_int_equal(symlink("/dev/null", in("null")), 0);
    assert_int_equal(output_text(in("null"), "x", &error), STATUS_OK);
    struct stat s;
    assert_true(!stat("/dev/null", &s) && S_ISCHR(s.st_mode) && !lstat(in("null"), &s) && S_ISLNK(s.st_mode));
    assert_int_equal(files(), 2);
    close(file);
}

static void a_fifo_that_nobody_reads_is_refused(void **unused) {
    (void)unused;
    char text[8] = "", aside[PATH_MAX];
    assert_int_equal(mkfifo(in("fifo"), 0666), 0);
    assert_int_equal(output_prepare(&out, in("fifo"), OUTPUT_RESULT, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "a FIFO that nobody reads; start its reader first"));
    assert_int_equal(output_log(in("fifo"), aside, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "a FIFO that nobody reads"));
    int reader = open(in("fifo"), O_RDONLY | O_NONBLOCK);
    assert_int_equal(output_text(in("fifo"), "result", &error), STATUS_OK);
    assert_int_equal(read(reader, text, sizeof text), 6);
    close(reader);
}

static void a_log_that_is_there_is_set_aside(void **unused) {
    (void)unused;
    struct log_writer *log;
    char aside[PATH_MAX];
    make("a.lcm", log_bytes_, sizeof log_bytes_ - 1);
    MAKE("a.lcm.1", "somebody's");
    assert_int_equal(symlink("a.lcm", in("link")), 0);
    int file = output_log(in("link"), aside, &error);
    assert_true(file >= 0);
    assert_string_equal(aside, in("a.lcm.2"));
    assert_int_equal(log_on_file(&log, file, in("link"), &error), STATUS_OK);
    assert_int_equal(log_write(log, 1, "A", "x", 1, &error), STATUS_OK);
    assert_int_equal(log_close(log, &error), STATUS_OK);
    assert_string_equal(text_of("a.lcm.2"), log_bytes_);
    assert_string_equal(text_of("a.lcm.1"), "somebody's");
    assert_string_equal(recognise(in("a.lcm")), recognise_log);
    MAKE("table", table);
    assert_int_equal(output_log(in("table"), aside, &error), STATUS_USAGE);
    assert_string_equal(text_of("table"), table);
}

static void a_log_has_one_writer(void **unused) {
    (void)unused;
    char aside[PATH_MAX];
    int file = output_log(in("a.lcm"), aside, &error);
    assert_true(file >= 0);
    assert_int_equal(output_log(in("a.lcm"), aside, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "/a.lcm: another process writes this log; name another file"));
    assert_int_equal(link(in("a.lcm"), in("b.lcm")), 0);
    assert_int_equal(output_log(in("b.lcm"), aside, &error), STATUS_IO);
    close(file);
    file = output_log(in("a.lcm"), aside, &error);
    assert_true(file >= 0 && !*aside);
    close(file);
}

enum { WRITERS = 8, ROUNDS = 40 };
static pthread_barrier_t begin;

static void *takes_the_log(void *argument) {
    char aside[PATH_MAX];
    struct error own;
    pthread_barrier_wait(&begin);
    int file = output_log(in("a.lcm"), aside, &own);
    if (file >= 0 && write(file, argument, 1) != 1) abort();
    pthread_barrier_wait(&begin); /* all have tried */
    if (file >= 0) close(file);
    return file >= 0 ? argument : NULL;
}

static void of_many_that_begin_at_once_each_has_a_file_or_is_refused(void **unused) {
    (void)unused;
    static char letter[WRITERS];
    int written = 0;
    for (int round = 0; round < ROUNDS; round++) {
        pthread_t thread[WRITERS];
        pthread_barrier_init(&begin, NULL, WRITERS);
        int before = files(), took = 0;
        for (int i = 0; i < WRITERS; i++) assert_int_equal(pthread_create(&thread[i], NULL, takes_the_log, &letter[i]), 0);
        for (int i = 0; i < WRITERS; i++) {
            void *result;
            pthread_join(thread[i], &result);
            took += result != NULL;
        }
        pthread_barrier_destroy(&begin);
        assert_int_equal(took, 1); /* the lock is held until all processes have tried */
        assert_int_equal(files(), before + 1);
        written++;
    }
    assert_int_equal(files(), written);
}

/* Each of these functions disturbs the file of a log that is being written. */
static void delete(const char *path) { assert_int_equal(unlink(path), 0); }
static void rename_it(const char *path) { assert_int_equal(rename(path, in("away")), 0); }
static void replace(const char *path) {
    MAKE("other", "x");
    assert_int_equal(rename(in("other"), path), 0);
}
static void cut(const char *path) { assert_int_equal(truncate(path, 10), 0); }
static void begin_again(const char *path) { assert_int_equal(truncate(path, 0), 0); }
static void append(const char *path) {
    int file = open(path, O_WRONLY | O_APPEND);
    assert_int_equal(write(file, "x", 1), 1);
    close(file);
}
static void nothing(const char *path) { (void)path; }

static void a_log_that_disappears_is_a_fault_of_the_log(void **unused) {
    (void)unused;
    static const struct {
        void (*happens)(const char *path);
        const char *said;
        int lost;
    } attack[] = {{delete, "was deleted", 30},
                  {rename_it, "was renamed or replaced", 0},
                  {replace, "was deleted", 30},
                  {cut, "was cut", 30},
                  {begin_again, "was cut", 30},
                  {append, "is written by another process", 30},
                  {nothing, NULL, 0}};
    for (size_t i = 0; i < sizeof attack / sizeof *attack; i++) {
        struct log_writer *log;
        empty(NULL);
        assert_int_equal(log_create(&log, in("a.lcm"), &error), STATUS_OK);
        log_count(log, "A");
        for (int e = 0; e < 30; e++) assert_int_equal(log_write(log, e, "A", table, 8, &error), STATUS_OK);
        assert_int_equal(log_check(log, &error), STATUS_OK);
        attack[i].happens(in("a.lcm"));
        int seen = log_check(log, &error);
        assert_int_equal(seen, attack[i].said ? STATUS_IO : STATUS_OK);
        if (attack[i].said) assert_non_null(strstr(error.text, attack[i].said));
        assert_int_equal(log_lost(log), attack[i].lost);
        if (seen) assert_int_equal(log_write(log, 31, "A", table, 8, &error), STATUS_IO);
        assert_int_equal(log_lost(log), attack[i].lost + (seen != 0));
        log_close(log, &error);
    }
}

static void events_that_a_full_disk_has_not_taken_are_counted(void **unused) {
    (void)unused;
    enum { EVENTS = 500, SIZE = 417 };
    static const char data[SIZE];
    for (rlim_t limit = 30000; limit < 30010; limit++) {
        struct log_writer *log;
        struct log_reader *reader;
        struct log_event event;
        int read = 0;
        empty(NULL);
        pid_t child = fork();
        if (child == 0) {
            signal(SIGXFSZ, SIG_IGN);
            if (log_create(&log, in("a.lcm"), &error)) _exit(255);
            log_count(log, "A");
            setrlimit(RLIMIT_FSIZE, &(struct rlimit){limit, limit});
            for (int e = 0; e < EVENTS; e++) log_write(log, e, e % 5 ? "A" : "B", data, SIZE, &error);
            log_flush(log, &error);
            FILE *told = fopen(in("lost"), "w");
            fprintf(told, "%d", (int)log_lost(log));
            _exit(fclose(told));
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_int_equal(status, 0);
        assert_int_equal(log_open(&reader, in("a.lcm"), &error), STATUS_OK);
        while (log_next(reader, &event)) read += !strcmp(event.channel, "A");
        log_release(reader);
        assert_int_equal(atoi(text_of("lost")), EVENTS * 4 / 5 - read);
    }
}

static int make_directory(void **unused) {
    (void)unused;
    return mkdtemp(directory) ? 0 : -1;
}

static int remove_directory(void **unused) { return empty(unused) || rmdir(directory); }

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(recordings_are_recognised_by_what_is_in_them, empty),
        cmocka_unit_test_setup(a_result_takes_the_place_of_the_earlier_one_when_it_is_whole, empty),
        cmocka_unit_test_setup(one_that_cannot_be_written_leaves_the_earlier_one, empty),
        cmocka_unit_test_setup(what_has_come_meanwhile_is_not_overwritten, empty),
        cmocka_unit_test_setup(descriptors_and_devices_are_written_in_place, empty),
        cmocka_unit_test_setup(a_fifo_that_nobody_reads_is_refused, empty),
        cmocka_unit_test_setup(a_log_that_is_there_is_set_aside, empty),
        cmocka_unit_test_setup(a_log_has_one_writer, empty),
        cmocka_unit_test_setup(of_many_that_begin_at_once_each_has_a_file_or_is_refused, empty),
        cmocka_unit_test_setup(a_log_that_disappears_is_a_fault_of_the_log, empty),
        cmocka_unit_test_setup(events_that_a_full_disk_has_not_taken_are_counted, empty),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
