#include "signals.h"

#include <errno.h>
#include <time.h>
#include <unistd.h>

#include "confine.h"
#include "crash.h"
#include "monotonic.h"
#include "params.h"
#include "process.h"
#include "realtime.h"
#include "thread.h"
#include "units.h"

/* BELOW_LOOP: difference between the loop's SCHED_FIFO priority and this thread's. This thread is
 * still more urgent than the main thread, which is busy as long as somebody floods it with
 * commands. */
enum { BELOW_LOOP = 1, WAKE = SIGUSR1 };

static bool by_hand(int number) { return number == SIGINT || number == SIGTERM || number == SIGQUIT; }

/* Tells the operator, unless signals_mute() was called. signals_mute() waits until this function
 * has ended; this function never waits for signals_mute(). */
static void tell(struct signals *s, const char *text) {
    atomic_store(&s->telling, true);
    if (!atomic_load(&s->mute)) s->say(s->context, text);
    atomic_store(&s->telling, false);
}

/* SAFETY: passes a signal to the loop, and only then tells the operator. Nothing here may block:
 * while this thread waits, it cannot take a second signal, which must centre the valves. */
static void stop_loop(struct signals *s, int number, int64_t now_ns) {
    if (!atomic_load(&s->first)) {
        loop_quit(s->loop);
        s->first_ns = now_ns;
        atomic_store(&s->first, number);
        tell(s, "interrupted: parking (once more to centre the valves at once)");
    } else if (by_hand(number) && now_ns - s->first_ns >= SIGNALS_APART_NS && !atomic_exchange(&s->loop->abort, true)) {
        tell(s, "interrupted again: valves centred");
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

/* Takes a signal that comes after the loop's end. A signal within SIGNALS_APART_NS of the first
 * counts as part of it and is dropped. */
static void take_late(struct signals *s, int number, int64_t now_ns) {
    if (atomic_load(&s->first) && now_ns - s->first_ns < SIGNALS_APART_NS) return;
    if (!atomic_load(&s->late)) {
        s->late_ns = now_ns;
        atomic_store(&s->late, number);
        tell(s, "ends when the log is closed (once more to end at once)");
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
    sem_post(&s->started);
    for (;;) {
        if (sigwaitinfo(&s->set, &signal) < 0) {
            if (errno == EINTR) continue;
            /* SAFETY: no more signals can be taken, so the platform is parked; another try could
             * make this thread spin and starve others */
            atomic_store(&s->refused, errno);
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

/* SAFETY: blocks the signals in all threads, so that every signal reaches the thread that parks the
 * platform, and no signal ends the process. */
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

void signals_block(struct signals *s) {
    *s = (struct signals){0};
    block(&s->set);
}

int signals_start(struct signals *s, struct loop *loop, bool realtime, signals_say *say, void *context, struct error *error) {
    s->loop = loop;
    s->realtime = realtime;
    s->confine = loop->params->security.confine;
    s->say = say;
    s->context = context;
    sem_init(&s->started, 0, 0);
    int status = thread_start(&s->thread, "signals", THREAD_STACK_COPY, signals_thread, s, error);
    s->running = !status;
    if (status) return status;
    while (sem_wait(&s->started)) continue;
    return STATUS_OK;
}

void signals_mute(struct signals *s) {
    atomic_store(&s->mute, true);
    while (atomic_load(&s->telling)) nanosleep(&(struct timespec){.tv_nsec = NS_PER_MS}, NULL);
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
