/* Process start for all subcommands: main() calls it first, so that a program behaves the same
 * whatever state the caller left behind.
 *
 *   descriptors   If 0, 1 or 2 is closed, it is opened on /dev/null in the wrong direction, so
 *                 that reading or writing it fails. Otherwise a file, socket or bus opened later
 *                 could get this number, and with it the output meant for a terminal.
 *   signals       The mask is emptied. SIGPIPE and SIGCHLD get their default actions, so that a
 *                 closed pipe ends a command and gnuplot's status can be fetched. SIGXFSZ is
 *                 ignored, so that a file limit becomes a write error that names the file.
 *   umask         Write permission for others is removed; the rest is the caller's choice.
 *   stack         The soft limit is raised to PROCESS_STACK, or to the hard limit if lower; the
 *                 kernel leaves more address space below the stack than that. Threads that
 *                 libraries start get THREAD_STACK_REALTIME (thread.h).
 *   open files    The soft limit is raised to PROCESS_FILES.
 *   locale        Always "C": setlocale() is never called, LANG and LC_* have no effect. TZ matters
 *                 only for the names of logs.
 *   environment   Variables that make GLib (loaded by liblcm) print to standard output, or abort
 *                 on a warning, are removed. MALLOC_* and LD_* act before main(), at the caller's
 *                 choice; LCM_DEFAULT_URL is not read, because the URL is always given. */
#ifndef HEXID_PROCESS_H
#define HEXID_PROCESS_H

#include <stdbool.h>

#include "status.h"

enum {
    PROCESS_STACK = 8 << 20, /* bytes of stack; `hexid gap` uses the most stack, and less than this
                              * (tests/bench/stacks.py) */
    PROCESS_FILES = 128,     /* a run opens fewer than 32 descriptors, and 66 more for clients of
                              * `hexid command` */
};

/* Brings the process into the state described above. Main thread, before anything else. STATUS_IO:
 * a standard descriptor is closed and cannot be opened. */
int process_start(struct error *error);

/* Checks that the process's limits suffice; to be called after process_start(). STATUS_IO: a limit
 * is too low; the error has the limit, its value and the remedy. SAFETY: `hexid command` calls this
 * only for `set`, because a stop must work within any limits. */
int process_limits(struct error *error);

/* Returns true if this signal must stay ignored because the program's caller ignored it. This holds
 * for SIGHUP only, because nohup(1) ignores it so that a program survives its terminal. A shell
 * makes background programs ignore SIGINT, too, but `kill -INT` must still park the platform. */
bool process_ignores(int number);

/* Makes writing to a closed pipe an error instead of the end of the process; for programs that
 * serve others, above all the daemon. Main thread. */
void process_survive_readers(void);

#endif
