/* The friction of each leg as it was measured, for pictures: its force less what inertia and weight
 * need of it, with the matrix that method C found (where an entry is not determined, the configured
 * one). Viscous friction is a slope over the leg's rate, dry friction a step at zero. Of a steady
 * test it is a mean cycle in the harmonics that method C evaluates, so the step has their
 * overshoot; of any other motion the middle of each piece. Ordinary threads; heap. */
#ifndef HEXID_LEG_FRICTION_H
#define HEXID_LEG_FRICTION_H

#include "inverse_dynamics.h"
#include "method_c.h"
#include "residual.h"

struct leg_friction_test {
    int of;                      /* its place in the recording */
    bool cycle;                  /* closed: its end is its start */
    int points;
    double rate_mps[LEGS][PHASES], force_n[LEGS][PHASES];
};

struct leg_friction {
    int tests;
    struct leg_friction_test *test;
};

/* Of a recording from which method C was found. To be freed, also when this failed: -2 no pose has
 * these lengths, -3 memory. */
int leg_friction_find(struct leg_friction *f, const struct recording *recording, const struct method_c *found, struct error *error);
void leg_friction_free(struct leg_friction *f);

#endif
