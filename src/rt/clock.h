/* The loop's time: nanoseconds since the loop's start, from CLOCK_MONOTONIC, or virtual and only as fast as its user. RT. */
#ifndef HEXID_CLOCK_H
#define HEXID_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

struct clock {
    bool virtual_time;
    int64_t start_ns;          /* CLOCK_MONOTONIC at zero */
    int64_t system_us;         /* CLOCK_REALTIME at zero; 0 on a virtual clock */
    int64_t now_ns;            /* virtual */
};

void clock_start(struct clock *c, bool virtual_time);
int64_t clock_now(const struct clock *c);

/* Sleeps until the absolute time; returns the time it is then. A virtual clock is simply set. Interrupted sleeps go on. */
int64_t clock_wait(struct clock *c, int64_t until_ns);

#endif
