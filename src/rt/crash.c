#include "crash.h"

#include <signal.h>
#include <stdatomic.h>
#include <time.h>

#include "units.h"

static struct hal *guarded; /* global, because a signal handler has no other access */
static _Atomic bool *told;

static void on_crash(int number) {
    const struct timespec send = {.tv_nsec = NS_PER_S / 100};
    atomic_store_explicit(told, true, memory_order_relaxed);
    guarded->ops->safe(guarded);
    nanosleep(&send, NULL);
    guarded->ops->safe(guarded); /* once more, because the loop may have written another command
                                  * meanwhile */
    nanosleep(&send, NULL);
    raise(number); /* SA_RESETHAND: the signal now has its default effect */
}

void crash_stack(void) {
    static _Thread_local unsigned char stack[1 << 15];
    stack_t there;
    /* a sanitizer has set up a stack of its own, which it also removes, so that stack stays in
     * use */
    if (!sigaltstack(NULL, &there) && !(there.ss_flags & SS_DISABLE)) return;
    sigaltstack(&(stack_t){.ss_sp = stack, .ss_size = sizeof stack}, NULL);
}

void crash_guard(struct hal *hal, _Atomic bool *abort) {
    static const int errors[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS};
    struct sigaction action = {.sa_handler = on_crash, .sa_flags = (int)SA_RESETHAND | SA_NODEFER | SA_ONSTACK};
    crash_stack();
    guarded = hal;
    told = abort;
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) sigaction(errors[i], &action, NULL);
}
