/* The Modbus back-end in one process with a device whose silence the test controls, and the line
 * below it. Only claims about a time-out depend on a clock. */
#include "support.h"

#include <arpa/inet.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "hal.h"
#include "modbus_link.h"
#include "modbus_map.h"
#include "units.h"

enum {
    MBAP = 7,
    FUNCTION_READ = 3,
    FUNCTION_WRITE = 16,
    FUNCTION_EXCHANGE = 23,
    FRAME = 260,
    VALUES = MBAP + 10,
    FAILED = 0x80,
    BUSY = 6,
    OWNER = 0x0a000007
};

/* A device that serves one connection after another. It answers at once until `held`; then it
 * signals (`asked`) and waits (`go`) at every function 23. */
struct fake {
    pthread_t thread;
    int listener, port;
    _Atomic bool held, hang_up; /* hang_up: closes the connection instead of the next answer */
    sem_t asked, go;
    _Atomic int valve, first;   /* command of leg 1 in the last function 23, and in the first one of
                                 * this connection */
    _Atomic int supply;         /* supply output in the last function 23 */
    _Atomic int greeted;        /* number of claims */
    _Atomic int cycles;         /* number of functions 23 */
    _Atomic int foreign;        /* number of writes by others that it reports */
    _Atomic bool owned, usurped; /* another master owns the device at the claim; another one takes
                                  * it over in a cycle */
    int watchdog_ms, longer_ms; /* the configured time, and the excess of the time that is read
                                 * back */
    uint16_t sample;
    _Atomic bool twin;          /* a second device answers each function 23 as well */
    _Atomic int refuses;        /* the device's exception to function 3; 0: none */
    _Atomic int behind;         /* number of commands by which each answer is behind */
    long byte_ns;               /* gap between bytes of an answer to function 23; 0: none */
};

static void put(uint8_t *to, int value) { to[0] = (uint8_t)(value >> 8), to[1] = (uint8_t)value; }
static int get(const uint8_t *from) { return from[0] << 8 | from[1]; }

static bool receive_all(int fd, uint8_t *to, size_t size) {
    for (ssize_t n; size > 0; to += n, size -= (size_t)n)
        if ((n = recv(fd, to, size, 0)) <= 0) return false;
    return true;
}

/* Writes the values of an answer to `out`. */
static void fill(struct fake *f, const uint8_t *request, uint8_t *out) {
    int address = get(request + MBAP + 1);
    if (request[MBAP] == FUNCTION_EXCHANGE) {
        put(out, get(request + VALUES + 2 * (MODBUS_COMMAND - MODBUS_WRITE_FROM)) - f->behind);
        put(out + 2, ++f->sample);
        put(out + 2 * (MODBUS_FOREIGN - MODBUS_READ_FROM), f->foreign);
    } else if (address == MODBUS_IDENTITY) {
        put(out, MODBUS_IS_HEXID);
        put(out + 2, MODBUS_MAP_VERSION);
    } else if (address == MODBUS_OWNER) {
        put(out, OWNER >> 16);
        put(out + 2, OWNER & 0xffff);
    } else put(out, address == MODBUS_WATCHDOG_MS ? f->watchdog_ms + f->longer_ms : f->foreign);
}

/* True if the device answers with exception 6, because another master owns it. */
static bool refused(const struct fake *f, const uint8_t *request) {
    return (request[MBAP] == FUNCTION_WRITE && f->owned) || (request[MBAP] == FUNCTION_EXCHANGE && f->usurped);
}

