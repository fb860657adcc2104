#include "confine.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <sched.h>
#include <seccomp.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
#define SANITIZED true
#else
#define SANITIZED false
#endif

#define COUNT(array) (sizeof(array) / sizeof *(array))
/* LOWEST: lowest address that may be mapped, the value of vm.mmap_min_addr in distributions.
 * PLACES: number of addresses tried */
enum { PAGE = 4096, LOWEST = 0x10000, PLACES = 64 };

void confine_thread(void) {
    struct __user_cap_header_struct header = {.version = _LINUX_CAPABILITY_VERSION_3};
    struct __user_cap_data_struct none[_LINUX_CAPABILITY_U32S_3] = {0};
    if (SANITIZED) return;
    /* a thread may always drop its capabilities; dropping the permitted ones drops the ambient
     * ones, too */
    syscall(SYS_capset, &header, none);
}

/* Copies both paths, a page each, to addresses below all other memory, and makes these two pages
 * read-only. The calls that allow_memory() allows can change memory only above them. */
static char *intern(const char *first, const char *second) {
    for (uintptr_t at = LOWEST; at < LOWEST + PLACES * PAGE; at += PAGE) {
        char *pages = mmap((void *)at, 2 * PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0);
        if (pages == MAP_FAILED) continue;
        snprintf(pages, PAGE, "%s", first);
        snprintf(pages + PAGE, PAGE, "%s", second);
        return mprotect(pages, 2 * PAGE, PROT_READ) ? NULL : pages;
    }
    return NULL;
}

static int allow(scmp_filter_ctx filter, const int *calls, size_t count) {
    int failed = 0;
    for (size_t i = 0; i < count && !failed; i++) failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, calls[i], 0);
    return failed;
}

static int allow_always(scmp_filter_ctx filter) {
    static const int calls[] = {
        /* open descriptors */
        SCMP_SYS(read), SCMP_SYS(readv), SCMP_SYS(write), SCMP_SYS(writev), SCMP_SYS(pwrite64), SCMP_SYS(lseek), SCMP_SYS(fstat),
        SCMP_SYS(newfstatat), SCMP_SYS(close), SCMP_SYS(fsync), SCMP_SYS(fdatasync), SCMP_SYS(fcntl), SCMP_SYS(recvmsg), SCMP_SYS(recvmmsg),
        SCMP_SYS(recvfrom), SCMP_SYS(sendmsg), SCMP_SYS(sendmmsg), SCMP_SYS(sendto), SCMP_SYS(shutdown), SCMP_SYS(accept4),
        SCMP_SYS(getsockopt), SCMP_SYS(getsockname), SCMP_SYS(getpeername),
        /* waiting and time */
        SCMP_SYS(poll), SCMP_SYS(ppoll), SCMP_SYS(select), SCMP_SYS(pselect6), SCMP_SYS(futex), SCMP_SYS(nanosleep),
        SCMP_SYS(clock_nanosleep), SCMP_SYS(clock_gettime), SCMP_SYS(clock_getres), SCMP_SYS(gettimeofday), SCMP_SYS(time),
        SCMP_SYS(restart_syscall), SCMP_SYS(sched_yield), SCMP_SYS(sched_getparam), SCMP_SYS(sched_getscheduler),
        SCMP_SYS(sched_getaffinity),
        /* signals */
        SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn), SCMP_SYS(rt_sigtimedwait), SCMP_SYS(sigaltstack),
        /* SAFETY: calls that a starting thread makes; glibc ends the process if they fail */
        SCMP_SYS(rseq), SCMP_SYS(set_robust_list),
        /* this process */
        SCMP_SYS(getpid), SCMP_SYS(gettid), SCMP_SYS(getrandom), SCMP_SYS(brk), SCMP_SYS(munlockall), SCMP_SYS(capset), SCMP_SYS(exit),
        SCMP_SYS(exit_group)};
    return allow(filter, calls, COUNT(calls));
}

/* Allows the requests for settings, size and queues of a terminal or a serial line, but no request
 * that inserts characters into its input. */
static int allow_ioctl(scmp_filter_ctx filter) {
    static const unsigned requests[] = {TCGETS, TCSETS, TCSETSW, TCSETSF, TCSBRK, TCFLSH, TIOCOUTQ, TIOCGWINSZ, FIONREAD};
    int failed = 0;
    for (size_t i = 0; i < COUNT(requests) && !failed; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(ioctl), 1, SCMP_A1(SCMP_CMP_EQ, requests[i]));
    return failed;
}

/* Allows mapping memory that is not executable at free addresses, and changing memory above the two
 * pages of the paths, the lowest ones. No allowed call makes memory executable. */
static int allow_memory(scmp_filter_ctx filter, const char *paths) {
    const scmp_datum_t first = paths ? (uintptr_t)paths + 2 * PAGE : 0;
    const struct scmp_arg_cmp above = SCMP_A0(SCMP_CMP_GE, first), data = SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0);
    int failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 2, data,
                                  SCMP_A3(SCMP_CMP_MASKED_EQ, MAP_FIXED | MAP_FIXED_NOREPLACE, 0));
    if (!failed) failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mprotect), 2, above, data);
    if (!failed) failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(munmap), 1, above);
    if (!failed) failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(madvise), 1, above);
    if (!failed)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mremap), 2, above, SCMP_A3(SCMP_CMP_MASKED_EQ, MREMAP_FIXED, 0));
    return failed;
}

