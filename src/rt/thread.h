/* Starts all threads of hexid, with stacks of stated sizes. Without a stated size a stack would be
 * as large as the stack limit of the calling shell: 8 MB would be locked in whole for each thread,
 * and 64 kB would be too small. Each size is at least about three times the measured depth
 * (tests/bench/stacks.py). */
#ifndef HEXID_THREAD_H
#define HEXID_THREAD_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>

#include "status.h"

enum {
    THREAD_STACK_COPY = 128 << 10,     /* stack of threads that copy text or watch an interface,
                                        * bytes */
    THREAD_STACK_REALTIME = 512 << 10, /* stack of real-time threads; realtime_enter() prefaults
                                        * half of it */
    THREAD_STACK_IDENTIFY = 2 << 20,   /* stack of the recorder's and the estimator's thread, which
                                        * run the identification */
    THREAD_STACK_FIT = 8 << 20,        /* stack of the threads of `hexid gap`, whose fits are
                                        * nested */
};

/* Starts a thread. what: name of the thread in messages ("loop"). STATUS_IO: the thread cannot be
 * started; the error has its name, the reason and the remedy. Any thread may call this. */
int thread_start(pthread_t *thread, const char *what, size_t stack_bytes, void *(*run)(void *), void *argument, struct error *error);

/* Waits up to `seconds` for the end of a thread. Returns false if the thread still runs; the caller
 * may then wait for it again. */
bool thread_join_within(pthread_t thread, int seconds);

/* Sets the default stack size, which threads have that libraries start. Main thread, at the
 * start. */
void thread_defaults(void);

#endif
