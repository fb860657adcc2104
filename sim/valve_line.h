/* The way of the valve commands from the controller to the spools' servos: a delay, then what
 * effects make of a command (effect.h's command hook). RT. */
#ifndef HEXID_VALVE_LINE_H
#define HEXID_VALVE_LINE_H

#include "machine.h"

/* Those of 0.1 s, the longest delay, at 10 kHz, the shortest cycle; beyond that a delay is cut. */
enum { VALVE_LINE_COMMANDS = 1024 };

struct valve_line {
    const struct machine *machine;
    double memory[EFFECTS_MAX][LEGS]; /* of the command hooks, in the order of machine->command */
    int kept, newest;
    double sent[VALVE_LINE_COMMANDS][LEGS]; /* one command a cycle; each is held for a cycle */
};

/* machine must outlive the line. */
void valve_line_init(struct valve_line *l, const struct machine *machine);

/* Centred for ever; or held at these commands. */
void valve_line_rest(struct valve_line *l);
void valve_line_hold(struct valve_line *l, const double valve[LEGS]);

/* The command of a new cycle. */
void valve_line_send(struct valve_line *l, const double valve[LEGS]);

/* What arrives over a substep of that cycle; where a command changes within the substep, the mean,
 * which moves the spool alike. */
void valve_line_receive(struct valve_line *l, int substep, double valve[LEGS]);

#endif
