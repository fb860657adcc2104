/* Threads with a stack of a stated size, the only place that starts one: by itself the size is the
 * stack limit of whoever started the program, 8 MB of locked memory for each thread, or 64 kB in
 * which nothing can work. Sizes hold three times the depth that was measured (stack.sh). */
#ifndef HEXID_THREAD_H
#define HEXID_THREAD_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>

#include "status.h"

enum {
    THREAD_STACK_COPY = 128 << 10,     /* bytes; copies lines */
    THREAD_STACK_REALTIME = 512 << 10, /* realtime_enter() prefaults half of it */
    THREAD_STACK_IDENTIFY = 2 << 20,   /* recorder and estimators: identification */
    THREAD_STACK_FIT = 8 << 20,        /* `hexid gap`: nested fits */
};

/* Any thread. STATUS_IO with its name ("loop"), the reason and the remedy. */
int thread_start(pthread_t *thread, const char *what, size_t stack_bytes, void *(*run)(void *), void *argument, struct error *error);

/* Waits for the end of a thread; false: it has not ended after so many seconds, and can be waited for again. */
bool thread_join_within(pthread_t thread, int seconds);

/* Sets the size of the stacks of threads that libraries start. Main thread, at the start. */
void thread_defaults(void);

#endif
