/* What a person sees while hexid runs: on a terminal a live line below the finished steps,
 * elsewhere one line a step. The recorder's thread, but for open, close, end and say. */
#ifndef HEXID_PROGRESS_H
#define HEXID_PROGRESS_H

#include <stdio.h>

#include "ident.h"
#include "motion_result.h"
#include "outlet.h"
#include "params.h"

struct progress {
    const struct params *params;
    struct outlet steps;    /* standard output */
    struct outlet words;    /* standard error */
    FILE *out;              /* that of steps */
    bool terminal;
    int64_t redraw_cycles;  /* cycles between two drawings of the live line */
    int64_t state_cycles;   /* in the state at hand */
};

/* to: standard output, or standard error where standard output carries the results. -1: no pipe or
 * thread. Nothing here holds its caller up, whatever the terminal does (outlet.h). */
int progress_open(struct progress *p, const struct params *params, int to, bool virtual_time);
/* Waits for the terminal as outlet_close() does. */
bool progress_close(struct progress *p);
void progress_state(struct progress *p, const struct cycle *c);
/* What stands in the way of `engage`. */
void progress_interlock(struct progress *p, const char *why);
/* cause and remedy: failure_explain(). */
void progress_fault(struct progress *p, const struct cycle *c, const char *cause, const char *remedy);
void progress_result(struct progress *p, const struct test_result *t);
void progress_motion(struct progress *p, const struct motion_result *m);
/* A line on standard error, clear of the live line; what is in it may come from anywhere and is
 * made printable. Main or recorder thread; waits for neither. */
__attribute__((format(printf, 2, 3))) void progress_say(struct progress *p, const char *format, ...);
/* Erases the live line: what follows is no progress. */
void progress_end(struct progress *p);
void progress_tick(struct progress *p, const struct cycle *c);

#endif
