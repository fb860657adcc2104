/* A preload for linux.uml: a clock that the host cannot disturb, and a work-around.
 *
 * The clock: a user-mode kernel reads the time from clock_gettime() and one timer, and waits for
 * that timer in sigsuspend() when it is idle. Here time is only what the kernel has used: reading
 * the clock takes READ_NS, and a wait ends at once, at the time at which the timer expires.
 * Everything inside lives in that time, processes, sockets and time-outs alike, as on an infinitely
 * fast processor; the host's speed and load are invisible. Booting measures loops against the real
 * clock, so virtual time starts when the file named by VIRTUAL_TIME_FROM appears; without it,
 * never. */
#include <dlfcn.h>
#include <elf.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

enum { READ_NS = 200, NS_PER_S = 1000000000 };

static int (*real_clock_gettime)(clockid_t id, struct timespec *t);
static int (*real_timer_gettime)(timer_t timer, struct itimerspec *left);
static int (*real_timer_settime)(timer_t timer, int flags, const struct itimerspec *next, struct itimerspec *old);
static int (*real_sigsuspend)(const sigset_t *mask);
static long (*real_ptrace)(enum __ptrace_request request, ...);

static const char *begin_file; /* file whose appearance starts virtual time; NULL: virtual time has
                                * begun, or never will */
static bool virtual_time;
static int64_t now_ns, realtime_minus_monotonic_ns;
static int64_t expiry_ns;      /* expiry of the timer, 0: not armed */
static timer_t timer;          /* the only timer of the kernel */

__attribute__((constructor)) static void find_real(void) {
    *(void **)&real_clock_gettime = dlsym(RTLD_NEXT, "clock_gettime");
    *(void **)&real_timer_gettime = dlsym(RTLD_NEXT, "timer_gettime");
    *(void **)&real_timer_settime = dlsym(RTLD_NEXT, "timer_settime");
    *(void **)&real_sigsuspend = dlsym(RTLD_NEXT, "sigsuspend");
    *(void **)&real_ptrace = dlsym(RTLD_NEXT, "ptrace");
    begin_file = getenv("VIRTUAL_TIME_FROM");
}

static int64_t ns_of(struct timespec t) { return t.tv_sec * (int64_t)NS_PER_S + t.tv_nsec; }
static struct timespec timespec_of(int64_t ns) { return (struct timespec){.tv_sec = ns / NS_PER_S, .tv_nsec = ns % NS_PER_S}; }

static void begin_virtual_time(void) {
    struct timespec monotonic, realtime;
    struct itimerspec left, disarmed = {0};
    real_clock_gettime(CLOCK_MONOTONIC, &monotonic);
    real_clock_gettime(CLOCK_REALTIME, &realtime);
    now_ns = ns_of(monotonic);
    realtime_minus_monotonic_ns = ns_of(realtime) - now_ns;
    real_timer_gettime(timer, &left);
    /* An expired timer is a signal that waits for sigsuspend(); disarming the timer might withdraw
     * that signal. */
    if (ns_of(left.it_value)) real_timer_settime(timer, 0, &disarmed, NULL);
    expiry_ns = ns_of(left.it_value) ? now_ns + ns_of(left.it_value) : 0;
    begin_file = NULL;
    virtual_time = true;
}

static void expire(void) {
    expiry_ns = 0;
    raise(SIGALRM);
}

int clock_gettime(clockid_t id, struct timespec *t) {
    if (!virtual_time) return real_clock_gettime(id, t);
    now_ns += READ_NS;
    *t = timespec_of(id == CLOCK_REALTIME ? now_ns + realtime_minus_monotonic_ns : now_ns);
    if (expiry_ns && now_ns >= expiry_ns) expire();
    return 0;
}

int timer_settime(timer_t which, int flags, const struct itimerspec *next, struct itimerspec *old) {
    timer = which;
    if (!virtual_time) return real_timer_settime(which, flags, next, old);
    int64_t in_ns = ns_of(next->it_value);
    expiry_ns = in_ns ? now_ns + in_ns : 0;
    return 0;
}

int timer_gettime(timer_t which, struct itimerspec *left) {
    if (!virtual_time) return real_timer_gettime(which, left);
    *left = (struct itimerspec){0};
    if (expiry_ns) left->it_value = timespec_of(expiry_ns > now_ns ? expiry_ns - now_ns : 1);
    return 0;
}

/* The kernel is idle until its timer expires. SIGALRM is blocked here; the wait delivers the
 * signal. */
int sigsuspend(const sigset_t *mask) {
    if (begin_file && access(begin_file, F_OK) == 0) begin_virtual_time();
    if (virtual_time && expiry_ns) {
        if (now_ns < expiry_ns) now_ns = expiry_ns;
        expire();
    }
    return real_sigsuspend(mask);
}

/* The work-around: Debian 12's user-mode kernel stores 2696 bytes of a process's vector registers,
 * enough up to AVX-512. A host with AMX has tile registers behind them and refuses a partial write,
 * so the kernel dies with its first process. This reads the whole, overlays the part that the
 * kernel knows, and writes the whole back. No program inside uses the tiles. */
static unsigned char whole[16384]; /* not on the kernel's small stack; there is one thread */
static size_t host_size;           /* size of any process's registers; 0: not yet known */

static long set_registers(pid_t pid, void *set, struct iovec *part) {
    struct iovec all = {.iov_base = whole, .iov_len = sizeof whole};
    if (!host_size || part->iov_len < host_size) {
        if (real_ptrace(PTRACE_GETREGSET, pid, set, &all) < 0) return -1;
        host_size = all.iov_len;
    }
    if (part->iov_len >= host_size) return real_ptrace(PTRACE_SETREGSET, pid, set, part);
    memcpy(whole, part->iov_base, part->iov_len);
    return real_ptrace(PTRACE_SETREGSET, pid, set, &all);
}

long ptrace(enum __ptrace_request request, ...) {
    va_list args;
    va_start(args, request);
    pid_t pid = va_arg(args, pid_t);
    void *address = va_arg(args, void *), *data = va_arg(args, void *);
    va_end(args);
    if (request == PTRACE_SETREGSET && address == (void *)NT_X86_XSTATE) return set_registers(pid, address, data);
    return real_ptrace(request, pid, address, data);
}
