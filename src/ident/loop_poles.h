/* The closed loop's eigenfrequencies: each rigid mode of the oil columns (oil_columns.h) as one
 * cylinder that moves the mode's mass, with the chambers that the survey found about their mean
 * working point, the spool as a critically damped lag of the delay found less half a cycle, the
 * viscous friction found, and the configured controller (pid.h), sampled and held. Where the legs
 * are alike the six modes decouple exactly; where they differ a mode has the mean of its legs,
 * weighted by the squares of their motion in it (first order). Ordinary threads, no heap. */
#ifndef HEXID_LOOP_POLES_H
#define HEXID_LOOP_POLES_H

#include "oil_columns.h"

struct loop_mode {
    double hz, damping; /* of the lowest pair of poles that oscillates, |s| / 2 pi and the damping
                         * ratio (negative: unstable); NaN: there is none */
};

/* viscous: friction of each leg, N s/m. The mode must be determined. */
struct loop_mode loop_poles(const struct oil_leg leg[LEGS], const struct oil_mode *mode, const double viscous[LEGS],
                            const struct params *params);

#endif
