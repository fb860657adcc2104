#include "thread.h"

#include <string.h>
#include <time.h>

#include "monotonic.h"

/* A sanitizer keeps half a megabyte of state in each thread's stack, so its builds get 2 MB
 * more. */
#if defined __SANITIZE_THREAD__ || defined __SANITIZE_ADDRESS__
enum { SANITIZER = 2 << 20 };
#else
enum { SANITIZER = 0 };
#endif

int thread_start(pthread_t *thread, const char *what, size_t stack_bytes, void *(*run)(void *), void *argument, struct error *error) {
    pthread_attr_t attributes;
    int refused = pthread_attr_init(&attributes);
    if (!refused) {
        refused = pthread_attr_setstacksize(&attributes, stack_bytes + SANITIZER);
        if (!refused) refused = pthread_create(thread, &attributes, run, argument);
        pthread_attr_destroy(&attributes);
    }
    if (!refused) return STATUS_OK;
    return error_set(error, STATUS_IO,
                     "cannot start the %s thread with a stack of %zu kB: %s; raise the limits of processes (`ulimit -u`, TasksMax=) "
                     "and memory (`ulimit -v`, `ulimit -l`)",
                     what, stack_bytes >> 10, strerror(refused));
}

/* pthread_clockjoin_np() would suffice, but ThreadSanitizer reports false races with it. */
bool thread_join_within(pthread_t thread, int seconds) {
    int64_t until = monotonic_ns() + seconds * NS_PER_S;
    while (pthread_tryjoin_np(thread, NULL)) {
        if (monotonic_ns() >= until) return false;
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    }
    return true;
}

void thread_defaults(void) {
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes)) return;
    if (!pthread_attr_setstacksize(&attributes, THREAD_STACK_REALTIME + SANITIZER)) pthread_setattr_default_np(&attributes);
    pthread_attr_destroy(&attributes);
}
