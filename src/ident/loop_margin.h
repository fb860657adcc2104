/* Gain and phase margins of the loop of one leg mode, broken at the valve command: kp, ki, kd and
 * kpf all act through it, so the margins say by how much the valve's gain and its delay may differ
 * from the configured ones. They mean something only for a stable loop (loop_poles.h says which
 * is). Ordinary threads, no heap. */
#ifndef HEXID_LOOP_MARGIN_H
#define HEXID_LOOP_MARGIN_H

#include "loop_poles.h"

struct control_params;

struct loop_margin {
    double gain_db, gain_hz;     /* the gain may grow by so much; inf: any gain */
    double drop_db;              /* the gain may fall by so much; inf: to nothing */
    double phase_deg, phase_hz;  /* least distance of the phase from -180 degrees where the gain is
                                  * 1; inf: it never is */
    double delay_s, delay_hz;    /* additional delay that makes the loop oscillate, and the
                                  * frequency at which it does; inf: the gain never is 1 */
    double bandwidth_hz;         /* position's loop, with that of the force closed: highest
                                  * frequency at which its gain is 1; 0: it never is */
};

/* Gain of the controller's position and pressure paths at a frequency, as sampled: command per
 * metre of error, and per newton of force (pid.h). */
double complex loop_position_gain(const struct control_params *control, double radps, double dt_s);
double complex loop_pressure_gain(const struct control_params *control, double radps, double dt_s);

/* Amplitude of a mode's length relative to its reference, at any frequency of the plant's (the
 * nearest one is taken). kff acts on the reference's change in a cycle. */
double complex loop_follow(const struct loop_plant *plant, const struct control_params *control, double radps, double dt_s);

struct loop_margin loop_margin(const struct loop_plant *plant, const struct control_params *control, double dt_s);

#endif
