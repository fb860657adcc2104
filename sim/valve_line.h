/* The path of the valve commands from the controller to the spools' servos: a delay, then the
 * effects' command hooks (effect.h). RT. */
#ifndef HEXID_VALVE_LINE_H
#define HEXID_VALVE_LINE_H

#include "machine.h"

/* Number of stored commands: 0.1 s (the longest delay) times 10 kHz (the fastest loop), and a
 * margin; a longer delay is cut to the time that the stored commands cover. */
enum { VALVE_LINE_COMMANDS = 1024 };

struct valve_line {
    const struct machine *machine;
    double memory[EFFECTS_MAX][LEGS]; /* memory of the effects' command hooks, in the order of
                                       * machine->command */
    int kept, newest;
    double sent[VALVE_LINE_COMMANDS][LEGS]; /* ring buffer of the last `kept` commands, one a cycle;
                                             * `newest` is the index of the latest */
};

/* Prepares a line; machine must outlive it. */
void valve_line_init(struct valve_line *l, const struct machine *machine);

/* Starts as if the commands had always been zero; valve_line_hold(): as if they had always been
 * `valve`. */
void valve_line_rest(struct valve_line *l);
void valve_line_hold(struct valve_line *l, const double valve[LEGS]);

/* Takes the command of a new cycle. */
void valve_line_send(struct valve_line *l, const double valve[LEGS]);

/* Gives the commands that arrive over a substep of the current cycle. If a command changes within
 * the substep, its mean over the substep is given, because that moves the spool as far. */
void valve_line_receive(struct valve_line *l, int substep, double valve[LEGS]);

#endif
