/* Shows a running hexid on a terminal or in a pipe. On a terminal the newest cycle stands below the
 * events, drawn a few times a second; elsewhere events are lines as they come, and the state is a
 * line a second. One thread. */
#ifndef HEXID_TERMINAL_H
#define HEXID_TERMINAL_H

#include "bus.h"
#include "params.h"

struct terminal {
    const struct params *params;
    bool redraws;       /* standard output is a terminal */
    int drawn;          /* lines of the view on the screen */
    int64_t drawn_ms;   /* when they were drawn; 0: due now */
    double force_n;     /* full scale of the force bars: a round number, which only grows; 0: none
                         * yet */
};

void terminal_take(struct terminal *t, const struct bus_message *message, int64_t now_ms);

/* The whole view of a cycle; returns its lines. */
int terminal_view(struct terminal *t, const struct cycle *cycle);

/* A line of the monitor's own, above the view. */
void terminal_say(struct terminal *t, const char *line);

#endif
