#include "parallel.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>

#include "thread.h"

enum { THREADS_MAX = 16 };

struct work {
    void (*one)(void *context, int i);
    void *context;
    int count;
    _Atomic int next;
};

static void *work_on(void *argument) {
    struct work *work = argument;
    for (int i; (i = atomic_fetch_add(&work->next, 1)) < work->count;) work->one(work->context, i);
    return NULL;
}

/* If a thread cannot be started, the others do its share of the work. */
void parallel_run(int threads, int count, void (*one)(void *context, int i), void *context) {
    struct work work = {.one = one, .context = context, .count = count};
    pthread_t thread[THREADS_MAX];
    struct error ignored;
    int started = 0, most = threads < count ? threads : count;
    while (started < most - 1 && started < THREADS_MAX &&
           !thread_start(&thread[started], "worker", THREAD_STACK_FIT, work_on, &work, &ignored))
        started++;
    work_on(&work);
    for (int i = 0; i < started; i++) pthread_join(thread[i], NULL);
}
