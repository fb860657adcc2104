/* Confinement: restricts the system calls of the running daemon. A vulnerability in a parser of
 * CAN, Modbus or LCM can then neither start a program nor create, rename or delete a file other
 * than the result and its temporary file, whichever user runs the daemon.
 *
 * A denied call fails with EPERM. SAFETY: the filter never kills the process, because a killed
 * daemon drops a platform.
 *
 * Allowed in all threads: reading and writing open descriptors, accepting connections on listening
 * sockets, settings of open terminals and serial lines, the status of any file, waiting, reading
 * the clock, memory that is not executable, signals to this process, and exit. Also allowed:
 * creating the temporary file beside the result, renaming or linking it to the result, and removing
 * it (output.h). The filter compares the addresses of these two paths; they lie in memory that can
 * no longer be written, unmapped or replaced.
 *
 * A back-end that opens its device again after a lost connection gets more:
 *
 *   internet sockets  SCHED_FIFO for its thread, connecting, and reading any file, because the
 *                     resolver reads some
 *   serial device     SCHED_FIFO for its thread, and opening any existing file with the flags of a
 *                     serial device. The filter cannot compare paths that are not fixed, so only
 *                     the user's file permissions protect other files.
 *   CAN socket        opening a CAN socket, and asking for the interface's index, type and state
 *
 * Everything else is denied: programs, new threads, other files, sockets and processes, mounts,
 * users, modules. Sanitizer builds deny nothing, because the sanitizer's allocator, threads and
 * reports need more calls. */
#ifndef HEXID_CONFINE_H
#define HEXID_CONFINE_H

#include <stdbool.h>

#include "hal.h"
#include "output.h"
#include "status.h"

struct confinement {
    struct output *result; /* result that is still to be written; confine() moves its paths to
                            * read-only memory. NULL: none */
    enum hal_reopens reopens; /* device that the back-end opens again after a lost connection; the
                               * filter allows the calls for it */
};

/* Confines the process: sets no_new_privs, installs the filter for all threads
 * (SECCOMP_FILTER_FLAG_TSYNC), and calls confine_thread(). To be called once by the main thread,
 * when everything is open and all threads run; it cannot be undone. Takes a few ms. STATUS_UNSAFE:
 * the kernel refused a step, and the process has no filter, though perhaps no_new_privs. */
int confine(const struct confinement *c, struct error *error);

/* Drops all capabilities of the calling thread; no system call can drop another thread's. A thread
 * that does not call this keeps its capabilities, but the filter denies the calls that need them.
 * SCHED_FIFO and locked memory stay. RT: one system call. */
void confine_thread(void);

#endif
