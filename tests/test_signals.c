/* The thread that takes signals. The test's main thread does nothing but wait: it stands for a main
 * thread that is held up. */
#include "support.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "monotonic.h"
#include "signals.h"
#include "units.h"

static struct params params;
static struct loop loop;
static struct signals signals;

static _Atomic bool refuses; /* the system refuses the wait for signals */

/* Overrides the C library's function. */
int sigwaitinfo(const sigset_t *set, siginfo_t *signal) {
    errno = EPERM;
    return atomic_load(&refuses) ? -1 : sigtimedwait(set, signal, NULL);
}

/* What the operator was told, each time in a place of its own: the thread writes while the test
 * reads. */
static struct {
    _Atomic int count;
    struct told {
        char text[128];
        bool stopped; /* the loop had already been told when the operator was */
    } told[8];
} said;

static const struct told *last_told(void) {
    int count = atomic_load(&said.count);
    assert_in_range(count, 1, 8);
    return &said.told[count - 1];
}

static void say(void *context, const char *text) {
    struct loop *of = context;
    int count = atomic_load(&said.count);
    if (count == 8) abort();
    snprintf(said.told[count].text, sizeof said.told[count].text, "%s", text);
    said.told[count].stopped = atomic_load(&of->quit) && (!strstr(text, "centred") || atomic_load(&of->abort));
    atomic_store(&said.count, count + 1);
}

static void start(bool ended) {
    struct error error;
    atomic_store(&said.count, 0);
    config_default(&params);
    loop = (struct loop){.params = &params};
    atomic_store(&loop.ended, ended);
    signals_block(&signals);
    if (signals_start(&signals, &loop, false, say, &loop, &error)) fail_msg("%s", error.text);
}

/* Sends a signal to the process and waits until it was taken. */
static void take(int number) {
    unsigned before = atomic_load(&signals.taken);
    assert_int_equal(kill(getpid(), number), 0);
    while (atomic_load(&signals.taken) == before) poll(NULL, 0, 1);
}

/* Waits until a further signal counts as a second one. */
static void wait_apart(void) { nanosleep(&(struct timespec){.tv_nsec = SIGNALS_APART_NS + 10 * NS_PER_MS}, NULL); }

static void the_first_parks_and_the_second_centres_the_valves(void **unused) {
    (void)unused;
    static const int by_hand[] = {SIGINT, SIGTERM, SIGQUIT};
    for (size_t i = 0; i < sizeof by_hand / sizeof *by_hand; i++) {
        start(false);
        take(by_hand[i]);
        assert_true(atomic_load(&loop.quit));
        assert_int_equal(mailbox_read(&loop.requests).command, COMMAND_PARK);
        assert_int_equal(atomic_load(&signals.first), by_hand[i]);
        assert_string_equal(last_told()->text, "interrupted: parking (once more to centre the valves at once)");
        assert_true(last_told()->stopped);
        wait_apart();
        take(by_hand[i]);
        assert_true(atomic_load(&loop.abort));
        assert_string_equal(last_told()->text, "interrupted again: valves centred");
        assert_true(last_told()->stopped);
        take(SIGTERM); /* a third one changes nothing */
        assert_int_equal(atomic_load(&said.count), 2);
        assert_int_equal(atomic_load(&signals.first), by_hand[i]);
        assert_int_equal(atomic_load(&signals.late), 0);
        signals_release(&signals);
    }
}

static void two_at_once_are_one(void **unused) {
    (void)unused;
    int64_t before_ns = monotonic_ns();
    start(false);
    take(SIGHUP), take(SIGTERM), take(SIGINT);
    if (monotonic_ns() - before_ns < SIGNALS_APART_NS) assert_false(atomic_load(&loop.abort));
    assert_int_equal(atomic_load(&signals.first), SIGHUP);
    signals_release(&signals);
}

static void what_no_person_sends_parks_but_does_not_centre_the_valves(void **unused) {
    (void)unused;
    const int others[] = {SIGHUP, SIGUSR1, SIGUSR2,   SIGALRM, SIGVTALRM, SIGPROF, SIGIO,
                          SIGPWR, SIGTSTP, SIGSTKFLT, SIGXCPU, SIGRTMIN,  SIGRTMAX};
    start(false);
    take(SIGUSR1); /* the signal that ends the thread, from somebody else */
    assert_true(atomic_load(&loop.quit));
    wait_apart();
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) take(others[i]);
    assert_false(atomic_load(&loop.abort));
    signals_release(&signals);
}

