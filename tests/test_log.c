/* The native log: liblcm and hexid read each other's logs, a truncated or damaged one is read up to
 * the damage, and a full disk is reported. */
#include <lcm/eventlog.h>
#include <malloc.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>
#include "support.h"

#include "log.h"

enum { EVENTS = 40, HEADER = 28, DATA_MAX = 400 };

static char path[] = "/tmp/hexid_log_XXXXXX"; /* a directory with one file per test */
static char file[64];

static int make_directory(void **unused) {
    (void)unused;
    if (!mkdtemp(path)) return -1;
    snprintf(file, sizeof file, "%s/test.lcm", path);
    return 0;
}

static int remove_directory(void **unused) {
    (void)unused;
    unlink(file);
    return rmdir(path);
}

/* Channel, size, time and data of event i of the test log. */
static const char *channel_of(int i) { return i % 3 ? "HEXID_STATE" : "SOMEBODY_ELSE"; }
static int size_of(int i) { return i * 37 % DATA_MAX; }
static int64_t utime_of(int i) { return 1700000000000000 + 2000 * i; }
static void data_of(int i, unsigned char data[DATA_MAX]) {
    for (int k = 0; k < DATA_MAX; k++) data[k] = (unsigned char)(i * 7 + k);
}

static void write_test_log(void) {
    struct log_writer *w;
    struct error error;
    unsigned char data[DATA_MAX];
    unlink(file); /* log_create() would give an existing file another name */
    assert_int_equal(log_create(&w, file, &error), 0);
    for (int i = 0; i < EVENTS; i++) {
        data_of(i, data);
        assert_int_equal(log_write(w, utime_of(i), channel_of(i), data, size_of(i), &error), 0);
    }
    assert_int_equal(log_close(w, &error), 0);
}

static void assert_is_event(const struct log_event *e, int i) {
    unsigned char data[DATA_MAX];
    data_of(i, data);
    assert_int_equal(e->utime_us, utime_of(i));
    assert_string_equal(e->channel, channel_of(i));
    assert_int_equal(e->size, size_of(i));
    assert_memory_equal(e->data, data, (size_t)e->size);
}

/* Returns the number of events read, each checked against the test log. */
static int read_test_log(bool *cut, int64_t *offset) {
    struct log_reader *r;
    struct log_event e;
    struct error error;
    int events = 0;
    assert_int_equal(log_open(&r, file, &error), 0);
    while (log_next(r, &e)) assert_is_event(&e, events++);
    assert_int_equal(log_next(r, &e), 0); /* the reader stays at the end */
    *cut = log_cut(r, offset);
    log_release(r);
    return events;
}

static void what_is_written_is_read(void **unused) {
    (void)unused;
    bool cut;
    int64_t offset;
    write_test_log();
    assert_int_equal(read_test_log(&cut, &offset), EVENTS);
    assert_false(cut);
}

static void liblcm_reads_it(void **unused) {
    (void)unused;
    write_test_log();
    lcm_eventlog_t *log = lcm_eventlog_create(file, "r");
    for (int i = 0; i < EVENTS; i++) {
        lcm_eventlog_event_t *e = lcm_eventlog_read_next_event(log);
        assert_non_null(e);
        assert_int_equal(e->eventnum, i);
        assert_is_event(&(struct log_event){.utime_us = e->timestamp, .channel = e->channel, .data = e->data, .size = e->datalen}, i);
        lcm_eventlog_free_event(e);
    }
    assert_null(lcm_eventlog_read_next_event(log));
    lcm_eventlog_destroy(log);
}

/* liblcm writes this log, so only the reader is tested. The sizes are around the size of the
 * reader's buffer. */
static void events_of_any_size_are_read(void **unused) {
    (void)unused;
    static const int sizes[] = {0, 1, 262144 - 28 - 1, 262144 - 28, 262144 - 27, 3, 5000000, 0, 70, 262143, 10};
    enum { SIZES = sizeof sizes / sizeof *sizes };
    unsigned char *data = malloc(5000000);
    struct log_reader *r;
    struct log_event e;
    struct error error;
    for (int k = 0; k < 5000000; k++) data[k] = (unsigned char)(k * 31 >> 3);
    lcm_eventlog_t *log = lcm_eventlog_create(file, "w");
    for (int i = 0; i < SIZES; i++) {
        char channel[] = {(char)('a' + i), '\0'};
        lcm_eventlog_event_t event = {.timestamp = -i, .channellen = 1, .channel = channel, .datalen = sizes[i], .data = data};
        assert_int_equal(lcm_eventlog_write_event(log, &event), 0);
    }
    lcm_eventlog_destroy(log);
    assert_int_equal(log_open(&r, file, &error), 0);
    for (int i = 0; i < SIZES; i++) {
        assert_int_equal(log_next(r, &e), 1);
        assert_true(e.utime_us == -i && e.channel[0] == 'a' + i && e.channel[1] == '\0' && e.size == sizes[i]);
        assert_memory_equal(e.data, data, (size_t)e.size);
    }
    assert_int_equal(log_next(r, &e), 0);
    log_release(r);
    free(data);
}