static void answer(struct fake *f, int fd, const uint8_t *request) {
    uint8_t out[FRAME] = {0};
    size_t size = MBAP + 5; /* function 16: address and count are echoed */
    memcpy(out, request, MBAP + 5);
    if (refused(f, request)) {
        out[MBAP] |= FAILED, out[MBAP + 1] = BUSY;
        size = MBAP + 2;
    } else if (request[MBAP] != FUNCTION_WRITE) {
        size_t values = request[MBAP + 4];
        size = MBAP + 2 + 2 * values;
        memset(out + MBAP + 1, 0, size - MBAP - 1);
        out[MBAP + 1] = (uint8_t)(2 * values);
        fill(f, request, out + MBAP + 2);
    } else {
        f->watchdog_ms = get(request + MBAP + 6);
        f->greeted++;
    }
    if (f->refuses && request[MBAP] == FUNCTION_READ)
        out[MBAP] = FUNCTION_READ | FAILED, out[MBAP + 1] = (uint8_t)f->refuses, size = MBAP + 2;
    put(out + 4, (int)size - 6);
    if (f->twin && request[MBAP] == FUNCTION_EXCHANGE) memcpy(out + size, out, size), size *= 2;
    size_t piece = f->byte_ns && request[MBAP] == FUNCTION_EXCHANGE ? 1 : size;
    for (size_t i = 0; i < size; i += piece) {
        const struct timespec pause = {.tv_nsec = f->byte_ns};
        if (piece == 1) nanosleep(&pause, NULL);
        if (send(fd, out + i, piece, MSG_NOSIGNAL) != (ssize_t)piece) return;
    }
}

static void serve(struct fake *f, int fd) {
    uint8_t request[FRAME];
    bool first = true;
    while (receive_all(fd, request, 6) && receive_all(fd, request + 6, request[5])) {
        if (request[MBAP] == FUNCTION_EXCHANGE) {
            f->valve = (int16_t)get(request + VALUES + 2 * (MODBUS_VALVE - MODBUS_WRITE_FROM));
            f->supply = get(request + VALUES + 2 * (MODBUS_SUPPLY - MODBUS_WRITE_FROM));
            f->cycles++;
            if (first) f->first = (int)f->valve;
            first = false;
            if (f->held) sem_post(&f->asked), sem_wait(&f->go);
            if (atomic_exchange(&f->hang_up, false)) return;
        }
        answer(f, fd, request);
    }
}

static void *fake_thread(void *argument) {
    struct fake *f = argument;
    for (int fd; (fd = accept(f->listener, NULL, NULL)) >= 0;) {
        serve(f, fd);
        close(fd);
    }
    return NULL;
}

static void fake_start(struct fake *f) {
    struct sockaddr_in a = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof a;
    sem_init(&f->asked, 0, 0);
    sem_init(&f->go, 0, 0);
    f->listener = socket(AF_INET, SOCK_STREAM, 0);
    assert_int_equal(bind(f->listener, (struct sockaddr *)&a, size), 0);
    assert_int_equal(listen(f->listener, 1), 0);
    assert_int_equal(getsockname(f->listener, (struct sockaddr *)&a, &size), 0);
    f->port = ntohs(a.sin_port);
    assert_int_equal(pthread_create(&f->thread, NULL, fake_thread, f), 0);
}

/* Ends the fake device, after its clients have disconnected. */
static void fake_stop(struct fake *f) {
    shutdown(f->listener, SHUT_RDWR);
    pthread_join(f->thread, NULL);
    close(f->listener);
    sem_destroy(&f->asked);
    sem_destroy(&f->go);
}

/* A back-end, whose loop is the test, and its device. */
struct session {
    struct fake device;
    struct params params;
    struct hal *hal;
    struct error error;
    double watchdog_s, sensor_age_s; /* 0: the longest */
};

static int session_open(struct session *s) {
    char url[64];
    fake_start(&s->device);
    config_default(&s->params);
    /* Both are at the maximum that the configuration allows, so that no command of these tests is
     * too old. */
    s->params.limits.sensor_age_s = s->sensor_age_s > 0.0 ? s->sensor_age_s : 1.0;
    s->params.device.watchdog_s = s->watchdog_s > 0.0 ? s->watchdog_s : 10.0;
    snprintf(url, sizeof url, "modbus:tcp://127.0.0.1:%d", s->device.port);
    return hal_open(&s->hal, url, &s->params, 1, &s->error);
}

static void session_begin(struct session *s) { assert_int_equal(session_open(s), 0); }

static void command_motion(struct session *s) {
    static const struct hal_command moving = {.valve = {1, 1, 1, 1, 1, 1}};
    s->hal->ops->write(s->hal, &moving);
}

/* Lets the device receive a command of motion, and then stay silent until it is released. */
static void session_hold(struct session *s) {
    s->device.held = true;
    command_motion(s);
    sem_wait(&s->device.asked);
}

