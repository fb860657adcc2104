/* What makes a thread real-time: SCHED_FIFO, locked and prefaulted memory, a processor of
 * its own when asked. */
#ifndef HEXID_REALTIME_H
#define HEXID_REALTIME_H

#include "params.h"
#include "status.h"

enum realtime_mode { REALTIME_OFF, REALTIME_TRY, REALTIME_REQUIRE };

/* Before any other thread: one heap for all. malloc reserves 64 MB for each further one, which
 * count as locked memory, and before it gives back of one it reads a file of /proc, which a
 * confined process may not. */
void realtime_heap(void);

/* For the calling thread. 0: all of it was got, and read back. Otherwise STATUS_UNSAFE with what
 * was refused and the remedy; with REALTIME_TRY the thread goes on with what it got and the caller
 * shows the message. SAFETY: a daemon that did not get it never says so only in a log. */
int realtime_enter(const struct loop_params *params, enum realtime_mode mode, struct error *error);

/* SCHED_FIFO for the calling thread, so much below the loop's; where that is refused it
 * goes on as it is. */
void realtime_follow(const struct loop_params *params, int below);

/* Memory is locked no longer, of the whole process: once nothing is driven, what is left to do may
 * need more of it than may be locked. */
void realtime_leave(void);

#endif
