/* Shows a running hexid on a terminal or in a pipe. On a terminal the newest cycle is shown below
 * the events and updated a few times a second; elsewhere each event is a line, and once a second
 * the state is a line. One thread. */
#ifndef HEXID_TERMINAL_H
#define HEXID_TERMINAL_H

#include "bus.h"
#include "types.h"

struct params;

struct terminal {
    const struct params *params;
    bool redraws;       /* standard output is a terminal */
    int drawn;          /* number of lines of the view that are on the screen */
    int64_t drawn_ms;   /* time of the last drawing; 0: due now */
    double force_n;  /* full scale of the force bars, a round number that never decreases; 0: no
                      * cycle was drawn yet */
};

void terminal_take(struct terminal *t, const struct bus_message *message, int64_t now_ms);

/* Draws the view of a cycle; returns its number of lines. */
int terminal_view(struct terminal *t, const struct cycle *cycle);

/* Prints a message of the monitor itself on standard error in place of the view. The next cycle
 * draws the view again below the message. */
void terminal_say(struct terminal *t, const char *line);

#endif
