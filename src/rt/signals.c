#include "signals.h"

#include <errno.h>
#include <unistd.h>

#include "confine.h"
#include "crash.h"
#include "monotonic.h"
#include "params.h"
#include "process.h"
#include "realtime.h"
#include "thread.h"
#include "units.h"

/* Distance of the thread's SCHED_FIFO priority below the loop's. It is higher than the main
 * thread's, which may be busy for as long as somebody floods it. */
enum { BELOW_LOOP = 1, WAKE = SIGUSR1 };

static bool by_hand(int number) { return number == SIGINT || number == SIGTERM || number == SIGQUIT; }

/* SAFETY: passes a signal to the loop. Nothing in here can block or print: a thread that waits
 * takes no second signal, which centres the valves. */
static void stop_loop(struct signals *s, int number, int64_t now_ns) {
    if (!atomic_load(&s->first)) {
        loop_quit(s->loop);
        s->first_ns = now_ns;
        atomic_store(&s->first, number);
    } else if (by_hand(number) && now_ns - s->first_ns >= SIGNALS_APART_NS && !atomic_exchange(&s->loop->abort, true)) {
        atomic_store(&s->centred, true);
    }
}

static void end_process(int number) {
    sigset_t set;
    signal(number, SIG_DFL);
    sigemptyset(&set);
    sigaddset(&set, number);
    pthread_sigmask(SIG_UNBLOCK, &set, NULL);
    raise(number);
}

/* Takes a signal that comes after the loop's end. One that belongs to the signal which ended a loop
 * that drove nothing has no further effect. */
static void take_late(struct signals *s, int number, int64_t now_ns) {
    if (atomic_load(&s->first) && now_ns - s->first_ns < SIGNALS_APART_NS) return;
    if (!atomic_load(&s->late)) {
        s->late_ns = now_ns;
        atomic_store(&s->late, number);
    } else if (by_hand(number) && now_ns - s->late_ns >= SIGNALS_APART_NS) end_process(number);
}

/* Returns true if signals_release() sent this signal. */
static bool wakes(const struct signals *s, const siginfo_t *signal) {
    return atomic_load(&s->over) && signal->si_signo == WAKE && signal->si_pid == getpid();
}

static void *signals_thread(void *argument) {
    struct signals *s = argument;
    siginfo_t signal;
    crash_stack();
    if (s->realtime) realtime_follow(&s->loop->params->loop, BELOW_LOOP);
    if (s->confine) confine_thread();
    for (;;) {
        if (sigwaitinfo(&s->set, &signal) < 0) {
            if (errno == EINTR) continue;
            /* SAFETY: signals can be taken no more, and this thread must not spin ahead of others,
             * so the platform is parked */
            loop_quit(s->loop);
            return NULL;
        }
        if (wakes(s, &signal)) return NULL;
        int64_t now_ns = monotonic_ns();
        if (!atomic_load(&s->loop->ended)) stop_loop(s, signal.si_signo, now_ns);
        else take_late(s, signal.si_signo, now_ns);
        atomic_fetch_add(&s->taken, 1);
    }
}

/* SAFETY: blocks the signals in all threads, so that each of them reaches the thread that parks the
 * platform and none ends the process. */
static void block(sigset_t *set) {
    static const int ignored[] = {SIGTTIN, SIGTTOU};
    static const int stops[] = {SIGINT,    SIGTERM, SIGHUP, SIGQUIT, SIGUSR1,   SIGUSR2, SIGALRM,
                                SIGVTALRM, SIGPROF, SIGIO,  SIGPWR,  SIGSTKFLT, SIGTSTP, SIGXCPU};
    process_survive_readers();
    for (size_t i = 0; i < sizeof ignored / sizeof *ignored; i++) signal(ignored[i], SIG_IGN);
    sigemptyset(set);
    for (size_t i = 0; i < sizeof stops / sizeof *stops; i++)
        if (!process_ignores(stops[i])) sigaddset(set, stops[i]);
    for (int number = SIGRTMIN; number <= SIGRTMAX; number++) sigaddset(set, number);
    pthread_sigmask(SIG_BLOCK, set, NULL);
}

int signals_start(struct signals *s, struct loop *loop, bool realtime, struct error *error) {
    *s = (struct signals){.loop = loop, .realtime = realtime, .confine = loop->params->security.confine};
    block(&s->set);
    int status = thread_start(&s->thread, "signals", THREAD_STACK_COPY, signals_thread, s, error);
    s->running = !status;
    return status;
}

void signals_release(struct signals *s) {
    if (!s->running) return;
    atomic_store(&s->over, true);
    pthread_kill(s->thread, WAKE);
    pthread_join(s->thread, NULL);
    s->running = false;
    pthread_sigmask(SIG_UNBLOCK, &s->set, NULL);
    if (atomic_load(&s->late)) raise(atomic_load(&s->late));
}
