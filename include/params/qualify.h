/* Section `qualify` of the configuration (params.h): the operator's limits for what `hexid qualify`
 * measures. 0: no limit, and the quantity is not evaluated. Angles count as lengths at the upper
 * joints. */
#ifndef HEXID_PARAMS_QUALIFY_H
#define HEXID_PARAMS_QUALIFY_H

struct qualify_params {
    double up_to_hz;                       /* highest tone that the limits in % and degrees cover */
    double amplitude_pct, phase_deg;       /* describing function of each axis: deviation from 1 */
    double cross_talk_pct, harmonics_pct, noise_pct;
    double rest_mps2;                      /* rms acceleration at rest, 0.2 to 20 Hz */
    double turn_around_mps2;
    double threshold_m, hysteresis_m, dead_s;
    double balance_pct;                    /* largest difference of a leg from the legs' mean */
    double excursion_m, rate_mps, accel_mps2; /* reached at least, on every axis */
    double repeat_mps2;                    /* difference from the baseline, as an acceleration */
};

#endif
