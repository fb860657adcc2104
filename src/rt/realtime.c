#include "realtime.h"

#include <errno.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <string.h>
#include <sys/mman.h>

#include "params/loop.h"

enum { STACK_PREFAULT = 256 * 1024 };

static void prefault_stack(void) {
    volatile unsigned char page[STACK_PREFAULT];
    for (size_t i = 0; i < sizeof page; i += 4096) page[i] = 0;
}

static int pin(int cpu, struct error *error) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET((size_t)cpu, &set);
    int refused = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
    if (refused)
        return error_set(error, STATUS_UNSAFE, "loop.cpu: cannot run on processor %d (%s): choose one that exists", cpu, strerror(refused));
    return STATUS_OK;
}

/* Sets SCHED_FIFO for the calling thread. pthread calls return positive error numbers; success
 * counts only if policy and priority read back as they were set. */
static int fifo(int priority, struct error *error) {
    struct sched_param param = {.sched_priority = priority}, got;
    int policy = -1, refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
    if (!refused) refused = pthread_getschedparam(pthread_self(), &policy, &got);
    if (!refused && (policy != SCHED_FIFO || got.sched_priority != priority)) refused = EPERM;
    if (refused)
        return error_set(error, STATUS_UNSAFE,
                         "SCHED_FIFO priority %d refused (%s): run as root, or give the user `rtprio %d` in "
                         "/etc/security/limits.conf",
                         priority, strerror(refused), priority);
    return STATUS_OK;
}

static int lock_memory(struct error *error) {
    if (mlockall(MCL_CURRENT | MCL_FUTURE))
        return error_set(error, STATUS_UNSAFE,
                         "memory not locked (%s): run as root, or give the user `memlock unlimited` in "
                         "/etc/security/limits.conf",
                         strerror(errno));
    prefault_stack();
    return STATUS_OK;
}

void realtime_heap(void) { mallopt(M_ARENA_MAX, 1); }

int realtime_enter(const struct loop_params *params, enum realtime_mode mode, struct error *error) {
    if (mode == REALTIME_OFF) return STATUS_OK;
    int memory = lock_memory(error);
    if (memory && mode == REALTIME_REQUIRE) return memory;
    int affinity = params->cpu >= 0 ? pin(params->cpu, error) : STATUS_OK;
    if (affinity && mode == REALTIME_REQUIRE) return affinity;
    int policy = fifo(params->priority, error);
    return policy ? policy : affinity ? affinity : memory;
}

void realtime_follow(const struct loop_params *params, int below) {
    struct error ignored;
    fifo(params->priority > below ? params->priority - below : 1, &ignored);
}

void realtime_leave(void) { munlockall(); }