static void session_release(struct session *s) {
    s->device.held = false;
    sem_post(&s->device.go);
}

static void session_end(struct session *s) {
    if (s->hal) s->hal->ops->close(s->hal);
    fake_stop(&s->device);
}

/* While the device is silent, the loop commands full opening for longer than any queue, then the
 * centre. The device must receive the centre next, because a replaced command is never sent. */
static void a_command_that_safe_has_replaced_is_never_sent(void **unused) {
    (void)unused;
    struct session s = {0};
    session_begin(&s);
    session_hold(&s);
    assert_int_equal(s.device.valve, 32767);
    for (int i = 0; i < 20; i++) command_motion(&s);
    s.hal->ops->safe(s.hal);
    sem_post(&s.device.go);
    /* calls safe(), as the loop does in every cycle that does not drive */
    while (sem_trywait(&s.device.asked)) s.hal->ops->safe(s.hal);
    int told = s.device.valve;
    session_release(&s);
    session_end(&s);
    assert_int_equal(told, 0);
}

/* A toggle of the supply output that safe() has replaced is never sent: only a loop that drives
 * toggles it. */
static void a_change_of_the_supply_that_safe_has_replaced_is_never_sent(void **unused) {
    (void)unused;
    static const struct hal_command changed = {.supply = true};
    struct session s = {0};
    session_begin(&s);
    session_hold(&s);
    int before = s.device.supply;
    s.hal->ops->write(s.hal, &changed);
    s.hal->ops->safe(s.hal);
    sem_post(&s.device.go);
    sem_wait(&s.device.asked);
    int told = s.device.supply;
    session_release(&s);
    session_end(&s);
    assert_int_equal(told, before);
}

/* A command waits while the connection breaks and the loop ends. The first command over the new
 * connection is the final centre. */
static void a_command_from_before_a_new_connection_is_never_sent(void **unused) {
    (void)unused;
    struct session s = {0};
    struct hal_sample sample;
    session_begin(&s);
    session_hold(&s);
    command_motion(&s);
    s.device.hang_up = true;
    session_release(&s);
    while (s.device.greeted < 2) sched_yield();
    while (s.hal->ops->read(s.hal, 1, &sample)) sched_yield();
    session_end(&s);
    assert_int_equal(s.device.first, 0);
}

/* The answer is complete and has the right transaction, but belongs to another command. */
static void an_answer_to_another_command_is_refused(void **unused) {
    (void)unused;
    slow_case();
    struct session s = {.device.behind = 1};
    int status = session_open(&s);
    session_end(&s);
    assert_int_equal(status, STATUS_IO);
    assert_non_null(strstr(s.error.text, "an answer to another request"));
}

/* The message names the owner, and only the claim was written. */
static void a_machine_with_another_master_is_refused(void **unused) {
    (void)unused;
    struct session s = {.device.owned = true};
    int status = session_open(&s);
    session_end(&s);
    assert_int_equal(status, STATUS_UNSAFE);
    assert_non_null(strstr(s.error.text, "another master, 10.0.0.7, commands this machine: end it first"));
    assert_int_equal(s.device.cycles, 0);
}

/* SAFETY: if the watchdog reads back with another time than was set, it cannot be relied on to stop
 * the machine. */
static void a_watchdog_that_reads_back_as_another_one_is_refused(void **unused) {
    (void)unused;
    struct session s = {.device.longer_ms = 1};
    int status = session_open(&s);
    session_end(&s);
    assert_int_equal(status, STATUS_UNSAFE);
    assert_non_null(strstr(s.error.text, "set to 10000 ms and is 10001 ms"));
    assert_int_equal(s.device.cycles, 0);
}

/* Runs cycles until a sample is new; returns all their flags. */
static uint32_t cycle_flags(struct session *s) {
    struct hal_sample sample = {.flags = SAMPLE_STALE};
    uint32_t flags = 0;
    int before = s->device.cycles;
    s->hal->ops->safe(s->hal);
    while (s->device.cycles == before) sched_yield();
    while (sample.flags & SAMPLE_STALE) {
        s->hal->ops->read(s->hal, 1, &sample);
        flags |= sample.flags;
        sched_yield();
    }
    return flags;
}

