/* The closed loop's eigenfrequencies: each rigid mode of the oil columns (oil_columns.h) as one
 * cylinder that moves the mode's mass, with the chambers about their working point, the spool, a
 * delay of the command, viscous friction, and the configured controller (pid.h), sampled and held.
 * Where the legs are alike the six modes decouple exactly; where they differ a mode has the mean of
 * its legs, weighted by the squares of their motion in it (first order). A survey finds the legs in
 * data (loop_survey.h); loop_model.h takes them from a configuration. Ordinary threads, no heap. */
#ifndef HEXID_LOOP_POLES_H
#define HEXID_LOOP_POLES_H

#include "oil_columns.h"

/* One leg about its working point. */
struct loop_leg {
    struct oil_chamber chamber[2];       /* of these push, other, open and sag */
    double viscous;                      /* N s/m */
    double feedback_cut;                 /* what the controller takes off kpf (force.h), 0..1 */
    double spool_radps, spool_damping;   /* second order */
    double command_delay_s;              /* from the sample that the command was computed from, */
    double length_delay_s;               /* and of the length's reading; any part of cycles */
};

/* One mode: how far the legs move in it, and the mass for the square of their motion. */
struct loop_shape {
    const double *motion;                /* [LEGS] */
    double mass_kg;
};

/* A pole of the loop from one sample to the next, as a rate in continuous time. */
struct loop_pole {
    double decay_per_s, radps;           /* decay_per_s negative: it grows; radps 0 up to half the
                                          * sampling frequency */
};

/* The poles in the upper half plane. Longer delays count as LOOP_DELAY_MOST cycles. Returns how
 * many there are; 0: the loop is not finite. */
enum { LOOP_DELAY_MOST = 14, LOOP_POLES = 10 + 2 * (LOOP_DELAY_MOST + 1) };
int loop_poles_all(const struct loop_leg leg[LEGS], const struct loop_shape *shape, const struct params *params,
                   struct loop_pole pole[LOOP_POLES]);

/* Acceleration of the mode, rms, that the readings' own errors (sensors) make in a loop that is
 * stable; in one that is not, more than anything or NaN. The unit is that of 1 / motion. Errors
 * count as independent from sample to sample. */
double loop_noise(const struct loop_leg leg[LEGS], const struct loop_shape *shape, const struct params *params);

double loop_pole_hz(const struct loop_pole *pole);      /* |s| / 2 pi */
double loop_pole_damping(const struct loop_pole *pole); /* damping ratio; negative: unstable */

struct loop_mode {
    double hz, damping; /* of the lowest pair of poles that oscillates; NaN: there is none */
};

/* viscous: friction of each leg, N s/m. The spool is a critically damped lag of the delay found
 * less half a cycle. The mode must be determined. */
struct loop_mode loop_poles(const struct oil_leg leg[LEGS], const struct oil_mode *mode, const double viscous[LEGS],
                            const struct params *params);

#endif
