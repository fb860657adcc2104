/* Counts side activities of a running hexid's threads: preloaded (LD_PRELOAD), it counts each
 * thread's heap calls, locks and page faults, and measures its stack.
 *
 *     HEXID_COUNTS=FILE LD_PRELOAD=counts.so hexid run --set security.confine=false ...
 *
 * Counting starts at a thread's first sleep, which in the loop is the wait for its first deadline,
 * or at the thread's start if it never sleeps. At the end of a thread or of the process, a line is
 * added to FILE: the thread's function (offset in the program, hexadecimal), sleeps, heap calls,
 * locks, minor and major page faults (-1: could not be read), bytes of stack. With
 * HEXID_COUNTS_EVERY_S a thread that sleeps to deadlines adds a line "wake" after each such
 * interval: its function, its wake-ups, and their lateness [us] as p50, p99, p99.9 and max. Stacks
 * are painted when counting starts. Confined processes cannot be counted: the filter denies
 * getrusage(). */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "histogram.h"

enum { THREADS_MAX = 64, KEEP_BYTES = 1024, MAIN_BYTES = 1 << 20 };
static const uint64_t paint = 0x5ca1ab1e5ca1ab1e;

struct counts {
    void *(*begin)(void *);
    void *argument;
    _Atomic bool alive;
    pid_t id;
    uint64_t *low;            /* lower end of the painted stack */
    const char *high;
    bool begun;
    long sleeps, heap, locks, minor, major;
    struct histogram late;    /* lateness since the last line */
    int64_t since_ns;
};

static struct counts of_thread[THREADS_MAX];
static _Atomic int threads;
static _Thread_local struct counts *mine __attribute__((tls_model("initial-exec")));
static int out = -1;
static int64_t every_ns;
static uintptr_t base; /* load address of the program */

static void *real(const char *name) {
    void *f = dlsym(RTLD_NEXT, name);
    if (!f) _exit(99);
    return f;
}

/* Reads the page faults of a thread of this process, the calling one or a sleeping one; returns
 * false if /proc is inaccessible. */
static bool faults_of(pid_t id, long *minor, long *major) {
    char path[64], text[1024];
    snprintf(path, sizeof path, "/proc/self/task/%d/stat", (int)id);
    int file = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t size = file < 0 ? -1 : read(file, text, sizeof text - 1);
    if (file >= 0) close(file);
    if (size <= 0) return false;
    text[size] = 0;
    const char *after = strrchr(text, ')');
    return after && sscanf(after + 1, " %*c %*d %*d %*d %*d %*d %*u %ld %*u %ld", minor, major) == 2;
}

static void own_faults(long *minor, long *major) {
    struct rusage usage;
    if (getrusage(RUSAGE_THREAD, &usage)) *minor = *major = -1;
    else *minor = usage.ru_minflt, *major = usage.ru_majflt;
}

/* Paints everything below the caller's frame. */
__attribute__((noinline)) static void paint_stack(struct counts *c) {
    uintptr_t here = (uintptr_t)__builtin_frame_address(0) - KEEP_BYTES;
    for (volatile uint64_t *p = c->low; (uintptr_t)p < here; p++) *p = paint;
}

/* Starts counting and forgets the stack depth and calls so far. */
static void begin_counting(struct counts *c) {
    if (c->low) paint_stack(c);
    c->heap = c->locks = 0;
    own_faults(&c->minor, &c->major);
    c->begun = true;
}

static size_t stack_bytes(const struct counts *c) {
    const uint64_t *p = c->low;
    while ((const char *)p < c->high && *p == paint) p++;
    return (size_t)(c->high - (const char *)p);
}

static unsigned long begin_offset(const struct counts *c) { return c->begin ? (unsigned long)((uintptr_t)c->begin - base) : 0; }

static void report(struct counts *c, long minor, long major) {
    bool known = minor >= 0 && c->minor >= 0;
    char line[200];
    int size = snprintf(line, sizeof line, "%lx %ld %ld %ld %ld %ld %zu\n", begin_offset(c), c->sleeps, c->heap, c->locks,
                        known ? minor - c->minor : -1, known ? major - c->major : -1, c->low ? stack_bytes(c) : 0);
    if (out >= 0 && write(out, line, (size_t)size) != size) _exit(98);
}

