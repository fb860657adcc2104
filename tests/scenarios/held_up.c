/* LD_PRELOAD: holds up the main thread of hexid wherever it would wait for something to do, for as
 * long as the file HELD_UP exists. With SIGNAL_LATE the process gets SIGTERM when the main thread
 * first waits for the recorder's end, which is just after the loop's. */
#include <dlfcn.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

int ppoll(struct pollfd *p, nfds_t count, const struct timespec *timeout, const sigset_t *mask) {
    static int (*next)(struct pollfd *, nfds_t, const struct timespec *, const sigset_t *);
    const char *held = getenv("HELD_UP");
    if (!next) next = (int (*)(struct pollfd *, nfds_t, const struct timespec *, const sigset_t *))dlsym(RTLD_NEXT, "ppoll");
    while (held && getpid() == gettid() && !access(held, F_OK)) nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    return next(p, count, timeout, mask);
}

int pthread_tryjoin_np(pthread_t thread, void **result) {
    static int (*next)(pthread_t, void **);
    if (!next) {
        next = (int (*)(pthread_t, void **))dlsym(RTLD_NEXT, "pthread_tryjoin_np");
        if (getenv("SIGNAL_LATE")) kill(getpid(), SIGTERM);
    }
    return next(thread, result);
}
