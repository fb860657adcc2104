/* Confinement: restricts the system calls of the running daemon, so that a vulnerability in a
 * parser of CAN, Modbus or LCM can neither start a program nor make, rename or delete a file other
 * than the result and its temporary file, whichever user runs the daemon.
 *
 * A denied call fails with EPERM. SAFETY: the filter never kills the process, because a killed
 * daemon drops a platform.
 *
 * Allowed in all threads: reading and writing open descriptors, accepting connections on listening
 * sockets, settings of open terminals and serial lines, the status of any file, waiting, reading
 * the clock, memory that is not executable, signals to this process, and exit. Also allowed:
 * creating the temporary file beside the result, renaming or linking it to the result and removing
 * it (output.h). The filter compares the addresses of these two paths, which lie in memory that can
 * no longer be written, unmapped or replaced.
 *
 * A back-end that reconnects is also allowed SCHED_FIFO for its thread, and either connecting
 * internet sockets and reading any file (the resolver reads some), or, on a serial line, opening an
 * existing file with the flags of a serial device. The filter cannot compare the paths of these
 * files, so that on a serial line the user's file permissions alone protect other files. A back-end
 * that reopens a CAN socket is also allowed to open it, and to ask for the interface's index, type
 * and state. Everything else is denied: programs, new threads, other files, sockets and processes,
 * mounts, users, modules.
 *
 * Sanitizer builds need more calls for their allocator, threads and reports, so nothing is denied
 * there. */
#ifndef HEXID_CONFINE_H
#define HEXID_CONFINE_H

#include <stdbool.h>

#include "hal.h"
#include "output.h"
#include "status.h"

struct confinement {
    struct output *result; /* result that is still to be written; confine() copies its paths to
                            * read-only memory. NULL: none */
    enum hal_reopens reopens; /* device that the back-end opens again after a lost connection */
};

/* Confines the process. To be called by the main thread, once, when everything is open and all
 * threads run; it cannot be undone. Sets no_new_privs, the filter for all threads
 * (SECCOMP_FILTER_FLAG_TSYNC), and calls confine_thread(). Takes a few ms. STATUS_UNSAFE: the
 * kernel refused a step, and the process has no filter; no_new_privs may be set all the same. */
int confine(const struct confinement *c, struct error *error);

/* Drops all capabilities of the calling thread, because no system call drops another thread's.
 * Threads that do not call it keep theirs, but the filter denies the calls that need them.
 * SCHED_FIFO and locked memory stay. RT: one system call. */
void confine_thread(void);

#endif
