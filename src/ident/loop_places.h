/* The poses at which a closed loop is judged. Ordinary threads, no heap. */
#ifndef HEXID_LOOP_PLACES_H
#define HEXID_LOOP_PLACES_H

#include "loop_model.h"

/* Largest accepted rms acceleration that the sensors' noise alone causes, as a share of
 * limits.oscillation_mps2. The rms over the worst quarter of a second is 1.5 to 2 times the
 * computed rms. In simulations with a share of 0.63 the platform exceeded limits.oscillation_mps2
 * for 0.4 s at most, with 0.7 for 0.6 s. */
#define LOOP_NOISE_MOST 0.6

enum { LOOP_WAY = 8, LOOP_PLACES = 1 + LOOP_WAY + 2 * DOFS };

/* Models of the loop in all poses where the machine may be held: at neutral, on the way down to
 * parking, and near the ends of the strokes in either sense of each axis. */
struct loop_places {
    int count;
    int way;             /* number of places at the beginning of the list that are neutral or on the
                          * way down */
    struct loop_place place[LOOP_PLACES];
};

/* Delay of commands in addition to the delays of effects and valve: the stated one
 * (control.delay_s), or on a field bus at least one cycle. */
double loop_delay_s(const struct params *params, bool bus);

/* Finds the poses and linearises the machine there. bus: the machine is on a field bus. Returns
 * false if the supply cannot hold the platform up at neutral. */
bool loop_places_find(struct loop_places *all, const struct params *params, bool bus);

/* Returns the largest shaking by the sensors' noise, m/s^2 rms, at neutral and on the way down to
 * parking, where the oil may be stiffer and the loop less damped than at neutral. Unstable poses
 * are left out. */
double loop_places_noise_mps2(const struct loop_places *all, const struct params *params);

double loop_noise_most_mps2(const struct params *params); /* largest accepted shaking */

/* True if the worst pole is not known, or is unstable, so that its motion grows. */
bool loop_grows(const struct loop_worst *worst);

#endif
