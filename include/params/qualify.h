/* Section `qualify` of the configuration (params.h): the operator's limits for the quantities of
 * `hexid qualify` (src/ident/quality.h). 0: no limit, and the quantity is not judged. Angles count
 * as lengths at the upper joints. */
#ifndef HEXID_PARAMS_QUALIFY_H
#define HEXID_PARAMS_QUALIFY_H

struct qualify_params {
    double up_to_hz;                       /* highest tone for which amplitude, phase, cross-talk,
                                            * harmonics and noise are judged */
    double amplitude_pct, phase_deg;       /* deviation of an axis's amplitude and phase from those
                                            * of its reference */
    double cross_talk_pct, harmonics_pct, noise_pct;
    double rest_mps2;                      /* rms acceleration at rest, 0.2 to 20 Hz */
    double turn_around_mps2;
    double threshold_m, hysteresis_m, dead_s;
    double balance_pct;                    /* largest difference of a leg's response (amplitude and
                                            * phase) from the mean of all legs */
    double excursion_m, rate_mps, accel_mps2; /* least values that every axis must reach */
    double repeat_mps2;                    /* difference of a tone from the baseline measurement, as
                                            * an acceleration */
};

#endif
