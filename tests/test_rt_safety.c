/* The loop thread must not touch the heap, take a lock, or make a system call other than to sleep.
 * Each of these is a trap that ends a child process; deliberate violations prove that the traps
 * work. The allocator and lock functions of this program override the C library's and forward to
 * them unless a cycle is running. */
#include "support.h"

#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <seccomp.h>
#include <semaphore.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "loop.h"
#include "units.h"

#if SANITIZED
static void traps_need_a_build_without_sanitizers(void **unused) {
    (void)unused;
    skip_because(OWN_ALLOCATOR);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(traps_need_a_build_without_sanitizers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
#else

enum { ENDED_WELL = 0, TRAPPED_HEAP = 40, TRAPPED_LOCK = 41, BROKEN = 42 };

static _Thread_local bool in_cycle;

static void trap(int kind) {
    if (in_cycle) _exit(kind);
}

/* ---- heap ---- */

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *block);

void *malloc(size_t size) {
    trap(TRAPPED_HEAP);
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size) {
    trap(TRAPPED_HEAP);
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size) {
    trap(TRAPPED_HEAP);
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
    trap(TRAPPED_HEAP);
    return __libc_memalign(alignment, size);
}

int posix_memalign(void **block, size_t alignment, size_t size) {
    trap(TRAPPED_HEAP);
    *block = __libc_memalign(alignment, size);
    return *block ? 0 : ENOMEM;
}

void free(void *block) {
    trap(TRAPPED_HEAP);
    __libc_free(block);
}

/* ---- locks ---- */

#define LOCK(name, parameters, arguments)                                                                         \
    int name parameters {                                                                                         \
        static int (*real) parameters;                                                                            \
        trap(TRAPPED_LOCK);                                                                                       \
        if (!real) *(void **)&real = dlsym(RTLD_NEXT, #name);                                                     \
        return real arguments;                                                                                    \
    }

#include "rt/locks.h"

/* ---- system calls ---- */

/* Lets this thread from now on only sleep, read the time, yield (virtual time, full ring) and
 * end. */
static void forbid_system_calls(void) {
    static const int allowed[] = {SCMP_SYS(clock_nanosleep), SCMP_SYS(clock_gettime), SCMP_SYS(sched_yield), SCMP_SYS(rt_sigreturn),
                                  SCMP_SYS(exit_group)};
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_KILL_PROCESS);
    int failed = !filter;
    for (unsigned i = 0; i < sizeof allowed / sizeof *allowed && !failed; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, allowed[i], 0);
    if (failed || seccomp_load(filter)) _exit(BROKEN);
}

/* ---- the run ---- */

struct run {
    enum engine_kind engine;
    bool effects;            /* switches on all effects that are off by default */
    enum clock_kind clock;
    int cycles;
    const char *url;
    enum control_law law;
    void (*sin)(void);       /* violation that is called in the middle of the run, as if by the
                              * loop */
};

/* Switches every effect on at a twentieth of its typical size, so that all code runs and the
 * machine still moves. */
static void switch_effects_on(struct params *params) {
    for (int e = 0; effect_table[e]; e++) effect_at(effect_table[e], 0.05, &params->effects[e]);
}

static struct params params_of(const struct run *run) {
    struct params params;
    config_default(&params);
    params.sim.engine = run->engine;
    params.control.law = run->law;
    params.tests.settle_s = 0.05, params.tests.ramp_s = 0.1, params.tests.duration_s = 0.1, params.tests.ramp_out_s = 0.1;
    params.motion.engage_s = params.motion.park_s = 2.0;
    params.motion.hold_s = 0.1;
    if (run->effects) switch_effects_on(&params);
    if (run->clock == CLOCK_REAL) params.loop.period_s = 5e-4, params.sim.substeps = 2, params.loop.overrun_limit = 100000;
    return params;
}

/* Runs the loop's cycles in a child with every trap set. Does not return. */
static void run_cycles(const struct run *run, bool system_calls_too) {
    static struct loop loop;
    struct params params = params_of(run);
    struct hal *hal;
    struct ring records;
    struct error error;
    struct cycle c;
    if (hal_open(&hal, run->url, &params, 1, &error) || ring_init(&records, sizeof c, 4)) _exit(BROKEN);
    if (loop_init(&loop, &params, hal, &records, run->clock, &error)) _exit(BROKEN);
    if (system_calls_too) forbid_system_calls();
    bool driven = false;
    for (int n = 0; n < run->cycles; n++) {
        in_cycle = true;
        bool more = loop_cycle(&loop);
        if (run->sin && n == run->cycles / 2) run->sin();
        in_cycle = false;
        if (ring_pop(&records, &c) && c.out.enable) driven = true;
        if (!more) break;
    }
    _exit(driven || run->sin ? ENDED_WELL : BROKEN);
}

/* Returns the child's status as waitpid() does. */
static int outcome(const struct run *run, bool system_calls_too) {
    int status = -1;
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) run_cycles(run, system_calls_too);
    assert_int_equal(waitpid(child, &status, 0), child);
    return status;
}

