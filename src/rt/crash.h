/* SAFETY: a program error in any thread must not leave valves open until the device's watchdog
 * expires. The signal handler tells the loop to end, calls the back-end's safe() itself, gives
 * back-ends with threads time to send, and then lets the signal take its default effect (core dump,
 * exit status). */
#ifndef HEXID_CRASH_H
#define HEXID_CRASH_H

#include "hal.h"

/* Installs the handler, which tells the loop to end by setting *abort. Main thread, before the loop
 * starts; hal and abort must outlive the process's threads. */
void crash_guard(struct hal *hal, _Atomic bool *abort);

/* To be called first in every thread: gives the signal handler a separate stack in this thread, so
 * that a stack overflow is handled like other crashes. */
void crash_stack(void);

#endif
