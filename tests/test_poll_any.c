/* Waiting for descriptors while the limit of open files is above and below their number. */
#include "support.h"

#include <errno.h>
#include <sys/resource.h>
#include <unistd.h>

#include "monotonic.h"
#include "poll_any.h"

enum { PIPES = 33, COUNT = 2 * PIPES + 2 }; /* at least as many entries as the daemon has */

static int reader[PIPES], writer[PIPES];
static struct rlimit before;

static void open_pipes(void) {
    for (int i = 0; i < PIPES; i++) {
        int end[2];
        assert_int_equal(pipe(end), 0);
        reader[i] = end[0], writer[i] = end[1];
    }
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
}

static void close_pipes(void) {
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &before), 0);
    for (int i = 0; i < PIPES; i++) close(reader[i]), close(writer[i]);
}

static void limit(rlim_t most) { assert_int_equal(setrlimit(RLIMIT_NOFILE, &(struct rlimit){most, before.rlim_max}), 0); }

/* Makes entries. Every second one is free, as the daemon's places are. */
static void entries(struct pollfd p[COUNT]) {
    for (int i = 0; i < COUNT; i++)
        p[i] = (struct pollfd){.fd = i % 2 || i / 2 >= PIPES ? -1 : reader[i / 2], .events = POLLIN, .revents = 99};
}

static void the_one_that_is_ready_is_found_within_any_limit(void **unused) {
    (void)unused;
    static const rlim_t limits[] = {1024, 68, 67, 20, 3, 1};
    struct pollfd p[COUNT];
    open_pipes();
    for (int l = 0; l < 6; l++)
        for (int i = 0; i < PIPES; i += 8) {
            char byte;
            entries(p);
            limit(limits[l]);
            assert_int_equal(poll_any(p, COUNT, 0, NULL), 0);
            assert_int_equal(write(writer[i], "x", 1), 1);
            assert_int_equal(poll_any(p, COUNT, 60000, NULL), 1);
            for (int k = 0; k < COUNT; k++) assert_int_equal(p[k].revents, k == 2 * i ? POLLIN : 0);
            assert_int_equal(read(reader[i], &byte, 1), 1);
        }
    close_pipes();
}

static double processor_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* poll(2) itself would fail at once instead of waiting, and a loop around it would spin. */
static void a_wait_lasts_as_long_below_the_limit_and_does_not_spin(void **unused) {
    (void)unused;
    struct pollfd p[COUNT];
    open_pipes();
    entries(p);
    limit(20);
    double used_s = processor_s();
    int64_t begun_ms = monotonic_ms();
    assert_int_equal(poll_any(p, COUNT, 300, NULL), 0);
    assert_true(monotonic_ms() - begun_ms >= 299); /* tolerance of 1 ms, because both ends of the
                                                    * wait are rounded */
    assert_below(processor_s() - used_s, 0.1);
    close_pipes();
}

static void no_alarm(int number) { (void)number; }

static void a_signal_ends_the_wait(void **unused) {
    (void)unused;
    const struct sigaction action = {.sa_handler = no_alarm};
    struct pollfd p[COUNT];
    sigset_t none, alarm_only;
    sigemptyset(&none), sigemptyset(&alarm_only), sigaddset(&alarm_only, SIGALRM);
    sigaction(SIGALRM, &action, NULL);
    open_pipes();
    for (rlim_t most = 20; most <= 1024; most += 1004) {
        limit(most);
        entries(p);
        sigprocmask(SIG_BLOCK, &alarm_only, NULL);
        raise(SIGALRM); /* the signal is pending, and is delivered as soon as the wait permits it */
        assert_int_equal(poll_any(p, COUNT, 60000, &none), -1);
        assert_int_equal(errno, EINTR);
        sigprocmask(SIG_UNBLOCK, &alarm_only, NULL);
    }
    close_pipes();
}

/* If poll(2) may not look at any descriptor, trying each one is the only way to find those that are
 * ready. */
static void with_a_limit_of_nothing_all_are_tried(void **unused) {
    (void)unused;
    struct pollfd p[COUNT];
    open_pipes();
    entries(p);
    limit(0);
    assert_int_equal(poll_any(p, COUNT, 60000, NULL), PIPES);
    for (int k = 0; k < COUNT; k++) assert_int_equal(p[k].revents, p[k].fd >= 0 ? POLLIN : 0);
    close_pipes();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_one_that_is_ready_is_found_within_any_limit),
        cmocka_unit_test(a_wait_lasts_as_long_below_the_limit_and_does_not_spin),
        cmocka_unit_test(a_signal_ends_the_wait),
        cmocka_unit_test(with_a_limit_of_nothing_all_are_tried),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
