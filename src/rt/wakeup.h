/* Measures how late this computer wakes a periodic thread that does no work, but has the loop's
 * period, priority, processor, sleep and clock. The loop's own delays are in HEXID_LOOP_STATS.
 * Ordinary threads; blocks for the duration. */
#ifndef HEXID_WAKEUP_H
#define HEXID_WAKEUP_H

#include "histogram.h"
#include "status.h"

struct loop_params;

enum { WAKEUP_EDGES = 16 };
extern const int wakeup_edge_us[WAKEUP_EDGES]; /* upper edges of the bins of wakeups.count, in
                                                * microseconds: 1, 2, 5, 10, ... */

struct wakeups {
    struct histogram late;             /* delays of the wake-ups after their deadlines, ns */
    int64_t count[WAKEUP_EDGES + 1];   /* number of wake-ups in each bin: late by at least the
                                        * previous edge, but less than the bin's edge; in the last
                                        * bin, late by at least the last edge */
    int64_t half;        /* number of wake-ups late by half a period or more; on a field bus each
                          * causes a sample with SAMPLE_LATE */
    int64_t missed;       /* number of deadlines missed, counted as in the loop: one for each whole
                           * period of delay */
    int64_t missed_in_row;     /* most deadlines missed in a row, which loop.overrun_limit limits */
    int realtime; /* STATUS_OK: the thread had SCHED_FIFO and locked memory, and was pinned if
                   * requested; otherwise STATUS_UNSAFE */
    struct error realtime_error; /* why real time was refused */
};

/* Adds a wake-up to the counts. */
void wakeups_add(struct wakeups *w, int64_t late_ns, int64_t period_ns);

/* Measures wake-ups in a thread of its own, even if real time is refused. With duration_s 0 the
 * thread only requests real time. Afterwards the process's memory is unlocked. STATUS_IO: the
 * thread cannot be started. */
int wakeups_measure(const struct loop_params *loop, double duration_s, struct wakeups *w, struct error *error);

#endif
