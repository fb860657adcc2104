/* Section `limits` of the configuration (params.h). */
#ifndef HEXID_PARAMS_LIMITS_H
#define HEXID_PARAMS_LIMITS_H

#include "types.h"

struct limit_params {     /* SAFETY: beyond any of these limits the supervisor centres the valves;
                           * for a pressure out of range it parks the platform */
    double length_min_m[LEGS], length_max_m[LEGS];
    double leg_rate_mps;
    double following_m;           /* largest |leg reference - leg length| while the supply is on */
    double standstill_m;          /* range over which the reference of a driven leg may move while
                                   * the reading of the leg's length does not change at all */
    double force_n;               /* largest |A1 P1 - A2 P2| of a leg */
    double sensor_age_s;
    double pressure_min_pa, pressure_max_pa; /* range of plausible pressure readings */
    int bad_cycles;        /* level of the leaky bucket (bad cycles less good ones) at which a fault
                            * is latched; some faults, and STATE_INIT, have another level
                            * (patience() in src/core/platform.c) */
    double blind_time_s;          /* longest time for which the machine may move without a working
                                   * controller; hexid does not start if blind_time() is longer */
    double oscillation_mps2;      /* largest acceleration of the platform beyond 1.8 times the
                                   * requested one (src/core/oscillation.h) */
};

#endif
