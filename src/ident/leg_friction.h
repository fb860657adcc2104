/* Measured friction of each leg, for plots: the leg's force less the force that inertia, weight and
 * springs need. Matrix and springs are those that method C found; an entry that is not determined
 * has its configured value, a spring that is not determined is 0. Viscous friction shows as a slope
 * over the leg's rate, dry friction as a step at zero. A steady test yields a mean cycle of the
 * harmonics that method C evaluates, so the step overshoots (Gibbs); any other motion yields the
 * middle of each segment. Ordinary threads; heap. */
#ifndef HEXID_LEG_FRICTION_H
#define HEXID_LEG_FRICTION_H

#include "inverse_dynamics.h"
#include "method_c.h"
#include "residual.h"
#include "types.h"

struct leg_friction_test {
    int of;                      /* index of the test in the recording */
    bool cycle;                  /* the points form a closed curve */
    int points;
    double rate_mps[LEGS][PHASES], force_n[LEGS][PHASES];
};

struct leg_friction {
    int tests;
    struct leg_friction_test *test;
};

/* Finds each leg's friction in a recording that method C has evaluated. Returns -2 if no pose has
 * the recorded lengths, -3 without memory. Free the result also after an error. */
int leg_friction_find(struct leg_friction *f, const struct recording *recording, const struct method_c *found, struct error *error);
void leg_friction_free(struct leg_friction *f);

#endif