/* Each write by others is reported once; earlier writes do not concern this master. */
static void what_others_wrote_is_told_with_the_next_sample(void **unused) {
    (void)unused;
    struct session s = {.device.foreign = 65535};
    char text[100];
    session_begin(&s);
    uint32_t alone = cycle_flags(&s) | cycle_flags(&s), after = 0;
    s.device.foreign = 0; /* one more write, because the count has 16 bits */
    while (!(cycle_flags(&s) & SAMPLE_FOREIGN)) continue;
    for (int i = 0; i < 5; i++) after |= cycle_flags(&s);
    s.hal->ops->describe(s.hal, text, sizeof text);
    session_end(&s);
    assert_false(alone & SAMPLE_FOREIGN);
    assert_false(after & SAMPLE_FOREIGN);
    assert_string_equal(text, "another master tried to command this machine");
}

/* The refusal itself is reported, even if the next claim would succeed again. */
static void a_command_refused_for_another_master_is_told(void **unused) {
    (void)unused;
    struct session s = {0};
    struct hal_sample sample = {0};
    session_begin(&s);
    s.device.usurped = true;
    while (!(sample.flags & SAMPLE_FOREIGN)) {
        s.hal->ops->safe(s.hal);
        s.hal->ops->read(s.hal, 1, &sample);
        sched_yield();
    }
    session_end(&s);
}

/* The daemon was away for so long that another master has the machine, so the daemon never writes
 * again. */
static void a_machine_that_has_another_master_by_now_is_told(void **unused) {
    (void)unused;
    /* ten time-outs in a row count as a lost connection, and so does one refusal */
    struct session s = {.sensor_age_s = 0.05};
    struct hal_sample sample = {0};
    char text[100];
    session_begin(&s);
    s.device.owned = s.device.usurped = true;
    while (!(sample.flags & SAMPLE_FOREIGN)) {
        s.hal->ops->safe(s.hal);
        s.hal->ops->read(s.hal, 1, &sample);
        sched_yield();
    }
    s.hal->ops->describe(s.hal, text, sizeof text);
    int written = s.device.cycles;
    while (!s.hal->ops->read(s.hal, 1, &sample)) sched_yield();
    for (int i = 0; i < 1000; i++) s.hal->ops->safe(s.hal), sched_yield();
    int written_later = s.device.cycles;
    session_end(&s);
    assert_string_equal(text, "another master commands this machine");
    assert_true(written_later <= written + 1); /* a write may have been under way */
}

/* The loop takes longer than the watchdog to start; meanwhile the claim is kept. */
static void the_machine_is_kept_until_the_loop_begins(void **unused) {
    (void)unused;
    struct session s = {.watchdog_s = 0.02};
    session_begin(&s);
    while (s.device.cycles < 5) sched_yield();
    int valve = s.device.valve;
    session_end(&s);
    assert_int_equal(valve, 0);
}

/* SAFETY: the device's watchdog detects a stopped loop, so nothing else may reset it. */
static void the_machine_is_not_kept_for_a_loop_that_has_stopped(void **unused) {
    (void)unused;
    static const struct timespec many_watchdogs = {.tv_nsec = 200000000};
    struct session s = {.watchdog_s = 0.02};
    session_begin(&s);
    cycle_flags(&s);
    cycle_flags(&s); /* completes the exchange that began before the first cycle */
    int cycles = s.device.cycles;
    nanosleep(&many_watchdogs, NULL);
    int later = s.device.cycles;
    session_end(&s);
    assert_int_equal(later, cycles);
}

/* Waiting for the device at the end has a time-out as well. */
static void close_ends_though_the_device_is_silent(void **unused) {
    (void)unused;
    struct session s = {0};
    session_begin(&s);
    session_hold(&s);
    s.hal->ops->close(s.hal);
    s.hal = NULL;
    session_release(&s);
    session_end(&s);
}

