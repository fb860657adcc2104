/* The power unit of the simulated machine: pump, accumulator and dump valve, the relay that a
 * charge pump keeps closed, and the pressure switch. Pure, RT.
 *
 * SAFETY: the relay closes only while the level it is given changes; a daemon that is dead, hangs,
 * or stops it on purpose loses the supply. Then the dump valve empties the accumulator, p = share
 * Ps, dshare/dt = -share / 20 ms; with the relay closed the pump fills it in 0.2 s, evenly. The
 * switch closes at 80 % of Ps and opens at 60 %. */
#ifndef HEXID_POWER_UNIT_H
#define HEXID_POWER_UNIT_H

#include <stdbool.h>

struct power_unit {
    double hold_s;   /* without a change for longer the relay opens */
    double still_s;  /* since the last change */
    double share;    /* of the supply pressure, 0..1 */
    bool level;
    bool pressure;   /* the switch */
};

/* Emptied, the relay open. */
void power_unit_init(struct power_unit *u, double hold_s);

void power_unit_step(struct power_unit *u, bool level, double dt_s);

#endif