/* ---- after the loop's end ---- */

enum { CLOSES = 'c' };

/* Runs a process whose loop has ended by itself, and which gets this many signals before it has
 * closed its log. Returns its status; *closed: it had closed its log. */
static int end_with(int number, int times, bool *closed) {
    int told[2], status;
    char byte = 0;
    assert_int_equal(pipe(told), 0);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        start(true);
        for (int i = 0; i < times; i++) {
            if (i) wait_apart();
            take(number);
        }
        if (atomic_load(&loop.quit) || atomic_load(&loop.abort)) _exit(2);
        if (atomic_load(&said.count) != !!times || (times && !strstr(last_told()->text, "once more to end at once"))) _exit(4);
        byte = CLOSES;
        if (write(told[1], &byte, 1) != 1) _exit(3);
        signals_release(&signals);
        _exit(0);
    }
    close(told[1]);
    *closed = read(told[0], &byte, 1) == 1 && byte == CLOSES;
    close(told[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    return status;
}

static void after_the_loops_end_a_signal_waits_for_the_log(void **unused) {
    (void)unused;
    static const int ends[] = {SIGTERM, SIGINT, SIGHUP, SIGUSR1};
    bool closed;
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        int status = end_with(ends[i], 1, &closed);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == ends[i]);
        assert_true(closed);
    }
    int status = end_with(SIGTERM, 0, &closed);
    assert_true(closed && WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

static void a_second_one_does_not(void **unused) {
    (void)unused;
    bool closed;
    int status = end_with(SIGINT, 2, &closed);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
    assert_false(closed);
}

/* The loop ends in the next cycle, as when a terminal is lost while the platform is down. */
static void two_at_once_are_one_when_the_first_has_ended_the_loop(void **unused) {
    (void)unused;
    int64_t before_ns = monotonic_ns();
    start(false);
    take(SIGHUP);
    atomic_store(&loop.ended, true);
    take(SIGHUP), take(SIGTERM);
    bool at_once = monotonic_ns() - before_ns < SIGNALS_APART_NS;
    if (at_once) assert_int_equal(atomic_load(&signals.late), 0);
    atomic_store(&signals.late, 0); /* on a busy host they were not at once */
    signals_release(&signals);
}

static void a_wait_that_is_refused_parks(void **unused) {
    (void)unused;
    atomic_store(&refuses, true);
    start(false);
    while (!atomic_load(&loop.quit)) poll(NULL, 0, 1);
    assert_int_equal(atomic_load(&signals.refused), EPERM);
    signals_release(&signals);
    atomic_store(&refuses, false);
}

static void a_signal_before_the_start_is_taken_and_a_mute_thread_says_nothing(void **unused) {
    (void)unused;
    struct error error;
    config_default(&params);
    loop = (struct loop){.params = &params};
    atomic_store(&said.count, 0);
    signals_block(&signals);
    assert_int_equal(kill(getpid(), SIGINT), 0);
    if (signals_start(&signals, &loop, false, say, &loop, &error)) fail_msg("%s", error.text);
    while (atomic_load(&signals.taken) == 0) poll(NULL, 0, 1);
    assert_int_equal(atomic_load(&said.count), 1);
    signals_mute(&signals);
    wait_apart();
    take(SIGINT);
    assert_true(atomic_load(&loop.abort));
    assert_int_equal(atomic_load(&said.count), 1);
    signals_release(&signals);
}

static void afterwards_the_mask_is_empty_and_nothing_is_released_twice(void **unused) {
    (void)unused;
    sigset_t mask;
    start(false);
    signals_release(&signals);
    signals_release(&signals);
    pthread_sigmask(SIG_BLOCK, NULL, &mask);
    for (int number = 1; number < SIGRTMIN; number++) assert_int_equal(sigismember(&mask, number), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_parks_and_the_second_centres_the_valves),
        cmocka_unit_test(two_at_once_are_one),
        cmocka_unit_test(what_no_person_sends_parks_but_does_not_centre_the_valves),
        cmocka_unit_test(after_the_loops_end_a_signal_waits_for_the_log),
        cmocka_unit_test(a_second_one_does_not),
        cmocka_unit_test(two_at_once_are_one_when_the_first_has_ended_the_loop),
        cmocka_unit_test(a_wait_that_is_refused_parks),
        cmocka_unit_test(a_signal_before_the_start_is_taken_and_a_mute_thread_says_nothing),
        cmocka_unit_test(afterwards_the_mask_is_empty_and_nothing_is_released_twice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