/* Allows the calls by which output_write() makes a result. */
static int allow_result(scmp_filter_ctx filter, const struct output *result, const char *paths) {
    if (!paths) return 0;
    const struct scmp_arg_cmp here = SCMP_A0(SCMP_CMP_MASKED_EQ, UINT32_MAX, (uint32_t)AT_FDCWD);
    const struct scmp_arg_cmp beside = SCMP_A1(SCMP_CMP_EQ, (uintptr_t)paths);
    int failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(openat), 3, here, beside, SCMP_A2(SCMP_CMP_EQ, OUTPUT_FLAGS));
    if (!failed)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(renameat2), 5, here, beside,
                                  SCMP_A2(SCMP_CMP_MASKED_EQ, UINT32_MAX, (uint32_t)AT_FDCWD),
                                  SCMP_A3(SCMP_CMP_EQ, (uintptr_t)paths + PAGE), SCMP_A4(SCMP_CMP_EQ, result->rename_flags));
    /* on file systems without RENAME_NOREPLACE, output_write() makes a link instead of renaming */
    if (!failed && result->rename_flags)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(linkat), 5, here, beside,
                                  SCMP_A2(SCMP_CMP_MASKED_EQ, UINT32_MAX, (uint32_t)AT_FDCWD),
                                  SCMP_A3(SCMP_CMP_EQ, (uintptr_t)paths + PAGE), SCMP_A4(SCMP_CMP_EQ, 0));
    return failed ? failed : seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(unlinkat), 3, here, beside, SCMP_A2(SCMP_CMP_EQ, 0));
}

/* Allows the calls that restore a lost connection over sockets. */
static int allow_sockets(scmp_filter_ctx filter) {
    static const int calls[] = {SCMP_SYS(connect), SCMP_SYS(setsockopt), SCMP_SYS(sched_setscheduler)};
    static const int families[] = {AF_INET, AF_INET6};
    int failed = allow(filter, calls, COUNT(calls));
    for (size_t i = 0; i < COUNT(families) && !failed; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(socket), 1, SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)families[i]));
    return failed ? failed
                  : seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(openat), 1,
                                     SCMP_A2(SCMP_CMP_MASKED_EQ, O_ACCMODE | O_CREAT | O_TRUNC | O_TMPFILE, O_RDONLY));
}

/* Allows the calls that open a serial device again. SAFETY: the filter cannot compare the device's
 * path, so only a daemon with a serial back-end may make these calls. */
static int allow_serial(scmp_filter_ctx filter) {
    const scmp_datum_t how = O_ACCMODE | O_CREAT | O_TRUNC | O_EXCL | O_NOCTTY | O_NONBLOCK | O_TMPFILE;
    int failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(sched_setscheduler), 0);
    return failed ? failed /* libmodbus opens the device with these flags */
                  : seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(openat), 1,
                                     SCMP_A2(SCMP_CMP_MASKED_EQ, how, O_RDWR | O_NOCTTY | O_NONBLOCK | O_EXCL));
}

/* Allows the calls by which hal/can_socket.c opens a socket and looks at its interface. */
static int allow_can(scmp_filter_ctx filter) {
    static const int calls[] = {SCMP_SYS(bind), SCMP_SYS(setsockopt)};
    static const unsigned requests[] = {SIOCGIFINDEX, SIOCGIFFLAGS, SIOCGIFHWADDR};
    int failed = allow(filter, calls, COUNT(calls));
    for (size_t i = 0; i < COUNT(requests) && !failed; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(ioctl), 1, SCMP_A1(SCMP_CMP_EQ, requests[i]));
    if (!failed) failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(socket), 1, SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)AF_CAN));
    if (!failed) /* internet socket for queries about an interface; connecting it stays denied */
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(socket), 2, SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)AF_INET),
                                  SCMP_A1(SCMP_CMP_EQ, SOCK_DGRAM | SOCK_CLOEXEC));
    return failed;
}

static int build(scmp_filter_ctx filter, const struct confinement *c, const char *paths) {
    int failed = seccomp_attr_set(filter, SCMP_FLTATR_CTL_TSYNC, 1);
    if (!failed) failed = seccomp_attr_set(filter, SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_ERRNO(EPERM));
    /* these options only save time (no mitigation of speculative store bypass; a faster filter), so
     * a failure of theirs is ignored */
    if (!failed) seccomp_attr_set(filter, SCMP_FLTATR_CTL_SSB, 1), seccomp_attr_set(filter, SCMP_FLTATR_CTL_OPTIMIZE, 2);
    if (!failed) failed = allow_always(filter);
    if (!failed) failed = allow_ioctl(filter);
    if (!failed) failed = allow_memory(filter, paths);
    if (!failed) failed = allow_result(filter, c->result, paths);
    if (!failed && c->reopens == HAL_REOPENS_SOCKETS) failed = allow_sockets(filter);
    if (!failed && c->reopens == HAL_REOPENS_SERIAL) failed = allow_serial(filter);
    if (!failed && c->reopens == HAL_REOPENS_CAN) failed = allow_can(filter);
    if (!failed) failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1, SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)getpid()));
    return failed ? failed : seccomp_load(filter);
}

static int refused(struct error *error, const char *what, int reason) {
    return error_set(error, STATUS_UNSAFE, "the daemon cannot be confined: %s: %s; --set security.confine=false runs it without", what,
                     strerror(reason));
}

int confine(const struct confinement *c, struct error *error) {
    if (SANITIZED) return STATUS_OK;
    bool file = c->result && c->result->beside;
    const char *paths = file ? intern(c->result->beside, c->result->path) : NULL;
    if (file && !paths) return refused(error, "no memory for the paths of the result", ENOMEM);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)) return refused(error, "no_new_privs", errno);
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    int failed = filter ? build(filter, c, paths) : -ENOMEM;
    if (filter) seccomp_release(filter);
    if (failed) return refused(error, "seccomp", -failed);
    if (file) c->result->beside = paths, c->result->path = paths + PAGE;
    confine_thread();
    return STATUS_OK;
}
