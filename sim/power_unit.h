/* Power unit of the simulated machine: pump, accumulator, dump valve, the relay that a life sign
 * keeps closed, and the pressure switch. Pure, RT.
 *
 * SAFETY: the relay closes only while the level of the life sign changes; a daemon that is dead,
 * hangs, or stops the life sign on purpose loses the supply. Then the dump valve empties the
 * accumulator, p = share Ps, dshare/dt = -share / 20 ms; with the relay closed the pump fills it at
 * a constant rate in 0.2 s. The switch closes at 80 % of Ps and opens at 60 %. */
#ifndef HEXID_POWER_UNIT_H
#define HEXID_POWER_UNIT_H

#include <stdbool.h>

struct power_unit {
    double hold_s;   /* time without a change of the life sign after which the relay opens */
    double still_s;  /* time since the life sign last changed */
    double share;    /* present supply pressure as a share of the full one, 0..1 */
    bool level;
    bool pressure;   /* the pressure switch is closed */
};

/* Starts with an empty accumulator and an open relay. */
void power_unit_init(struct power_unit *u, double hold_s);

void power_unit_step(struct power_unit *u, bool level, double dt_s);

#endif
