/* Makes a thread real-time: SCHED_FIFO, locked and prefaulted memory, pinned to a processor if
 * requested. */
#ifndef HEXID_REALTIME_H
#define HEXID_REALTIME_H

#include "status.h"

struct loop_params;

enum realtime_mode { REALTIME_OFF, REALTIME_TRY, REALTIME_REQUIRE };

/* Limits malloc to one arena; to be called before any other thread starts. Each further arena would
 * reserve 64 MB of locked memory. Also, before malloc returns memory of such an arena to the
 * system, it reads a file of /proc, which a confined process may not do. */
void realtime_heap(void);

/* Makes the calling thread real-time; with REALTIME_OFF it does nothing and returns 0. Returns 0 if
 * everything was granted, and SCHED_FIFO was read back. Otherwise returns STATUS_UNSAFE with one of
 * the refused parts and its remedy; with REALTIME_TRY the thread continues with the parts that were
 * granted, and the caller shows the message. SAFETY: a refusal is never reported only in a log. */
int realtime_enter(const struct loop_params *params, enum realtime_mode mode, struct error *error);

/* Sets SCHED_FIFO for the calling thread. Its priority is lower than the loop's by `below`, but at
 * least 1. If that is refused, the thread continues unchanged. */
void realtime_follow(const struct loop_params *params, int below);

/* Unlocks the memory of the whole process. To be called when nothing is driven any more, because
 * the remaining work may need more memory than may be locked. */
void realtime_leave(void);

#endif
