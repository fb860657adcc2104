/* SAFETY: a program error in any thread must not leave valves open until the device's watchdog
 * notices. The handler tells the loop to end, calls the back-end's safe() itself, gives
 * back-ends with a thread of their own the time to send, and lets the signal do what it does:
 * core dump, status. */
#ifndef HEXID_CRASH_H
#define HEXID_CRASH_H

#include "hal.h"

/* Main thread, before the loop starts; hal and abort must outlive the process's
 * threads. `abort` is set. */
void crash_guard(struct hal *hal, _Atomic bool *abort);

/* Any thread, first of all: its handler has a stack of its own, so that a stack that overflows is a
 * crash like others. */
void crash_stack(void);

#endif
