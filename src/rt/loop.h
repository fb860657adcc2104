/* The loop: in every period it wakes at an absolute deadline, reads, decides, writes, and passes on
 * the record. loop_cycle() and platform_step() contain all that decides on the machine's motion.
 *
 * An overrun is a cycle that begins a whole period or more after its deadline. On the real clock
 * missed cycles are skipped, never caught up in a burst: the next deadline is the next multiple of
 * the period. The late cycle's sample has the flag SAMPLE_OVERRUN, so that the identification
 * excludes it, and loop.overrun_limit deadlines missed in a row are a fault. On the paced clock the
 * simulated machine does not notice an overrun: time stretches by the missed periods. The reference
 * counts executed cycles, so it never jumps.
 *
 * The record ring: on the real clock, if the ring is full, the record is lost (counted, and visible
 * as a gap in seq) and the deadline is kept. On the other clocks the loop waits for room, so that
 * only an abort loses records. */
#ifndef HEXID_LOOP_H
#define HEXID_LOOP_H

#include <pthread.h>
#include <semaphore.h>

#include "clock.h"
#include "hal.h"
#include "mailbox.h"
#include "platform.h"
#include "realtime.h"
#include "ring.h"

struct loop {
    const struct params *params;
    struct hal *hal;
    struct ring *records;            /* records (struct cycle) from the loop to the recorder */
    struct mailbox requests;         /* requests from any thread to the loop */
    struct gains_box gains;          /* new gains, from the operator's thread */
    struct gains_box present;        /* present gains; set by the loop */
    _Atomic bool quit;         /* the loop must park and end; set by any thread with loop_quit() */
    _Atomic bool abort;        /* the loop must centre the valves and end now; set by any thread */
    _Atomic bool ended;              /* the last record is in the ring; set by the loop */
    _Atomic uint64_t attended; /* twice the number of calls of loop_attend(), plus 1 while the
                                * calling thread works */
    _Atomic bool unattended;   /* the loop parks because the thread that calls loop_attend() is held
                                * up; set by the loop */
    _Atomic uint64_t lost;   /* number of records lost because the ring was full; set by the loop */
    _Atomic uint64_t acted;          /* struct loop_acted, packed; loop_acted() unpacks it; set by
                                      * the loop */
    struct clock clock;
    struct platform platform;
    int64_t deadline_ns;
    int64_t overruns;                /* number of deadlines missed on the real clock */
    bool unwritten;                  /* the last command was not written */
    uint64_t attended_before;        /* `attended` in the last cycle */
    int64_t silent_cycles;           /* number of cycles since `attended` last changed */
    int64_t held_up_cycles;          /* level of the leaky bucket in watch_attendance() */
    enum realtime_mode mode;
    pthread_t thread;
    sem_t started;
    int realtime;                    /* return value of realtime_enter() */
    struct error realtime_error;     /* message of realtime_enter() if it was refused */
};

/* Initialises the loop. Main thread. The hal, the ring and params must outlive the loop. */
int loop_init(struct loop *l, const struct params *params, struct hal *hal, struct ring *records, enum clock_kind clock,
              struct error *error);

/* Starts the loop's thread. STATUS_IO: the thread cannot be started. If real time is refused with
 * REALTIME_REQUIRE, returns STATUS_UNSAFE, and nothing runs; with REALTIME_TRY the loop runs, and
 * l->realtime and l->realtime_error have the refusal. */
int loop_start(struct loop *l, enum realtime_mode mode, struct error *error);
void loop_join(struct loop *l);

/* Results of requests, as of the loop's last cycle. Any thread. */
struct loop_acted {
    uint32_t request_id;             /* id of the last request that was processed */
    bool taken;                      /* the last request had an effect in the state at that time */
    bool stopped;                    /* a stop has ended the latest tests, or is ending the present
                                      * one */
    enum state state;                /* current state of the supervisor */
    uint32_t wrong;                  /* inputs INPUT_... that are wrong now (platform_wrong()) */
    uint32_t first_fault;        /* the headline of the latched faults, one of FAULT_... (types.h);
                                  * 0: no fault is latched */
};
struct loop_acted loop_acted(const struct loop *l);

/* Returns the present gains of the loop. Any thread but the loop's. */
struct gains loop_gains(const struct loop *l);

/* Packs struct loop_acted into a word; public only for tests that replace the loop. Pure, RT. */
uint64_t loop_acted_word(const struct loop_acted *acted);

/* SAFETY: parks the platform in spite of any later request, and ends the loop as soon as the supply
 * is off. Any thread, also a signal handler; may be called repeatedly. */
void loop_quit(struct loop *l);

/* SAFETY: tells the loop that the thread that takes commands is alive. That thread calls this twice
 * in each of its rounds: before it waits for commands (works: false) and after the wait (works:
 * true).
 *
 * While anything holds that thread up, no command can stop the platform. So the loop counts the
 * cycles in which the thread has worked for LOOP_WORK_S or longer, or has waited for LOOP_ROUND_S
 * or longer; each cycle of a shorter wait subtracts LOOP_RECOVERY from the count. When the counted
 * cycles make up LOOP_ATTENDED_S, the loop parks, and accepts no other request until the count is 0
 * again. If the thread is held up without a break, the loop parks within LOOP_ROUND_S +
 * LOOP_ATTENDED_S; with breaks it takes longer, because the waits in between subtract.
 *
 * The loop counts from the first call on, but not in virtual time, with which no thread keeps
 * up. */
#define LOOP_ATTENDED_S 1.0
#define LOOP_ROUND_S 0.1
#define LOOP_WORK_S 0.01
#define LOOP_RECOVERY 4
void loop_attend(struct loop *l, bool works);

/* Runs one cycle. Returns false after the last cycle. RT: no heap, no lock, and no system calls but
 * those of clock and back-end. */
bool loop_cycle(struct loop *l);

#endif
