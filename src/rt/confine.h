/* Confinement: what the running daemon may still ask of the system. A hole in a parser of CAN,
 * Modbus or LCM then neither starts a program nor writes a file, whoever the daemon runs as.
 *
 * What is denied fails with EPERM. SAFETY: it never kills, for a daemon that is killed
 * drops a platform.
 *
 * Allowed, to all threads: to read and write what is open, to accept connections where a socket
 * listens already, to wait and to tell the time, memory that is not executable, signals to this
 * process, to end; to create the file beside the result, to rename or link it to the result and to
 * remove it (output.h), by the two paths that stand in memory which can no longer be written,
 * unmapped or replaced. Where a back-end makes its connection again: internet sockets that
 * connect, reading files (the resolver's), opening a serial device, and SCHED_FIFO for its thread;
 * where it opens a CAN socket again: that, and to ask for the interface's index and state. Denied
 * is all else: programs, new threads, other files, other sockets, other processes, mounts, users,
 * modules.
 *
 * Sanitizer builds have an allocator, threads and reports of their own that need more: there
 * nothing is denied. */
#ifndef HEXID_CONFINE_H
#define HEXID_CONFINE_H

#include <stdbool.h>

#include "output.h"
#include "status.h"

struct confinement {
    struct output *result; /* that is still written; its paths are moved. NULL: none */
    bool reconnects;       /* the back-end makes its connection again, */
    bool reopens_can;      /* or its CAN socket */
};

/* Main thread, once, when all is open and all threads run; for the rest of the process. No new
 * privileges, the filter for all threads (SECCOMP_FILTER_FLAG_TSYNC), and confine_thread(). A few
 * ms. STATUS_UNSAFE: the kernel refused; what it refuses a part of is not confined. */
int confine(const struct confinement *c, struct error *error);

/* Any thread, for itself: drops all capabilities, for which the system has no call that reaches
 * other threads. SCHED_FIFO and locked memory that it has stay. What a thread could do with those
 * it keeps the filter denies. RT: one system call. */
void confine_thread(void);

#endif
