#include "wakeup.h"

#include "clock.h"
#include "params/loop.h"
#include "realtime.h"
#include "thread.h"
#include "units.h"

const int wakeup_edge_us[WAKEUP_EDGES] = {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000, 100000};

struct measurement {
    const struct loop_params *loop;
    double duration_s;
    struct wakeups *wakeups;
};

void wakeups_add(struct wakeups *w, int64_t late_ns, int64_t period_ns) {
    int edge = 0;
    while (edge < WAKEUP_EDGES && late_ns >= wakeup_edge_us[edge] * NS_PER_US) edge++;
    w->count[edge]++;
    histogram_add(&w->late, late_ns);
    w->half += 2 * late_ns >= period_ns;
}

/* Wakes periodically, with deadlines as in loop_cycle() on the real clock: missed deadlines are
 * skipped. */
static void *wake(void *argument) {
    struct measurement *m = argument;
    struct wakeups *w = m->wakeups;
    struct clock clock;
    int64_t period_ns = ns_from_seconds(m->loop->period_s), end_ns = ns_from_seconds(m->duration_s);
    w->realtime = realtime_enter(m->loop, REALTIME_TRY, &w->realtime_error);
    clock_start(&clock, CLOCK_REAL);
    for (int64_t deadline_ns = period_ns, in_row = 0; deadline_ns < end_ns; deadline_ns += period_ns) {
        int64_t late_ns;
        clock_wait(&clock, deadline_ns, &late_ns);
        int64_t missed = late_ns / period_ns;
        wakeups_add(w, late_ns, period_ns);
        in_row = missed ? in_row + missed : 0;
        w->missed += missed;
        if (in_row > w->missed_in_row) w->missed_in_row = in_row;
        deadline_ns += missed * period_ns;
    }
    return NULL;
}

int wakeups_measure(const struct loop_params *loop, double duration_s, struct wakeups *w, struct error *error) {
    pthread_t thread;
    struct measurement m = {.loop = loop, .duration_s = duration_s, .wakeups = w};
    *w = (struct wakeups){0};
    realtime_heap();
    int status = thread_start(&thread, "wake-up", THREAD_STACK_REALTIME, wake, &m, error);
    if (status) return status;
    pthread_join(thread, NULL);
    realtime_leave();
    return STATUS_OK;
}
