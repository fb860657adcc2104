/* Section `interlocks` of the configuration (params.h). */
#ifndef HEXID_PARAMS_INTERLOCKS_H
#define HEXID_PARAMS_INTERLOCKS_H

#include <stdbool.h>

struct interlock_params {         /* SAFETY: true for each input or output that is wired; inputs
                                   * that are not wired are not watched */
    bool emergency_stop, enable, door, pressure;
    bool supply;                  /* the output that keeps the supply on */
    double pressure_s;            /* longest time until the input `pressure` closes after the supply
                                   * is switched on. If `supply` is wired and `pressure` is not,
                                   * pressure counts as present after this time; if neither is
                                   * wired, at once */
    bool antivalent;              /* each input has two contacts, one inverse
                                   * (src/core/interlock.h) */
    double discrepancy_s;    /* longest time for which the two contacts may contradict each other */
};

#endif
