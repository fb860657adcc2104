/* Takes the signals that end a run in a thread of its own, and passes them to the loop at once,
 * whatever holds up the main thread.
 *
 * While the loop runs, the first signal parks the platform and ends the run; a later SIGINT,
 * SIGTERM or SIGQUIT centres the valves. The thread itself tells the operator, who must know that
 * the first press was taken before he presses again. A lost terminal and timeout(1) send two
 * signals within milliseconds, so signals within SIGNALS_APART_NS of the first count as part of it.
 *
 * After the loop's end nothing is driven any more. A signal then has its default effect, but not
 * before signals_release(), so that the log is closed first. A person who does not want to wait for
 * that sends SIGINT, SIGTERM or SIGQUIT once more. */
#ifndef HEXID_SIGNALS_H
#define HEXID_SIGNALS_H

#include <pthread.h>
#include <semaphore.h>
#include <signal.h>

#include "loop.h"
#include "status.h"

#define SIGNALS_APART_NS (3 * NS_PER_S / 10)

/* Tells the operator this line; must not wait and must take no lock. The signals' thread calls
 * it. */
typedef void signals_say(void *context, const char *text);

struct signals {
    struct loop *loop;
    bool realtime;         /* the thread follows the loop's SCHED_FIFO */
    bool confine;          /* the thread drops its capabilities */
    bool running;          /* the thread has been started and not yet released */
    sigset_t set;          /* signals that are taken */
    signals_say *say;      /* tells the operator what a signal has done */
    void *context;         /* first argument of `say` */
    pthread_t thread;
    sem_t started;         /* posted when the thread has set its priority and dropped its
                            * capabilities */
    int64_t first_ns;      /* CLOCK_MONOTONIC time of `first`; only the thread uses it */
    int64_t late_ns;       /* CLOCK_MONOTONIC time of `late`; only the thread uses it */
    _Atomic int first;     /* number of the first signal that came while the loop ran; 0: none */
    _Atomic int late;      /* number of the first signal that came after the loop's end; 0: none */
    _Atomic int refused;   /* errno with which the system refused to wait for signals; 0: not
                            * refused */
    _Atomic bool telling;  /* the thread may be inside `say` */
    _Atomic bool mute;     /* `say` must not be called any more */
    _Atomic bool over;     /* the thread must end */
    _Atomic unsigned taken; /* number of signals that were taken; only tests use it */
};

/* Blocks the signals that would end or stop the process; threads that start later inherit the mask.
 * SIGTTIN, SIGTTOU, SIGPIPE and SIGXFSZ (process.h), and under nohup(1) SIGHUP, are ignored. Main
 * thread, before it starts other threads. */
void signals_block(struct signals *s);

/* Starts the thread that takes the signals, including those that came since signals_block(), and
 * waits until the thread has set its priority, which it cannot do in a confined process. Main
 * thread. realtime: the thread follows the loop's priority. STATUS_IO: the thread cannot be
 * started; the signals remain blocked. */
int signals_start(struct signals *s, struct loop *loop, bool realtime, signals_say *say, void *context, struct error *error);

/* After this call `say` is not called any more. Main thread. */
void signals_mute(struct signals *s);

/* Ends the thread and unblocks the signals. A signal that came after the loop's end now takes its
 * default effect, in most cases the end of the process. Does nothing if the thread does not run.
 * Main thread, when the log is closed. */
void signals_release(struct signals *s);

#endif