/* Returns the highest SCHED_FIFO priority among the other threads of this process, 0: none. */
static int highest_priority(void) {
    DIR *tasks = opendir("/proc/self/task");
    int highest = 0;
    for (struct dirent *e; (e = readdir(tasks));) {
        pid_t id = atoi(e->d_name);
        struct sched_param p;
        if (id <= 0 || id == gettid() || sched_getscheduler(id) != SCHED_FIFO || sched_getparam(id, &p)) continue;
        if (p.sched_priority > highest) highest = p.sched_priority;
    }
    closedir(tasks);
    return highest;
}

/* Returns the priority of the back-end's thread while the test's thread, which is its loop, has
 * priority `own`. When the device gets a request, the back-end's thread has started its work. */
static int priority_below(int own) {
    struct session s = {0};
    struct hal_sample sample;
    session_begin(&s);
    s.device.held = true;
    if (own && pthread_setschedparam(pthread_self(), SCHED_FIFO, &(struct sched_param){.sched_priority = own})) own = -1;
    s.hal->ops->read(s.hal, 1, &sample);
    s.hal->ops->safe(s.hal);
    sem_wait(&s.device.asked);
    int found = own < 0 ? own : highest_priority();
    pthread_setschedparam(pthread_self(), SCHED_OTHER, &(struct sched_param){0});
    session_release(&s);
    session_end(&s);
    return found;
}

static void the_thread_is_real_time_only_when_the_loop_is(void **unused) {
    (void)unused;
    assert_int_equal(priority_below(0), 0);
    int found = priority_below(10);
    if (found < 0) skip_because("this user has no SCHED_FIFO");
    assert_int_equal(found, 9);
}

/* An answer of 70 bytes takes 3.5 s, with 50 ms between bytes. A time-out that every byte restarts
 * would not end it, because each byte comes within 0.1 s of the one before. */
static void an_answer_that_trickles_is_given_up(void **unused) {
    (void)unused;
    struct fake f = {.byte_ns = 50000000};
    struct modbus_address_parts a = {.name = "127.0.0.1"};
    struct modbus_link *link;
    struct error error;
    uint16_t written[MODBUS_WRITTEN] = {1}, read[MODBUS_READ];
    fake_start(&f);
    snprintf(a.port, sizeof a.port, "%d", f.port);
    assert_int_equal(modbus_link_open(&link, &a, 1, 0.1, &error), 0);
    int status = modbus_link_exchange(link, MODBUS_WRITE_FROM, MODBUS_WRITTEN, written, MODBUS_READ_FROM, MODBUS_READ, read);
    int reason = errno;
    modbus_link_close(link);
    fake_stop(&f);
    assert_int_equal(status, -1);
    assert_int_equal(reason, ETIMEDOUT);
}

static void a_second_answer_to_every_request_flags_the_sample_and_is_told(void **unused) {
    (void)unused;
    struct session s = {0};
    struct hal_sample sample = {0};
    char text[200];
    session_begin(&s);
    for (int cycle = 0; cycle < 5; cycle++) {
        int before = s.device.cycles;
        command_motion(&s);
        while (s.device.cycles == before) sched_yield();
        s.hal->ops->read(s.hal, 1 + cycle, &sample);
        assert_false(sample.flags & SAMPLE_TWIN);
    }
    s.device.twin = true;
    while (!(sample.flags & SAMPLE_TWIN)) {
        int before = s.device.cycles;
        command_motion(&s);
        while (s.device.cycles == before) sched_yield();
        s.hal->ops->read(s.hal, 10, &sample);
    }
    s.hal->ops->describe(s.hal, text, sizeof text);
    s.device.twin = false;
    session_end(&s);
    assert_non_null(strstr(text, "two devices"));
}

/* Half a second without an answer means that the server has gone without closing the connection,
 * which is then made again. */
static void a_device_that_is_silent_for_long_is_connected_to_again(void **unused) {
    (void)unused;
    slow_case();
    struct session s = {.sensor_age_s = 0.05};
    struct hal_sample sample;
    session_begin(&s);
    session_hold(&s);
    while (!s.hal->ops->read(s.hal, 1, &sample)) s.hal->ops->safe(s.hal), sched_yield();
    session_release(&s);
    while (s.hal->ops->read(s.hal, 1, &sample)) sched_yield();
    int claims = s.device.greeted;
    session_end(&s);
    assert_true(claims >= 2);
}

/* Two latches are far apart: the command between them was in force for too long, however fresh the
 * second sample is. */
