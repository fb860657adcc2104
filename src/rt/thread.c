#include "thread.h"

#include <string.h>

int thread_start(pthread_t *thread, const char *what, size_t stack_bytes, void *(*run)(void *), void *argument, struct error *error) {
    pthread_attr_t attributes;
    int refused = pthread_attr_init(&attributes);
    if (!refused) {
        refused = pthread_attr_setstacksize(&attributes, stack_bytes);
        if (!refused) refused = pthread_create(thread, &attributes, run, argument);
        pthread_attr_destroy(&attributes);
    }
    if (!refused) return STATUS_OK;
    return error_set(error, STATUS_IO,
                     "cannot start the %s thread with a stack of %zu kB: %s; raise the limits of processes (`ulimit -u`, TasksMax=) "
                     "and memory (`ulimit -v`, `ulimit -l`)",
                     what, stack_bytes >> 10, strerror(refused));
}

void thread_defaults(void) {
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes)) return;
    if (!pthread_attr_setstacksize(&attributes, THREAD_STACK_REALTIME)) pthread_setattr_default_np(&attributes);
    pthread_attr_destroy(&attributes);
}
