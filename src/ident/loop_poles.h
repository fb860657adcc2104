/* Eigenfrequencies of the closed loop. Each rigid mode of the oil columns (oil_columns.h) is
 * modelled as one cylinder that moves the mode's mass. The model has the chambers about their
 * working point, the spool, a delay of the command, viscous friction, and the configured controller
 * (pid.h), sampled and held. If the legs are alike, the six modes decouple exactly; if not, a mode
 * has the mean of its legs, weighted by their squared motion in it (first order). A survey finds
 * the legs in data (loop_survey.h); loop_model.h takes them from a configuration. Ordinary threads,
 * no heap. */
#ifndef HEXID_LOOP_POLES_H
#define HEXID_LOOP_POLES_H

#include <complex.h>

#include "oil_columns.h"

/* One leg, linearised about its working point. */
struct loop_leg {
    struct oil_chamber chamber[2];       /* push, other, open and sag are used */
    double viscous;                      /* viscous friction, N s/m */
    double feedback_cut; /* share, 0..1, by which the controller reduces the gain kpf (force.h) */
    double spool_radps, spool_damping;   /* spool as a system of second order */
    double command_delay_s; /* delay from a sample to the effect of the command that is computed
                             * from it */
    double length_delay_s;               /* delay of the reading, not necessarily whole cycles */
};

/* One mode: motion of the legs in it, and modal mass divided by the sum of the legs' squared
 * motions. */
struct loop_mode_input {
    const double *motion;                /* [LEGS]: motion of each leg */
    double mass_kg;
    double gain; /* factor of kp, ki and kd in this mode (modal.h) */
};

/* A pole of the sampled loop, converted to continuous time: s = -decay_per_s + i radps. */
struct loop_pole {
    /* decay_per_s: negative if the pole's motion grows. radps: from 0 to half the sampling
     * frequency. */
    double decay_per_s, radps;
};

/* Computes the poles in the upper half plane. A delay longer than LOOP_DELAY_MOST cycles counts as
 * that long. Returns the number of poles, or 0 if the loop has values that are not finite. */
enum { LOOP_DELAY_MOST = 14, LOOP_POLES = 10 + 2 * (LOOP_DELAY_MOST + 1) };
int loop_poles_all(const struct loop_leg leg[LEGS], const struct loop_mode_input *shape, const struct params *params,
                   struct loop_pole pole[LOOP_POLES]);

/* Frequency response of a mode without its controller: length and force of its mean leg, as the
 * controller reads them, per full opening of the valves. */
enum { LOOP_ANSWERS = 280 };
struct loop_answer {
    double radps;
    double complex length_m, force_n;
};
struct loop_plant {
    double oil_radps;                          /* frequency with the ports shut, undamped */
    double feedback_cut;                       /* as in loop_leg, mean of the mode */
    double gain;                               /* as in loop_mode_input */
    struct loop_answer answer[LOOP_ANSWERS];   /* by ascending frequency, up to half the sampling
                                                * frequency */
};
void loop_plant_find(const struct loop_leg leg[LEGS], const struct loop_mode_input *shape, const struct params *params,
                     struct loop_plant *plant);

/* Rms acceleration of a mode that the sensors' errors, taken as white, cause in a stable loop; in
 * an unstable loop a huge number or NaN. Multiplied by shape->motion[k] it is the acceleration of
 * leg k, m/s^2. */
double loop_noise(const struct loop_leg leg[LEGS], const struct loop_mode_input *shape, const struct params *params);

double loop_pole_hz(const struct loop_pole *pole);      /* magnitude |s| / 2 pi, Hz */
double loop_pole_damping(const struct loop_pole *pole); /* damping ratio; negative: unstable */

struct loop_mode {
    double hz, damping; /* lowest oscillating pair of poles; NaN: there is none */
};

/* Finds the lowest oscillating poles of the closed loop of a surveyed mode, which must be
 * determined. gain: as in loop_mode_input. viscous: viscous friction of each leg, N s/m. The spool
 * is modelled as a critically damped lag; its time is the delay found for the legs, less the half
 * cycle of holding. */
struct loop_mode loop_poles(const struct oil_leg leg[LEGS], const struct oil_mode *mode, double gain, const double viscous[LEGS],
                            const struct params *params);

#endif
