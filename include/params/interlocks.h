/* Section `interlocks` of the configuration (params.h). */
#ifndef HEXID_PARAMS_INTERLOCKS_H
#define HEXID_PARAMS_INTERLOCKS_H

#include <stdbool.h>

struct interlock_params {         /* SAFETY: wired inputs and outputs of the machine; others are not
                                   * watched */
    bool emergency_stop, enable, door, pressure;
    bool supply;                  /* the output that keeps the supply on */
    double pressure_s;            /* longest time until the input `pressure` closes; if it is not
                                   * wired, the waiting time itself */
    bool antivalent;              /* each input has two contacts, one inverse (interlock.h) */
    double discrepancy_s;    /* longest time for which the two contacts may contradict each other */
};

#endif