static void a_sample_latched_off_the_grid_is_late(void **unused) {
    (void)unused;
    static const struct timespec ten_periods = {.tv_nsec = 20000000};
    struct session s = {0};
    struct hal_sample sample = {.flags = SAMPLE_STALE};
    session_begin(&s);
    cycle_flags(&s);
    nanosleep(&ten_periods, NULL);
    for (s.hal->ops->safe(s.hal); sample.flags & SAMPLE_STALE; sched_yield()) s.hal->ops->read(s.hal, 1, &sample);
    session_end(&s);
    assert_true(sample.flags & SAMPLE_LATE);
}

static void the_last_word_is_the_centre(void **unused) {
    (void)unused;
    struct session s = {0};
    session_begin(&s);
    command_motion(&s);
    while (s.device.valve != 32767) sched_yield();
    session_end(&s);
    assert_int_equal(s.device.valve, 0);
}

/* Returns the number of this process's threads that block the signals by which it is ended (from
 * /proc). */
static int threads_without_signals(void) {
    static const int ends[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGALRM};
    DIR *tasks = opendir("/proc/self/task");
    int count = 0;
    for (struct dirent *e; (e = readdir(tasks));) {
        char path[300], line[200];
        uint64_t blocked = 0, all = 0;
        snprintf(path, sizeof path, "/proc/self/task/%s/status", e->d_name);
        FILE *status = fopen(path, "r");
        while (status && fgets(line, sizeof line, status)) sscanf(line, "SigBlk: %" SCNx64, &blocked);
        if (status) fclose(status);
        for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) all |= 1ull << (ends[i] - 1);
        count += (blocked & all) == all;
    }
    closedir(tasks);
    return count;
}

static void no_signal_interrupts_the_thread_that_talks(void **unused) {
    (void)unused;
    struct session s = {0};
    int before = threads_without_signals();
    session_begin(&s);
    int during = threads_without_signals();
    session_end(&s);
    assert_int_equal(during, before + 1);
}

/* A slow device first answers an earlier request, and then the present one. */
static void a_device_that_is_late_is_no_second_one(void **unused) {
    (void)unused;
    struct session s = {.sensor_age_s = 0.02}; /* after 0.5 s of such time-outs the connection is
                                                * abandoned */
    struct hal_sample sample;
    uint32_t flags = 0;
    session_begin(&s);
    cycle_flags(&s);
    s.device.behind = 1;
    s.device.twin = true;
    for (int end = s.device.cycles + 20; s.device.cycles < end; sched_yield()) {
        s.hal->ops->safe(s.hal);
        s.hal->ops->read(s.hal, 1, &sample);
        flags |= sample.flags;
    }
    session_end(&s);
    assert_false(flags & SAMPLE_TWIN);
}

static void an_exception_to_the_first_question_is_no_missing_answer(void **unused) {
    (void)unused;
    static const int codes[] = {1, 2, 4, 10, 11};
    for (size_t i = 0; i < sizeof codes / sizeof *codes; i++) {
        struct session s = {.device.refuses = codes[i]};
        char named[20];
        snprintf(named, sizeof named, "exception %d,", codes[i]);
        assert_int_equal(session_open(&s), STATUS_IO);
        fake_stop(&s.device);
        if (!strstr(s.error.text, "was answered") || !strstr(s.error.text, named)) fail_msg("%s", s.error.text);
        assert_null(strstr(s.error.text, "wiring, "));
        assert_null(strstr(s.error.text, "baud rate"));
    }
}

static uint16_t crc(const uint8_t *data, size_t size) {
    uint16_t c = 0xffff;
    for (size_t i = 0; i < size; i++) {
        c ^= data[i];
        for (int k = 0; k < 8; k++) c = (uint16_t)(c & 1 ? c >> 1 ^ 0xa001 : c >> 1);
    }
    return c;
}

/* A serial line; the test is the device at its end. */
struct serial {
    int device;
    struct modbus_link *link;
};

