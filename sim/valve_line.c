#include "valve_line.h"

#include <math.h>
#include <string.h>

#include "params.h"

void valve_line_init(struct valve_line *l, const struct machine *machine) {
    double longest_s = 0.0;
    for (int k = 0; k < LEGS; k++) longest_s = fmax(longest_s, machine->timing.command_delay_s[k]);
    l->machine = machine;
    l->kept = (int)fmin(ceil(longest_s / machine->params->loop.period_s) + 2.0, VALVE_LINE_COMMANDS);
    l->newest = 0;
    valve_line_rest(l);
}

void valve_line_rest(struct valve_line *l) {
    memset(l->sent, 0, (size_t)l->kept * sizeof *l->sent);
    memset(l->memory, 0, sizeof l->memory);
}

void valve_line_hold(struct valve_line *l, const double valve[LEGS]) {
    double arrived[LEGS];
    valve_line_rest(l);
    for (int i = 0; i < l->kept; i++) valve_line_send(l, valve);
    valve_line_receive(l, 0, arrived); /* sets the memory of the command hooks */
}

void valve_line_send(struct valve_line *l, const double valve[LEGS]) {
    l->newest = (l->newest + 1) % l->kept;
    memcpy(l->sent[l->newest], valve, sizeof l->sent[0]);
}

/* Returns the mean, over the substep, of the command that arrives then. */
static double arriving(const struct valve_line *l, int leg, int substep) {
    const struct params *p = l->machine->params;
    double cycles = l->machine->timing.command_delay_s[leg] / p->loop.period_s, delay = fmin(cycles, l->kept - 2.0);
    if (!(delay > 0.0)) return l->sent[l->newest][leg];
    /* instant at which the command was sent that arrives at the start of the substep; in substeps,
     * counted from the sending of the newest command */
    double start = substep - delay * p->sim.substeps;
    double cycle = floor(start / p->sim.substeps), change = (cycle + 1.0) * p->sim.substeps - start;
    int at = (l->newest + (int)cycle + 2 * l->kept) % l->kept, next = (at + 1) % l->kept;
    double old = change < 1.0 ? change : 1.0;
    return old * l->sent[at][leg] + (1.0 - old) * l->sent[next][leg];
}

void valve_line_receive(struct valve_line *l, int substep, double valve[LEGS]) {
    const struct active *laws = &l->machine->command;
    for (int k = 0; k < LEGS; k++) {
        valve[k] = arriving(l, k, substep);
        for (int i = 0; i < laws->count; i++) valve[k] = laws->of[i].effect->command(laws->of[i].values, k, valve[k], &l->memory[i][k]);
    }
}
