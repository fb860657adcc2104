#include "clock.h"

#include <errno.h>
#include <time.h>

#include "units.h"

static int64_t read_ns(clockid_t id) {
    struct timespec t;
    clock_gettime(id, &t);
    return t.tv_sec * NS_PER_S + t.tv_nsec;
}

void clock_start(struct clock *c, bool virtual_time) {
    *c = (struct clock){.virtual_time = virtual_time};
    if (virtual_time) return;
    c->start_ns = read_ns(CLOCK_MONOTONIC);
    c->system_us = read_ns(CLOCK_REALTIME) / NS_PER_US;
}

int64_t clock_now(const struct clock *c) { return c->virtual_time ? c->now_ns : read_ns(CLOCK_MONOTONIC) - c->start_ns; }

int64_t clock_wait(struct clock *c, int64_t until_ns) {
    int64_t absolute_ns = c->start_ns + until_ns;
    struct timespec t = {.tv_sec = absolute_ns / NS_PER_S, .tv_nsec = absolute_ns % NS_PER_S};
    if (c->virtual_time) return c->now_ns = until_ns;
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) continue;
    return clock_now(c);
}