static void *counted(void *argument) {
    struct counts *c = argument;
    pthread_attr_t attributes;
    void *low;
    size_t size; /* size of the stack, from `low` to its top */
    long minor, major;
    mine = c;
    c->id = (pid_t)syscall(SYS_gettid);
    if (!pthread_getattr_np(pthread_self(), &attributes)) {
        pthread_attr_getstack(&attributes, &low, &size);
        pthread_attr_destroy(&attributes);
        c->low = low, c->high = __builtin_frame_address(0); /* the thread's own storage lies above
                                                             * this frame */
    }
    begin_counting(c);
    c->begun = false;
    c->alive = true;
    void *result = c->begin(c->argument);
    own_faults(&minor, &major);
    mine = NULL;
    c->alive = false;
    report(c, minor, major);
    return result;
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*begin)(void *), void *argument) {
    static int (*create)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    if (!create) *(void **)&create = real("pthread_create");
    int place = threads++;
    if (place >= THREADS_MAX) return create(thread, attributes, begin, argument);
    of_thread[place] = (struct counts){.begin = begin, .argument = argument};
    return create(thread, attributes, counted, &of_thread[place]);
}

/* ---- the sleep that starts the counting ---- */

static int64_t ns_of(const struct timespec *t) { return t->tv_sec * INT64_C(1000000000) + t->tv_nsec; }

static void woke(struct counts *c, const struct timespec *until) {
    static const double quantile[] = {0.5, 0.99, 0.999};
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    int64_t now_ns = ns_of(&t);
    histogram_add(&c->late, now_ns - ns_of(until));
    if (!c->since_ns) c->since_ns = now_ns;
    if (now_ns - c->since_ns < every_ns) return;
    char line[200];
    int size = snprintf(line, sizeof line, "wake %lx %lu", begin_offset(c), (unsigned long)c->late.count);
    for (int i = 0; i < 3; i++)
        size += snprintf(line + size, sizeof line - (size_t)size, " %.1f", (double)histogram_quantile(&c->late, quantile[i]) / 1e3);
    size += snprintf(line + size, sizeof line - (size_t)size, " %.1f\n", (double)c->late.max_ns / 1e3);
    if (out >= 0 && write(out, line, (size_t)size) != size) _exit(98);
    memset(&c->late, 0, sizeof c->late);
    c->since_ns = now_ns;
}

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *until, struct timespec *left) {
    static int (*sleep_until)(clockid_t, int, const struct timespec *, struct timespec *);
    if (!sleep_until) *(void **)&sleep_until = real("clock_nanosleep");
    if (mine && !mine->begun) begin_counting(mine);
    if (mine) mine->sleeps++;
    int result = sleep_until(clock, flags, until, left);
    if (mine && every_ns && !result && clock == CLOCK_MONOTONIC && flags & TIMER_ABSTIME) woke(mine, until);
    return result;
}

/* ---- heap ---- */

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *block);

static void heap(void) {
    if (mine) mine->heap++;
}

void *malloc(size_t size) {
    heap();
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size) {
    heap();
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size) {
    heap();
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
    heap();
    return __libc_memalign(alignment, size);
}

int posix_memalign(void **block, size_t alignment, size_t size) {
    heap();
    *block = __libc_memalign(alignment, size);
    return *block ? 0 : ENOMEM;
}

void free(void *block) {
    heap();
    __libc_free(block);
}

/* ---- locks ---- */

#define LOCK(name, parameters, arguments)                                                                         \
    int name parameters {                                                                                         \
        static int (*next) parameters;                                                                            \
        if (mine) mine->locks++;                                                                                  \
        if (!next) *(void **)&next = real(#name);                                                                 \
        return next arguments;                                                                                    \
    }

#include "locks.h"

/* ---- the process ---- */

/* Paints the upper megabyte of the main thread's stack. */
__attribute__((noinline)) static uintptr_t paint_main(void) {
    volatile uint64_t room[MAIN_BYTES / sizeof paint];
    for (size_t i = 0; i < MAIN_BYTES / sizeof paint; i++) room[i] = paint;
    return (uintptr_t)room;
}

__attribute__((constructor)) static void begin(void) {
    const char *path = getenv("HEXID_COUNTS");
    if (!path) return;
    out = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    struct link_map *map;
    if (!dlinfo(dlopen(NULL, RTLD_NOW), RTLD_DI_LINKMAP, &map)) base = map->l_addr;
    if (getenv("HEXID_COUNTS_EVERY_S")) every_ns = (int64_t)(1e9 * strtod(getenv("HEXID_COUNTS_EVERY_S"), NULL));
    struct counts *c = &of_thread[threads++];
    *c = (struct counts){.id = getpid()};
    c->high = __builtin_frame_address(0);
    c->low = (uint64_t *)paint_main();
    own_faults(&c->minor, &c->major);
    c->alive = true;
    mine = c;
}

/* Prints the counts at the end, but not in a forked child, which has the parent's table and none of
 * its threads. */
__attribute__((destructor)) static void end(void) {
    mine = NULL;
    if (of_thread[0].id != getpid()) return;
    for (int i = 0; i < threads && i < THREADS_MAX; i++) {
        struct counts *c = &of_thread[i];
        long minor = -1, major = -1;
        if (!c->alive) continue;
        faults_of(c->id, &minor, &major);
        report(c, minor, major);
    }
}
