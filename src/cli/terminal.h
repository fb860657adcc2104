/* Shows a running hexid on a terminal or in a pipe. On a terminal the newest cycle stands below
 * the events and is updated a few times a second; elsewhere each event is a line, and the state
 * a line a second. One thread. */
#ifndef HEXID_TERMINAL_H
#define HEXID_TERMINAL_H

#include "bus.h"
#include "types.h"

struct params;

struct terminal {
    const struct params *params;
    bool redraws;       /* standard output is a terminal */
    int drawn;          /* number of lines of the view on the screen */
    int64_t drawn_ms;   /* time of the last drawing; 0: due now */
    double force_n;  /* full scale of the force bars: a round number that only grows; 0: none yet */
};

void terminal_take(struct terminal *t, const struct bus_message *message, int64_t now_ms);

/* Draws the view of a cycle; returns its number of lines. */
int terminal_view(struct terminal *t, const struct cycle *cycle);

/* Prints a message of the monitor itself on standard error, in place of the view, which the next
 * cycle draws again below. */
void terminal_say(struct terminal *t, const char *line);

#endif
