/* Eigenfrequencies of the closed loop. Each rigid mode of the oil columns (oil_columns.h) is
 * modelled as one cylinder that moves the mode's mass, with the chambers about their working
 * point, the spool, a delay of the command, viscous friction, and the configured controller
 * (pid.h), sampled and held. If the legs are alike, the six modes decouple exactly; if not, a mode
 * has the mean of its legs, weighted by their squared motion in it (first order). A survey finds
 * the legs in data (loop_survey.h); loop_model.h takes them from a configuration. Ordinary
 * threads, no heap. */
#ifndef HEXID_LOOP_POLES_H
#define HEXID_LOOP_POLES_H

#include "oil_columns.h"

/* One leg about its working point. */
struct loop_leg {
    struct oil_chamber chamber[2];       /* uses push, other, open and sag */
    double viscous;                      /* N s/m */
    double feedback_cut; /* share by which the controller reduces kpf (force.h), 0..1 */
    double spool_radps, spool_damping;   /* second order */
    double command_delay_s; /* delay from the sample that the command was computed from */
    double length_delay_s;               /* the reading's delay; cycles need not be whole */
};

/* One mode: how far the legs move in it, and its mass per squared motion. */
struct loop_shape {
    const double *motion;                /* [LEGS] */
    double mass_kg;
};

/* A pole of the sampled loop, as a rate in continuous time. */
struct loop_pole {
    /* decay_per_s < 0: it grows; radps: 0 to half the sampling frequency */
    double decay_per_s, radps;
};

/* Computes the poles in the upper half plane. Delays are limited to LOOP_DELAY_MOST cycles. Returns
 * their number, or 0 if the loop is not finite. */
enum { LOOP_DELAY_MOST = 14, LOOP_POLES = 10 + 2 * (LOOP_DELAY_MOST + 1) };
int loop_poles_all(const struct loop_leg leg[LEGS], const struct loop_shape *shape, const struct params *params,
                   struct loop_pole pole[LOOP_POLES]);

/* Rms acceleration of the mode caused by the sensors' own errors in a stable loop; in an unstable
 * one, a huge number or NaN. The unit is that of 1 / motion. Errors are taken as white. */
double loop_noise(const struct loop_leg leg[LEGS], const struct loop_shape *shape, const struct params *params);

double loop_pole_hz(const struct loop_pole *pole);      /* |s| / 2 pi */
double loop_pole_damping(const struct loop_pole *pole); /* damping ratio; negative: unstable */

struct loop_mode {
    double hz, damping; /* the lowest oscillating pair of poles; NaN: none */
};

/* Poles of a surveyed mode, which must be determined. viscous: friction of each leg, N s/m. The
 * spool is modelled as a critically damped lag of the delay found, less half a cycle. */
struct loop_mode loop_poles(const struct oil_leg leg[LEGS], const struct oil_mode *mode, const double viscous[LEGS],
                            const struct params *params);

#endif