static void serial_open(struct serial *s, int baud) {
    struct modbus_address_parts a = {.serial = true, .baud = baud};
    struct termios raw;
    struct error error = {0};
    s->device = posix_openpt(O_RDWR | O_NOCTTY);
    assert_true(s->device >= 0 && !grantpt(s->device) && !unlockpt(s->device) && !tcgetattr(s->device, &raw));
    cfmakeraw(&raw);
    tcsetattr(s->device, TCSANOW, &raw);
    snprintf(a.name, sizeof a.name, "%s", ptsname(s->device));
    assert_int_equal(modbus_link_open(&s->link, &a, 1, 0.05, &error), 0);
}

static void serial_close(struct serial *s) {
    modbus_link_close(s->link);
    close(s->device);
}

static void serial_answer(const struct serial *s, uint16_t sample) {
    uint8_t out[5 + 2 * MODBUS_READ] = {1, FUNCTION_EXCHANGE, 2 * MODBUS_READ, (uint8_t)(sample >> 8), (uint8_t)sample};
    uint16_t c = crc(out, sizeof out - 2);
    out[sizeof out - 2] = (uint8_t)c, out[sizeof out - 1] = (uint8_t)(c >> 8);
    assert_int_equal(write(s->device, out, sizeof out), sizeof out);
}

static int serial_exchange(const struct serial *s, uint16_t read[MODBUS_READ]) {
    static const uint16_t written[MODBUS_WRITTEN] = {1};
    return modbus_link_exchange(s->link, MODBUS_WRITE_FROM, MODBUS_WRITTEN, written, MODBUS_READ_FROM, MODBUS_READ, read);
}

static void a_late_answer_on_a_serial_line_is_not_taken_for_the_next_one(void **unused) {
    (void)unused;
    struct serial s;
    uint16_t read[MODBUS_READ] = {0};
    serial_open(&s, 115200);
    int first = serial_exchange(&s, read);
    serial_answer(&s, 77); /* answers the first request, when nobody waits for that answer any
                            * more */
    int second = serial_exchange(&s, read);
    serial_close(&s);
    assert_int_equal(first, -1);
    assert_int_equal(second, -1);
    assert_int_not_equal(read[0], 77);
}

/* The claim does not depend on the machine's speed, because the silence is a lower bound. */
static void a_request_waits_for_the_silence_after_what_was_before(void **unused) {
    (void)unused;
    static const int bauds[] = {1200, 115200};
    for (int i = 0; i < 2; i++) {
        struct serial s;
        struct timespec t;
        uint16_t read[MODBUS_READ];
        serial_open(&s, bauds[i]);
        clock_gettime(CLOCK_MONOTONIC, &t);
        assert_int_equal(serial_exchange(&s, read), -1); /* nobody answers within 50 ms */
        serial_exchange(&s, read);
        int64_t between_ns = modbus_link_begun_ns(s.link) - (t.tv_sec * NS_PER_S + t.tv_nsec);
        serial_close(&s);
        assert_true(between_ns >= 50000000 + ns_from_seconds(modbus_silence_s(bauds[i])));
    }
}

/* Reads the next request at the device's end; false if the line has ended. */
static bool serial_request(const struct serial *s, uint8_t request[8]) {
    for (size_t got = 0; got < 8;) {
        ssize_t n = read(s->device, request + got, 8 - got);
        if (n <= 0) return false;
        got += (size_t)n;
    }
    return true;
}

/* Answers two requests; the first answer is corrupted. */
static void *answers_badly_at_first(void *argument) {
    static const uint8_t who[] = {1, 3, 4, 0x48, 0x45, 0, MODBUS_MAP_VERSION};
    const struct serial *s = argument;
    uint8_t request[8], out[sizeof who + 2];
    uint16_t c = crc(who, sizeof who);
    memcpy(out, who, sizeof who);
    for (int n = 0; serial_request(s, request); n++) {
        out[sizeof who] = (uint8_t)(n ? c : ~c), out[sizeof who + 1] = (uint8_t)(c >> 8);
        if (write(s->device, out, sizeof out) < 0) break;
    }
    return NULL;
}

static void *echoes_all(void *argument) {
    const struct serial *s = argument;
    uint8_t request[8];
    while (serial_request(s, request))
        if (write(s->device, request, sizeof request) < 0) break;
    return NULL;
}

