/* Makes a thread real-time: SCHED_FIFO, locked and prefaulted memory, pinned to a processor if
 * requested. */
#ifndef HEXID_REALTIME_H
#define HEXID_REALTIME_H

#include "status.h"

struct loop_params;

enum realtime_mode { REALTIME_OFF, REALTIME_TRY, REALTIME_REQUIRE };

/* Limits malloc to one arena; to be called before any other thread starts. Each further arena would
 * reserve 64 MB of locked memory. Also, to return memory of a further arena to the system, malloc
 * reads a file of /proc, which a confined process may not do. */
void realtime_heap(void);

/* Makes the calling thread real-time. Returns 0 if everything was granted and SCHED_FIFO was read
 * back; with REALTIME_OFF does nothing and returns 0. Otherwise returns STATUS_UNSAFE; the error
 * names one of the refused parts and its remedy. With REALTIME_TRY the thread then continues with
 * the parts that were granted, and the caller shows the message. SAFETY: a refusal must not be
 * reported only in a log. */
int realtime_enter(const struct loop_params *params, enum realtime_mode mode, struct error *error);

/* Sets SCHED_FIFO for the calling thread, with the loop's priority less `below`, but at least 1. If
 * the kernel refuses, the thread continues unchanged. */
void realtime_follow(const struct loop_params *params, int below);

/* Unlocks the memory of the whole process. To be called when nothing is driven any more: the
 * remaining work may need more memory than may be locked. */
void realtime_leave(void);

#endif
