/* Shows progress while hexid runs: on a terminal a live line below the finished steps, elsewhere
 * a line for each step. For the recorder's thread, except open, close, end, say and compute. */
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
    int64_t redraw_cycles;  /* number of cycles between updates of the live line */
    int64_t state_cycles;   /* number of cycles in the current state */
    const char *computing;  /* the last `what` of progress_compute(); NULL: none yet */
    int64_t computing_ns;   /* time when the first computation began */
};

/* Names of the phases of a test, by enum phase. */
extern const char *const progress_phases[];

/* Opens the outlets. to: standard output, or standard error if standard output carries the results.
 * virtual_time: the live line is updated every 2 s of the loop's time instead of 0.1 s. Returns -1
 * without a pipe or thread. Only progress_close() ever waits for the terminal (outlet.h). */
int progress_open(struct progress *p, const struct params *params, int to, bool virtual_time);
/* Waits for the terminal as outlet_close() does. Returns false if a reader has stalled. */
bool progress_close(struct progress *p);
void progress_state(struct progress *p, const struct cycle *c);
/* Shows why `engage` would be refused. */
void progress_interlock(struct progress *p, const char *why);
/* Shows a fault with the cause and remedy of failure_explain(). */
void progress_fault(struct progress *p, const struct cycle *c, const char *cause, const char *remedy);
void progress_result(struct progress *p, const struct test_result *t);
void progress_motion(struct progress *p, const struct motion_result *m);
/* Prints a line on standard error, without disturbing the live line; the text may come from
 * anywhere and is made printable. Main or recorder thread; never waits. */
__attribute__((format(printf, 2, 3))) void progress_say(struct progress *p, const char *format, ...);
/* Shows what is computed when the run is over: on a terminal the live line with seconds spent and
 * expected, elsewhere a line for each `what`, which must be a literal. share: work done, 0..1. Main
 * thread, when no other thread uses p any more. */
void progress_compute(struct progress *p, const char *what, double share);
/* Erases the live line, before output that is not progress. */
void progress_end(struct progress *p);
void progress_tick(struct progress *p, const struct cycle *c);

#endif
