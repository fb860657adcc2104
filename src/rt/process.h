/* The start of the process, one for all subcommands: main() calls it before anything else, so that
 * a program behaves the same whoever starts it and whatever that one left behind.
 *
 *   descriptors   0, 1 and 2 that are closed are opened on /dev/null, against their direction: what
 *                 is read from or written to them fails, and no file, socket or bus that is opened
 *                 later gets their number, and with it the text for a terminal.
 *   signals       The mask is emptied; SIGPIPE and SIGCHLD do what they do by default, so that a
 *                 pipe's end ends a command and gnuplot's status can be fetched; SIGXFSZ is
 *                 ignored, so that a file limit is an error of writing that names the file.
 *   umask         Nothing is created that everybody may write; the rest is the caller's choice.
 *   stack         The soft limit is raised to PROCESS_STACK where the hard limit allows it; the
 *                 kernel leaves more address space below the stack than that. Threads that
 *                 libraries start get THREAD_STACK_REALTIME (thread.h).
 *   open files    The soft limit is raised to PROCESS_FILES.
 *   locale        "C" always: setlocale() is never called, LANG and LC_* change nothing. TZ counts
 *                 for names of logs alone.
 *   environment   Variables by which GLib, which liblcm brings, prints to standard output or aborts
 *                 on a warning are removed. MALLOC_* and LD_* act before main() and are the
 *                 caller's; LCM_DEFAULT_URL is not read, for an URL is always given. */
#ifndef HEXID_PROCESS_H
#define HEXID_PROCESS_H

#include "status.h"

enum {
    PROCESS_STACK = 8 << 20, /* bytes; `hexid gap`, the deepest, uses a part of it (stack.sh) */
    PROCESS_FILES = 128,     /* descriptors; a run has fewer than 32, and 66 for operators */
};

/* Main thread, first of all. STATUS_IO with the limit, its value and the remedy where one is too
 * low to work with. */
int process_start(struct error *error);

/* Makes a reader that has gone an error of writing, which does not end the process. It is for
 * programs that serve others, the daemon above all. Main thread. */
void process_survive_readers(void);

#endif