static int greet_with(void *(*device)(void *), struct error *error) {
    struct serial s;
    pthread_t thread;
    uint16_t who[2] = {0};
    serial_open(&s, 115200);
    modbus_link_set_timeout(s.link, 1.0);
    assert_int_equal(pthread_create(&thread, NULL, device, &s), 0);
    int status = modbus_link_greet(s.link, "rtu:line", who, error);
    if (!status) assert_int_equal(who[0], MODBUS_IS_HEXID);
    modbus_link_close(s.link); /* hangs up, so that the read at the device's end returns */
    pthread_join(thread, NULL);
    close(s.device);
    return status;
}

static void a_device_whose_first_answer_is_spoilt_is_asked_again(void **unused) {
    (void)unused;
    struct error error = {0};
    if (greet_with(answers_badly_at_first, &error)) fail_msg("%s", error.text);
}

static void an_adapter_that_echoes_is_named(void **unused) {
    (void)unused;
    struct error error = {0};
    assert_int_equal(greet_with(echoes_all, &error), STATUS_IO);
    if (!strstr(error.text, "echoes")) fail_msg("%s", error.text);
}

/* libmodbus silently runs a line at 9600 baud if it does not know the rate. */
static void the_line_runs_at_the_rate_of_its_address(void **unused) {
    (void)unused;
    static const speed_t codes[] = {B1200,   B2400,   B4800,   B9600,    B19200,   B38400,   B57600,   B115200,  B230400,  B460800,
                                    B500000, B576000, B921600, B1000000, B1152000, B1500000, B2500000, B3000000, B3500000, B4000000};
    for (size_t i = 0; i < sizeof codes / sizeof *codes; i++) {
        struct serial s;
        struct termios set;
        assert_int_not_equal(modbus_bauds[i], 0);
        serial_open(&s, modbus_bauds[i]);
        assert_int_equal(tcgetattr(s.device, &set), 0);
        serial_close(&s);
        assert_int_equal(cfgetospeed(&set), codes[i]);
    }
    assert_int_equal(modbus_bauds[sizeof codes / sizeof *codes], 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_command_that_safe_has_replaced_is_never_sent),
        cmocka_unit_test(a_change_of_the_supply_that_safe_has_replaced_is_never_sent),
        cmocka_unit_test(a_command_from_before_a_new_connection_is_never_sent),
        cmocka_unit_test(an_answer_to_another_command_is_refused),
        cmocka_unit_test(a_machine_with_another_master_is_refused),
        cmocka_unit_test(a_watchdog_that_reads_back_as_another_one_is_refused),
        cmocka_unit_test(what_others_wrote_is_told_with_the_next_sample),
        cmocka_unit_test(a_command_refused_for_another_master_is_told),
        cmocka_unit_test(a_machine_that_has_another_master_by_now_is_told),
        cmocka_unit_test(the_machine_is_kept_until_the_loop_begins),
        cmocka_unit_test(the_machine_is_not_kept_for_a_loop_that_has_stopped),
        cmocka_unit_test(close_ends_though_the_device_is_silent),
        cmocka_unit_test(the_thread_is_real_time_only_when_the_loop_is),
        cmocka_unit_test(an_answer_that_trickles_is_given_up),
        cmocka_unit_test(a_second_answer_to_every_request_flags_the_sample_and_is_told),
        cmocka_unit_test(a_device_that_is_silent_for_long_is_connected_to_again),
        cmocka_unit_test(a_sample_latched_off_the_grid_is_late),
        cmocka_unit_test(the_last_word_is_the_centre),
        cmocka_unit_test(no_signal_interrupts_the_thread_that_talks),
        cmocka_unit_test(a_device_that_is_late_is_no_second_one),
        cmocka_unit_test(an_exception_to_the_first_question_is_no_missing_answer),
        cmocka_unit_test(a_late_answer_on_a_serial_line_is_not_taken_for_the_next_one),
        cmocka_unit_test(a_request_waits_for_the_silence_after_what_was_before),
        cmocka_unit_test(a_device_whose_first_answer_is_spoilt_is_asked_again),
        cmocka_unit_test(an_adapter_that_echoes_is_named),
        cmocka_unit_test(the_line_runs_at_the_rate_of_its_address),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
