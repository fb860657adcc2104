/* The loop's time: nanoseconds since the loop's start, in one of three kinds.
 *
 *   real     CLOCK_MONOTONIC, for hardware and `--rt require`; missed time is lost.
 *   paced    For the simulated platform. It follows CLOCK_MONOTONIC as long as the host keeps up,
 *            and is stretched when the host is late, so that the loop sees the times of a virtual
 *            clock.
 *   virtual  For `--fast`: time goes on as fast as the loop can run.
 *
 * All functions are RT. Any thread may call clock_now(); only the thread that runs the loop calls
 * the other functions, except that loop_init() also calls clock_start() in the main thread. */
#ifndef HEXID_CLOCK_H
#define HEXID_CLOCK_H

#include <stdatomic.h>
#include <stdint.h>

enum clock_kind { CLOCK_REAL, CLOCK_PACED, CLOCK_VIRTUAL };

struct clock {
    enum clock_kind kind;
    int64_t start_ns;        /* CLOCK_MONOTONIC at the loop's start, plus all stretching of a paced
                              * clock; 0 on a virtual clock */
    int64_t system_us;       /* CLOCK_REALTIME at the loop's start; 0 on a virtual clock */
    int64_t woke_ns;         /* CLOCK_MONOTONIC when the last wait ended; 0 on a virtual clock */
    _Atomic int64_t now_ns;  /* time of a paced or virtual clock */
};

void clock_start(struct clock *c, enum clock_kind kind);
int64_t clock_now(const struct clock *c);

/* Sleeps until this time on the loop's clock; signals do not end the sleep. Returns the time after
 * the sleep, and in *late_ns the delay of the wake-up (0 on a virtual clock). */
int64_t clock_wait(struct clock *c, int64_t until_ns, int64_t *late_ns);

/* Stretches a paced clock: shifts all later times by by_ns, a delay of the host. */
void clock_stretch(struct clock *c, int64_t by_ns);

/* Returns the CLOCK_MONOTONIC time since the end of the last wait; 0 on a virtual clock. */
int64_t clock_since_wake(const struct clock *c);

/* Lets other threads run: sleeps for a millisecond. For a loop on a paced or virtual clock that
 * waits for another thread. */
void clock_yield(void);

#endif
