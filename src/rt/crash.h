/* SAFETY: a program error in any thread must not leave valves open until the device's watchdog
 * expires. The signal handler tells the loop to end, and calls the back-end's safe() itself. Then
 * it waits, so that a back-end with a thread of its own can send, and lets the signal take its
 * default effect (core dump, exit status). */
#ifndef HEXID_CRASH_H
#define HEXID_CRASH_H

#include "hal.h"

/* Installs the handler, which sets *abort to tell the loop to end. Main thread, before the loop
 * starts; hal and abort must outlive all threads of the process. */
void crash_guard(struct hal *hal, _Atomic bool *abort);

/* To be called first in every thread of the daemon: gives the signal handler a separate stack in
 * this thread, so that a stack overflow is handled like other crashes. */
void crash_stack(void);

#endif
