/* A program error in any thread calls the back-end's safe() before the process
 * ends by its signal. */
#include "support.h"

#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "crash.h"

static int told[2]; /* pipe that gets a byte for each call of safe() */

static void fake_safe(struct hal *hal) {
    (void)hal;
    (void)!write(told[1], "s", 1);
}

static volatile int depth;
__attribute__((noinline)) static int overflow(volatile unsigned char *before) {
    volatile unsigned char frame[4096];
    frame[0] = before ? before[0] : 1;
    depth++;
    /* infinite recursion, not a tail call */
    return depth > 0 ? overflow(frame) + frame[0] : 0;
}

static void deep(void) { overflow(NULL); }
static int *volatile nowhere;
static void wild(void) { *nowhere = 1; }
static void ends(void) { abort(); }
static void raised(void) { raise(SIGFPE); }

static void *thread(void *sin) {
    crash_stack();
    (*(void (**)(void))sin)();
    return NULL;
}

static void safe_is_called_and_the_signal_kept(void **unused) {
    (void)unused;
    static const struct {
        void (*sin)(void);
        int number;
    } cases[] = {{deep, SIGSEGV}, {wild, SIGSEGV}, {ends, SIGABRT}, {raised, SIGFPE}};
    if (SANITIZED) skip_because(OWN_ALLOCATOR);
    for (unsigned k = 0; k < sizeof cases / sizeof *cases; k++)
        for (int in_thread = 0; in_thread < 2; in_thread++) {
            char calls[8];
            int status;
            assert_int_equal(pipe(told), 0);
            pid_t child = fork();
            assert_true(child >= 0);
            if (child == 0) {
                static const struct hal_ops ops = {.scheme = "fake", .safe = fake_safe};
                static struct hal hal = {.ops = &ops};
                static _Atomic bool aborted;
                void (*sin)(void) = cases[k].sin;
                pthread_t id;
                crash_guard(&hal, &aborted);
                if (in_thread && !pthread_create(&id, NULL, thread, &sin)) pthread_join(id, NULL);
                else sin();
                _exit(0);
            }
            assert_int_equal(waitpid(child, &status, 0), child);
            assert_true(WIFSIGNALED(status) && WTERMSIG(status) == cases[k].number);
            close(told[1]);
            /* the end of the file: safe() was called no more */
            assert_int_equal(read(told[0], calls, sizeof calls), 2);
            close(told[0]);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(safe_is_called_and_the_signal_kept)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
