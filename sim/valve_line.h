/* The way of the valve commands from the controller to the spools' servos: a delay, then what
 * effects make of a command (effect.h's command hook). RT after valve_line_init. */
#ifndef HEXID_VALVE_LINE_H
#define HEXID_VALVE_LINE_H

#include "machine.h"

struct valve_line {
    const struct machine *machine;
    double memory[EFFECTS_MAX][LEGS]; /* of the command hooks, in the order of machine->command */
    int kept, newest;
    double (*sent)[LEGS];             /* one command a cycle; each is held for a cycle */
};

/* machine must outlive the line. Returns 0, or -1 without memory. */
int valve_line_init(struct valve_line *l, const struct machine *machine);
void valve_line_free(struct valve_line *l);

/* Centred for ever; or held at these commands. */
void valve_line_rest(struct valve_line *l);
void valve_line_hold(struct valve_line *l, const double valve[LEGS]);

/* The command of a new cycle. */
void valve_line_send(struct valve_line *l, const double valve[LEGS]);

/* What arrives over a substep of that cycle; where a command changes within the substep, the mean,
 * which moves the spool alike. */
void valve_line_receive(struct valve_line *l, int substep, double valve[LEGS]);

#endif
