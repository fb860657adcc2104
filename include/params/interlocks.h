/* Section `interlocks` of the configuration (params.h). */
#ifndef HEXID_PARAMS_INTERLOCKS_H
#define HEXID_PARAMS_INTERLOCKS_H

#include <stdbool.h>

struct interlock_params {         /* SAFETY: true for each input or output that is wired; inputs
                                   * that are not wired are not watched */
    bool emergency_stop, enable, door, pressure;
    bool supply;                  /* the output that keeps the supply on */
    double pressure_s;            /* longest time until the input `pressure` closes; if that input
                                   * is not wired, the time that is waited */
    bool antivalent;              /* each input has two contacts, one inverse (interlock.h) */
    double discrepancy_s;    /* longest time for which the two contacts may contradict each other */
};

#endif
