#include "clock.h"

#include <errno.h>
#include <time.h>

#include "monotonic.h"
#include "units.h"

static const int64_t yield_ns = NS_PER_S / 1000; /* duration of clock_yield(), which sleeps because
                                                  * a real-time thread that spins would starve
                                                  * others */

static void sleep_until(int64_t at_ns) {
    struct timespec t = {.tv_sec = at_ns / NS_PER_S, .tv_nsec = at_ns % NS_PER_S};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) continue;
}

static void set(struct clock *c, int64_t now_ns) { atomic_store_explicit(&c->now_ns, now_ns, memory_order_relaxed); }

void clock_start(struct clock *c, enum clock_kind kind) {
    *c = (struct clock){.kind = kind};
    if (kind == CLOCK_VIRTUAL) return;
    c->start_ns = c->woke_ns = monotonic_ns();
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    c->system_us = (t.tv_sec * NS_PER_S + t.tv_nsec) / NS_PER_US;
}

int64_t clock_now(const struct clock *c) {
    if (c->kind != CLOCK_REAL) return atomic_load_explicit(&c->now_ns, memory_order_relaxed);
    return monotonic_ns() - c->start_ns;
}

int64_t clock_wait(struct clock *c, int64_t until_ns, int64_t *late_ns) {
    *late_ns = 0;
    set(c, until_ns);
    if (c->kind == CLOCK_VIRTUAL) return until_ns;
    sleep_until(c->start_ns + until_ns);
    c->woke_ns = monotonic_ns();
    *late_ns = c->woke_ns - c->start_ns - until_ns;
    return c->kind == CLOCK_REAL ? until_ns + *late_ns : until_ns;
}

void clock_stretch(struct clock *c, int64_t by_ns) { c->start_ns += by_ns; }

int64_t clock_since_wake(const struct clock *c) { return c->kind == CLOCK_VIRTUAL ? 0 : monotonic_ns() - c->woke_ns; }

void clock_yield(void) { sleep_until(monotonic_ns() + yield_ns); }
