/* Shows progress while hexid runs: on a terminal a live line below the finished steps, elsewhere a
 * line for each step. Only the recorder's thread may call these functions, except open, close, end,
 * say and compute. */
#ifndef HEXID_PROGRESS_H
#define HEXID_PROGRESS_H

#include <stdio.h>

#include "ident.h"
#include "motion_result.h"
#include "outlet.h"

struct progress {
    const struct params *params;
    struct outlet steps;    /* outlet to `to` of progress_open() */
    struct outlet words;    /* outlet to standard error */
    FILE *out;              /* steps.out */
    bool terminal;
    int64_t redraw_cycles;  /* number of cycles from one update of the live line to the next */
    int64_t state_cycles;   /* number of cycles in the current state */
    const char *computing;  /* `what` of the last progress_compute(); NULL: it was not called yet */
    int64_t computing_ns;   /* time when the first computation began */
};

/* Names of the phases of a test, by enum phase. */
extern const char *const progress_phases[];

/* Opens the outlets. to: standard output, or standard error if standard output carries the results.
 * virtual_time: the live line is updated every 2 s of the loop's time instead of every 0.1 s.
 * Returns -1 if a pipe or thread cannot be had. Of all these functions only progress_close() waits
 * for the terminal (outlet.h). */
int progress_open(struct progress *p, const struct params *params, int to, bool virtual_time);
/* Waits for the terminal as outlet_close() does. Returns false if a reader has stalled. */
bool progress_close(struct progress *p);
void progress_state(struct progress *p, const struct cycle *c);
/* Shows the reason why `engage` would be refused. */
void progress_interlock(struct progress *p, const char *why);
/* Shows a fault with the cause and remedy of failure_explain(). */
void progress_fault(struct progress *p, const struct cycle *c, const char *cause, const char *remedy);
void progress_result(struct progress *p, const struct test_result *t);
void progress_motion(struct progress *p, const struct motion_result *m);
/* Prints a line on standard error, without disturbing the live line; the text is made printable,
 * because it may come from anywhere. Main, recorder or signals' thread; never waits. */
__attribute__((format(printf, 2, 3))) void progress_say(struct progress *p, const char *format, ...);
/* Shows the progress of a computation after the run: on a terminal in the live line, with seconds
 * spent and expected, elsewhere as a line for each `what`, which must be a string literal. share:
 * share of the work done, 0..1. Main thread, when no other thread uses p any more. */
void progress_compute(struct progress *p, const char *what, double share);
/* Erases the live line. To be called before output that is not progress. */
void progress_end(struct progress *p);
void progress_tick(struct progress *p, const struct cycle *c);

#endif