static unsigned char *load(int64_t *size) {
    FILE *f = fopen(file, "rb");
    fseek(f, 0, SEEK_END);
    *size = ftell(f);
    rewind(f);
    unsigned char *bytes = malloc((size_t)*size);
    assert_int_equal(fread(bytes, 1, (size_t)*size, f), *size);
    fclose(f);
    return bytes;
}

static void store(const unsigned char *bytes, int64_t size) {
    FILE *f = fopen(file, "wb");
    assert_int_equal(fwrite(bytes, 1, (size_t)size, f), size);
    fclose(f);
}

/* Returns the offset of event i, or the size of the log for i = EVENTS. */
static int64_t begin_of(int i) {
    int64_t offset = 0;
    for (int k = 0; k < i; k++) offset += HEADER + (int64_t)strlen(channel_of(k)) + size_of(k);
    return offset;
}

static void a_log_cut_anywhere_is_read_up_to_the_cut(void **unused) {
    (void)unused;
    slow_case();
    int64_t size, offset;
    bool cut;
    write_test_log();
    unsigned char *bytes = load(&size);
    assert_int_equal(size, begin_of(EVENTS));
    for (int64_t end = 0, whole = 0; end <= size; end++) {
        while (whole < EVENTS && begin_of((int)whole + 1) <= end) whole++;
        store(bytes, end);
        assert_int_equal(read_test_log(&cut, &offset), whole);
        assert_int_equal(cut, end != begin_of((int)whole));
        assert_int_equal(offset, begin_of((int)whole));
    }
    free(bytes);
}

/* Writes another word into the header of event 5, and asserts that the five events before it are
 * read and that the place is named. */
static void assert_stops(int word_offset, uint32_t word) {
    int64_t size, offset;
    bool cut;
    write_test_log();
    unsigned char *bytes = load(&size), *place = bytes + begin_of(5) + word_offset;
    for (int i = 0; i < 4; i++) place[i] = (unsigned char)(word >> (24 - 8 * i));
    store(bytes, size);
    free(bytes);
    assert_int_equal(read_test_log(&cut, &offset), 5);
    assert_true(cut);
    assert_int_equal(offset, begin_of(5));
}

static void lengths_that_cannot_be_end_the_log(void **unused) {
    (void)unused;
    static const uint32_t lengths[] = {0, 1000, 0x7fffffff, 0x80000000, 0xffffffff};
    assert_stops(0, 0xEDA1DA02);
    for (int i = 0; i < 5; i++) {
        assert_stops(20, lengths[i]);
        if (lengths[i] > 0 && lengths[i] != 1000) assert_stops(24, lengths[i]);
    }
    assert_stops(28, 0x48005845); /* this word puts a zero byte into the channel's name */
}

static void a_wrong_length_loses_what_follows_it_only(void **unused) {
    (void)unused;
    struct log_reader *r;
    struct log_event e;
    struct error error;
    int64_t size, offset;
    write_test_log();
    unsigned char *bytes = load(&size);
    bytes[begin_of(5) + 27] ^= 1;
    store(bytes, size);
    free(bytes);
    assert_int_equal(log_open(&r, file, &error), 0);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(log_next(r, &e), 1);
        assert_is_event(&e, i);
    }
    assert_int_equal(log_next(r, &e), 1); /* the length is off by one, so the event has a byte more
                                           * or less */
    assert_int_equal(log_next(r, &e), 0);
    assert_true(log_cut(r, &offset));
    log_release(r);
}

static void garbage_is_survived(void **unused) {
    (void)unused;
    int64_t size, offset;
    uint64_t random = 5;
    write_test_log();
    unsigned char *bytes = load(&size), *bad = malloc((size_t)size);
    for (int round = 0; round < 1500; round++) {
        struct log_reader *r;
        struct log_event e;
        struct error error;
        int64_t total = 0;
        memcpy(bad, bytes, (size_t)size);
        for (int i = 0; i < 3; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            int64_t at = (int64_t)((random >> 33) % (uint64_t)size);
            bad[round % 2 ? at : begin_of((int)(at % EVENTS)) + at % HEADER] = (unsigned char)(random >> 25);
        }
        store(bad, size);
        if (log_open(&r, file, &error)) continue;
        while (log_next(r, &e)) {
            total += HEADER + (int64_t)strlen(e.channel) + e.size;
            for (int k = 0; k < e.size; k++) random += ((const unsigned char *)e.data)[k];
        }
        log_cut(r, &offset);
        assert_int_equal(offset, total);
        log_release(r);
    }
    free(bytes);
    free(bad);
}

