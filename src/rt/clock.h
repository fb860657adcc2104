/* The loop's time: nanoseconds since the loop's start, of one of three kinds.
 *
 *   real     CLOCK_MONOTONIC. What is missed is missed. Hardware, and `--rt require`.
 *   paced    Follows CLOCK_MONOTONIC as long as the host keeps up, and stretches where it does not:
 *            the loop sees the same times as on a virtual clock. The simulated platform.
 *   virtual  As fast as the loop can go: `--fast`.
 *
 * All functions are RT; clock_now() may be called by any thread, the others by the loop's only. */
#ifndef HEXID_CLOCK_H
#define HEXID_CLOCK_H

#include <stdatomic.h>
#include <stdint.h>

enum clock_kind { CLOCK_REAL, CLOCK_PACED, CLOCK_VIRTUAL };

struct clock {
    enum clock_kind kind;
    int64_t start_ns;          /* CLOCK_MONOTONIC at zero; later by what a
                                * paced clock was stretched */
    int64_t system_us;         /* CLOCK_REALTIME at zero; 0 on a virtual clock */
    int64_t woke_ns;           /* CLOCK_MONOTONIC at the end of the last wait; 0 on a virtual
                                * clock */
    _Atomic int64_t now_ns;    /* paced and virtual: the time */
};

void clock_start(struct clock *c, enum clock_kind kind);
int64_t clock_now(const struct clock *c);

/* Sleeps until the absolute time, interrupted or not; returns the time it is then, and how much
 * later than wanted the host woke the thread (0 on a virtual clock). */
int64_t clock_wait(struct clock *c, int64_t until_ns, int64_t *late_ns);

/* Of a paced clock: the host was late by so much, and the time after it is later by as much. */
void clock_stretch(struct clock *c, int64_t by_ns);

/* The host's time since the last wait ended; 0 on a virtual clock. */
int64_t clock_since_wake(const struct clock *c);

/* Lets other threads run; for loops that wait for one on a paced or virtual clock. */
void clock_yield(void);

#endif
