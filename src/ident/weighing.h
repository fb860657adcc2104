/* A known weight on the platform, weighed by the legs: the mean vertical force of the same tests
 * without and with it. Inertia and viscous friction are in neither mean. Zeros of the pressures are
 * the same in both, but for their drift, which rests before the supply comes on show (rest.h). Dry
 * friction is the same while a leg moves one way; as a loaded leg extends for another share of the
 * time, the change of that share times the friction that method C found is taken off. Beside the
 * weight the gains of the pressures are in the difference:
 *
 *   m = -sum over legs of n_z (A1 dP1 - A2 dP2) / g,      n the leg's direction, z down
 *
 * where d is the difference of the means over a test. With the weight M the reading is off by
 * m / M - 1 = sum of (h1 g1 + h2 g2), h1 = -n_z A1 dP1 / (g M), h2 = n_z A2 dP2 / (g M), for gains
 * 1 + g1 and 1 + g2. Each test is a weighing of its own; their scatter gives the deviation, by
 * Student's distribution. Zeros of lengths and errors of joints, which turn the directions, add to
 * it, and so does the drift of the zeros, of the deviation model.tolerance.pressure_drift_pa, as
 * far as the rests leave it open. Ordinary threads; no heap. */
#ifndef HEXID_WEIGHING_H
#define HEXID_WEIGHING_H

#include "force.h"
#include "kinematics.h"
#include "method_c.h"
#include "rest.h"
#include "status.h"

enum { WEIGHING_SPAN = 32 }; /* most samples over which a leg's way is told */
enum { WEIGHING_TESTS = 16, WEIGHING_LEAST = 4 }; /* most tests kept; least that give a deviation */

/* Sums over the evaluated part of a test. */
struct weighing_test {
    int test;
    enum dof dof;
    int64_t samples;
    double lift_n[2][LEGS]; /* sums of -n_z A P, of the rodless and of the rod side */
    double length_m[LEGS];
    double way[LEGS];       /* sums of the signs of the legs' rates */
};

struct weighing {
    bool on; /* false: cycles are ignored */
    struct kinematics kinematics;
    struct cylinder_areas area;
    double pose[DOFS]; /* last pose, from which the next forward kinematics starts */
    double past_m[WEIGHING_SPAN][LEGS]; /* last lengths in this test, a ring */
    int span;                           /* number of samples in the ring */
    int64_t past;                       /* number of lengths put into it */
    int tests;
    struct weighing_test test[WEIGHING_TESTS];
};

/* The sums of a log, and its rest before the supply came on. */
struct weighing_log {
    const struct weighing *sums;
    const struct rest_found *rest;
};

struct weighing_found {
    double stated_kg;       /* 0: nothing was weighed */
    double reading_kg, std_kg; /* mean reading, and its deviation without that of the pressures'
                                * gains */
    double friction_kg;     /* part of dry friction, which was taken off */
    double drift_kg, drift_std_kg; /* part of the zeros' drift, which was taken off; its deviation,
                                    * which is in std_kg */
    int tests;
    double share[2][LEGS];  /* h1 and h2 */
};

/* The machine must have passed kinematics_init(). */
void weighing_init(struct weighing *w, const struct params *params);

/* Takes a cycle of a log. A zeroed struct ignores all. A test that is repeated replaces the earlier
 * one. */
void weighing_take(struct weighing *w, const struct cycle *c);

/* A weight as it is stated: its mass, and the standard deviation of that. */
struct weight {
    double kg, std_kg;
};

/* Finds the reading of a weight. friction: that of the log without it. Returns -2 if fewer than
 * WEIGHING_LEAST tests are in both logs, the logs do not differ by such a weight, or a leg's dry
 * friction is not determined. */
int weighing_find(const struct weighing_log *without, const struct weighing_log *with, const struct params *params, struct weight weight,
                  const struct method_c *friction, struct weighing_found *found, struct error *error);

/* Puts the reading into the section `found`. */
void weighing_note(const struct weighing_found *found, struct params *params);

#endif
