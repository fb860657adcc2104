#include "process.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "thread.h"

/* Opens closed standard descriptors on /dev/null, in ascending order: open() returns the lowest
 * free number, which is then that of the closed descriptor. */
static int open_standard(struct error *error) {
    for (int file = STDIN_FILENO; file <= STDERR_FILENO; file++) {
        if (fcntl(file, F_GETFD) >= 0) continue;
        int got = open("/dev/null", file == STDIN_FILENO ? O_WRONLY : O_RDONLY);
        /* without /dev a descriptor with O_PATH serves: it refuses reads and writes, like /dev/null
         * opened in the wrong direction */
        if (got < 0) got = open("/", O_PATH);
        if (got != file)
            return error_set(error, STATUS_IO, "descriptor %d is closed, and /dev/null cannot take its place: %s", file, strerror(errno));
    }
    return STATUS_OK;
}

static void reset_signals(void) {
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    signal(SIGPIPE, SIG_DFL);
    signal(SIGCHLD, SIG_DFL);
    signal(SIGXFSZ, SIG_IGN);
}

static void close_to_others(void) {
    mode_t asked = umask(S_IWOTH);
    umask(asked | S_IWOTH);
}

/* Raises a soft limit to the wanted value, or to the hard limit if that is lower. Most soft limits
 * are only defaults of the calling shell. */
static void raise_limit(int resource, rlim_t wanted) {
    struct rlimit limit;
    if (getrlimit(resource, &limit) || limit.rlim_cur >= wanted) return;
    limit.rlim_cur = limit.rlim_max < wanted ? limit.rlim_max : wanted;
    setrlimit(resource, &limit);
}

/* Checks that a limit is at least `least`. unit: number of the kernel's units in one unit of the
 * message; 1024 for the stack, which the kernel counts in bytes and the message in kB. */
static int need(int resource, rlim_t least, rlim_t unit, const char *what, const char *remedy, struct error *error) {
    struct rlimit limit;
    if (getrlimit(resource, &limit) || limit.rlim_cur >= least) return STATUS_OK;
    return error_set(error, STATUS_IO, "this process may have %llu %s, and hexid needs %llu: %s",
                     (unsigned long long)(limit.rlim_cur / unit), what, (unsigned long long)(least / unit), remedy);
}

/* Removes variables that make GLib, loaded by Debian's liblcm, do harm: G_MESSAGES_DEBUG=all prints
 * into results on standard output, G_DEBUG=fatal-warnings aborts a daemon that holds a platform up,
 * and G_SLICE changes how memory is allocated. */
static void clean_environment(void) {
    static const char *const names[] = {"G_DEBUG", "G_MESSAGES_DEBUG", "G_SLICE"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) unsetenv(names[i]);
}

int process_start(struct error *error) {
    int status = open_standard(error);
    if (status) return status;
    reset_signals();
    close_to_others();
    clean_environment();
    raise_limit(RLIMIT_STACK, PROCESS_STACK);
    raise_limit(RLIMIT_NOFILE, PROCESS_FILES);
    thread_defaults();
    return STATUS_OK;
}

int process_limits(struct error *error) {
    int status = need(RLIMIT_STACK, PROCESS_STACK, 1024, "kB of stack", "`ulimit -s 8192`, or LimitSTACK=8M of its service", error);
    return status ? status
                  : need(RLIMIT_NOFILE, PROCESS_FILES, 1, "open files", "`ulimit -n 128`, or LimitNOFILE=128 of its service", error);
}

bool process_ignores(int number) {
    struct sigaction inherited;
    return number == SIGHUP && !sigaction(number, NULL, &inherited) && inherited.sa_handler == SIG_IGN;
}

void process_survive_readers(void) { signal(SIGPIPE, SIG_IGN); }
