/* The path of the valve commands from the controller to the spools' servos: a delay, then the
 * effects' command hooks (effect.h). RT. */
#ifndef HEXID_VALVE_LINE_H
#define HEXID_VALVE_LINE_H

#include "machine.h"

/* Largest number of stored commands: 0.1 s, the longest delay, times 10 kHz, the fastest loop, and
 * a margin. A longer delay is cut to the time that the stored commands cover. */
enum { VALVE_LINE_COMMANDS = 1024 };

struct valve_line {
    const struct machine *machine;
    double memory[EFFECTS_MAX][LEGS]; /* memory of the command hooks, for each effect in the order
                                       * of machine->command */
    int kept, newest;
    double sent[VALVE_LINE_COMMANDS][LEGS]; /* ring buffer of the last `kept` commands, one for each
                                             * cycle; `newest` is the index of the latest one */
};

/* Prepares a line; machine must outlive it. */
void valve_line_init(struct valve_line *l, const struct machine *machine);

/* valve_line_rest() starts as if the commands had always been zero, valve_line_hold() as if they
 * had always been `valve`. */
void valve_line_rest(struct valve_line *l);
void valve_line_hold(struct valve_line *l, const double valve[LEGS]);

/* Takes the command of a new cycle. */
void valve_line_send(struct valve_line *l, const double valve[LEGS]);

/* Gives the commands that arrive during a substep of the current cycle. If a command changes within
 * the substep, gives its mean, which moves the spool as far. */
void valve_line_receive(struct valve_line *l, int substep, double valve[LEGS]);

#endif