static const struct run runs[] = {
    {ENGINE_ODE, false, CLOCK_VIRTUAL, 400, "sim:", CONTROL_PID, NULL},
    {ENGINE_ODE, true, CLOCK_VIRTUAL, 400, "sim:", CONTROL_PID, NULL},
    {ENGINE_ODE, true, CLOCK_REAL, 450, "sim:", CONTROL_PID, NULL},
    /* the whole automatic run */
    {ENGINE_CLOSED_FORM, false, CLOCK_VIRTUAL, 5000, "sim:", CONTROL_PID, NULL},
    {ENGINE_CLOSED_FORM, true, CLOCK_VIRTUAL, 2000, "sim:", CONTROL_PID, NULL},
    {ENGINE_CLOSED_FORM, false, CLOCK_REAL, 450, "sim:", CONTROL_PID, NULL},
    {ENGINE_CLOSED_FORM, false, CLOCK_PACED, 200, "sim:", CONTROL_PID, NULL},
    /* faults and the cycles after them */
    {ENGINE_CLOSED_FORM, false, CLOCK_VIRTUAL, 2000, "fault:nan@0.5+0.004/2,drop@1+0.006,stale@2+1;sim:", CONTROL_PID, NULL},
    /* control by the machine's model, with friction and dead band, and its hand-over to the PID */
    {ENGINE_CLOSED_FORM, true, CLOCK_VIRTUAL, 2000, "sim:", CONTROL_MODEL, NULL},
    {ENGINE_CLOSED_FORM, false, CLOCK_VIRTUAL, 5000, "fault:pressure_nan@3+0.006/2,drop@4+0.006;sim:", CONTROL_MODEL, NULL},
};

static void assert_ends_well(bool system_calls_too) {
    for (unsigned i = 0; i < sizeof runs / sizeof *runs; i++) {
        int status = outcome(&runs[i], system_calls_too);
        if (WIFSIGNALED(status)) fail_msg("run %u: signal %d (31: a system call that is not allowed)", i, WTERMSIG(status));
        if (WEXITSTATUS(status) == TRAPPED_HEAP) fail_msg("run %u: the heap was touched in a cycle", i);
        if (WEXITSTATUS(status) == TRAPPED_LOCK) fail_msg("run %u: a lock was taken in a cycle", i);
        assert_int_equal(status, ENDED_WELL);
    }
}

static void a_cycle_touches_no_heap_and_takes_no_lock(void **unused) {
    (void)unused;
    slow_case();
    assert_ends_well(false);
}

static void a_cycle_makes_no_system_call_but_to_sleep(void **unused) {
    (void)unused;
    slow_case();
    assert_ends_well(true);
}

/* ---- the traps trip ---- */

static void *volatile kept;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static sem_t semaphore;

static void sin_malloc(void) { kept = malloc(16); }
static void sin_calloc(void) { kept = calloc(1, 16); }
static void sin_realloc(void) { kept = realloc(kept, 32); }
static void sin_free(void) { free(kept); }
static void sin_lock(void) { pthread_mutex_lock(&mutex); }
static void sin_post(void) { sem_post(&semaphore); }
static void sin_log(void) { (void)!write(STDERR_FILENO, "", 0); }
static void sin_identity(void) { (void)syscall(SYS_getpid); }

static int outcome_of_sin(void (*sin)(void), bool system_calls_too) {
    const struct run run = {ENGINE_CLOSED_FORM, false, CLOCK_VIRTUAL, 20, "sim:", CONTROL_PID, sin};
    return outcome(&run, system_calls_too);
}

static void the_heap_trap_trips(void **unused) {
    (void)unused;
    void (*const sins[])(void) = {sin_malloc, sin_calloc, sin_realloc, sin_free};
    kept = malloc(16);
    for (unsigned i = 0; i < sizeof sins / sizeof *sins; i++) {
        int status = outcome_of_sin(sins[i], false);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == TRAPPED_HEAP);
    }
    free(kept);
}

static void the_lock_trap_trips(void **unused) {
    (void)unused;
    void (*const sins[])(void) = {sin_lock, sin_post};
    for (unsigned i = 0; i < sizeof sins / sizeof *sins; i++) {
        int status = outcome_of_sin(sins[i], false);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == TRAPPED_LOCK);
    }
}

static void the_system_call_trap_trips(void **unused) {
    (void)unused;
    void (*const sins[])(void) = {sin_log, sin_identity};
    for (unsigned i = 0; i < sizeof sins / sizeof *sins; i++) {
        int status = outcome_of_sin(sins[i], true);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS);
        /* without the trap the violation is harmless */
        assert_int_equal(outcome_of_sin(sins[i], false), ENDED_WELL);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cycle_touches_no_heap_and_takes_no_lock),
        cmocka_unit_test(a_cycle_makes_no_system_call_but_to_sleep),
        cmocka_unit_test(the_heap_trap_trips),
        cmocka_unit_test(the_lock_trap_trips),
        cmocka_unit_test(the_system_call_trap_trips),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
#endif
