/* How late this computer wakes a periodic thread: the loop's period, priority, processor, sleep and
 * clock, and no work. What the loop does on top of it is its own (HEXID_LOOP_STATS). Ordinary
 * threads; takes its time. */
#ifndef HEXID_WAKEUP_H
#define HEXID_WAKEUP_H

#include "histogram.h"
#include "params.h"
#include "status.h"

enum { WAKEUP_EDGES = 16 };
extern const int wakeup_edge_us[WAKEUP_EDGES]; /* 1, 2, 5, 10, ... */

struct wakeups {
    struct histogram late;             /* ns behind the deadline */
    int64_t count[WAKEUP_EDGES + 1];   /* later than the edge before, by less than this one;
                                        * last: later than all */
    int64_t half;                      /* by half a period and more: what a field
                                        * bus calls a late sample */
    int64_t missed;                    /* deadlines missed: by each whole period, as
                                        * the loop counts them, */
    int64_t missed_in_row;             /* and the most of them in a row, as
                                        * loop.overrun_limit counts them */
    int realtime;                      /* STATUS_OK: SCHED_FIFO, memory locked, pinned where that is
                                        * asked for; else what was refused: */
    struct error realtime_error;
};

/* Takes one wake-up in. */
void wakeups_add(struct wakeups *w, int64_t late_ns, int64_t period_ns);

/* In a thread of its own, which goes on as it is where real time is refused; duration_s 0: asks for
 * real time, and sleeps not once. The process's memory is unlocked again. STATUS_IO: no thread. */
int wakeups_measure(const struct loop_params *loop, double duration_s, struct wakeups *w, struct error *error);

#endif