static void a_length_takes_no_memory_before_its_bytes_are_there(void **unused) {
    (void)unused;
    /* the header announces 64 MiB of data */
    static const unsigned char head[HEADER + 1] = {0xED, 0xA1, 0xDA, 0x01, [23] = 1, [24] = 0x04, [HEADER] = 'A'};
    struct log_reader *r;
    struct log_event e;
    struct error error;
    store(head, sizeof head);
    struct mallinfo2 before = mallinfo2();
    assert_int_equal(log_open(&r, file, &error), 0);
    assert_int_equal(log_next(r, &e), 0);
    struct mallinfo2 after = mallinfo2();
    assert_true(after.uordblks + after.hblkhd < before.uordblks + before.hblkhd + (1 << 20));
    log_release(r);
}

static void assert_says(const struct error *error, int status, const char *name, const char *reason) {
    assert_int_equal(error->status, status);
    if (!strstr(error->text, name) || !strstr(error->text, reason)) fail_msg("\"%s\" names neither %s nor %s", error->text, name, reason);
}

static void what_cannot_be_read_is_named(void **unused) {
    (void)unused;
    struct log_reader *r;
    struct log_event e;
    struct error error;
    int64_t offset;
    unlink(file);
    assert_int_equal(log_open(&r, file, &error), STATUS_IO);
    assert_says(&error, STATUS_IO, file, "No such file");
    assert_int_equal(log_open(&r, path, &error), STATUS_IO);
    assert_says(&error, STATUS_IO, path, "directory");
    store((const unsigned char *)"t_s,l1_m\n", 9);
    assert_int_equal(log_open(&r, file, &error), STATUS_IO);
    assert_says(&error, STATUS_IO, file, "not an LCM event log");
    store((const unsigned char *)"", 0);
    assert_int_equal(log_open(&r, file, &error), 0);
    assert_int_equal(log_next(r, &e), 0);
    assert_false(log_cut(r, &offset));
    log_release(r);
}

static void what_cannot_be_written_is_named_at_once(void **unused) {
    (void)unused;
    struct log_writer *w;
    struct error error = {0}, again = {0};
    assert_int_equal(log_create(&w, "/nowhere/at/all.lcm", &error), STATUS_IO);
    assert_says(&error, STATUS_IO, "/nowhere/at/all.lcm", "No such file");
    assert_int_equal(log_create(&w, path, &error), STATUS_IO);
    assert_says(&error, STATUS_IO, path, "directory");
    assert_int_equal(log_create(&w, "/dev/full", &error), 0); /* this device opens like any other
                                                               * file */
    assert_int_equal(log_write(w, 0, "A", "x", 1, &error), STATUS_IO);
    assert_says(&error, STATUS_IO, "/dev/full", "No space left");
    assert_int_equal(log_write(w, 0, "A", "x", 1, &again), STATUS_IO);
    assert_string_equal(again.text, error.text);
    assert_int_equal(log_flush(w, &again), STATUS_IO);
    assert_int_equal(log_close(w, &again), STATUS_IO);
}

/* The disk fills up later. A limit of the file's size simulates that, because write(2) reports both
 * alike. */
static void a_disk_that_fills_up_is_said_and_keeps_what_it_has(void **unused) {
    (void)unused;
    enum { LIMIT = 100000, SIZE = 417 };
    static const unsigned char data[SIZE] = {1};
    struct rlimit before, limit;
    struct log_writer *w;
    struct error error = {0};
    int written = 0;
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before);
    limit = before;
    limit.rlim_cur = LIMIT;
    unlink(file);
    assert_int_equal(log_create(&w, file, &error), 0);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    while (log_write(w, written, "HEXID_STATE", data, SIZE, &error) == 0 && written < LIMIT) written++;
    assert_says(&error, STATUS_IO, file, "too large");
    assert_int_equal(log_close(w, &error), STATUS_IO);
    setrlimit(RLIMIT_FSIZE, &before);

    struct log_reader *r;
    struct log_event e;
    int read = 0;
    assert_int_equal(log_open(&r, file, &error), 0);
    while (log_next(r, &e)) assert_int_equal(e.utime_us, read++);
    log_release(r);
    assert_true(read <= written && read >= LIMIT / (HEADER + 11 + SIZE) - 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_read),
        cmocka_unit_test(liblcm_reads_it),
        cmocka_unit_test(events_of_any_size_are_read),
        cmocka_unit_test(a_log_cut_anywhere_is_read_up_to_the_cut),
        cmocka_unit_test(lengths_that_cannot_be_end_the_log),
        cmocka_unit_test(a_wrong_length_loses_what_follows_it_only),
        cmocka_unit_test(garbage_is_survived),
        cmocka_unit_test(a_length_takes_no_memory_before_its_bytes_are_there),
        cmocka_unit_test(what_cannot_be_read_is_named),
        cmocka_unit_test(what_cannot_be_written_is_named_at_once),
        cmocka_unit_test(a_disk_that_fills_up_is_said_and_keeps_what_it_has),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
