/* A known weight on the platform, weighed by the legs: the difference of the mean vertical forces
 * in the same tests without and with the weight. Inertia and viscous friction are in neither mean.
 * The zeros of the pressures are the same in both means, except for their drift, which the readings
 * at rest show (rest.h). The dry friction of a leg is the same as long as it moves in one
 * direction. But a loaded leg extends for a different share of the time: the friction that method C
 * found, times the change of this share, is subtracted. Besides the weight, the difference contains
 * the gains of the pressures:
 *
 *   m = -sum over legs of n_z (A1 dP1 - A2 dP2) / g,      n the leg's direction, z down
 *
 * where dP is the mean over a test with the weight less that without it. For gains 1 + g1 and 1 +
 * g2 the reading m of a weight M is off by
 *
 *   m / M - 1 = sum of (h1 g1 + h2 g2),   h1 = -n_z A1 dP1 / (g M),   h2 = n_z A2 dP2 / (g M)
 *
 * Each test is a weighing of its own; their scatter gives the deviation, by Student's distribution.
 * Two things add to the deviation: zeros of lengths and errors of joints, because they rotate the
 * legs' directions; and the drift of the pressures' zeros (standard deviation
 * model.tolerance.pressure_drift_pa), as far as the readings at rest do not show it. Ordinary
 * threads; no heap. */
#ifndef HEXID_WEIGHING_H
#define HEXID_WEIGHING_H

#include "force.h"
#include "kinematics.h"
#include "method_c.h"
#include "rest.h"
#include "status.h"

enum { WEIGHING_SPAN = 32 }; /* most samples over which a leg's sense of motion is found */
/* Largest number of tests that are kept; least number that gives a deviation. */
enum { WEIGHING_TESTS = 16, WEIGHING_LEAST = 4 };

/* Sums over the evaluated part of a test. */
struct weighing_test {
    int test;
    enum dof dof;
    int64_t samples;
    double lift_n[2][LEGS]; /* sums of -n_z A P, of the rodless and of the rod side */
    double length_m[LEGS];
    double way[LEGS];       /* sums over the samples of the leg's sense of motion: 1 extending, -1
                             * retracting */
};

struct weighing {
    bool on; /* false: cycles are ignored */
    struct kinematics kinematics;
    struct cylinder_areas area;
    double pose[DOFS]; /* last pose, from which the next forward kinematics starts */
    double past_m[WEIGHING_SPAN][LEGS]; /* lengths of the last samples in this test, a ring */
    int span;                           /* number of samples in the ring */
    int64_t past;                       /* number of samples put into the ring */
    int tests;
    struct weighing_test test[WEIGHING_TESTS];
};

/* The sums of a log, and its readings at rest before the supply came on. */
struct weighing_log {
    const struct weighing *sums;
    const struct rest_found *rest;
};

struct weighing_found {
    double stated_kg;       /* 0: nothing was weighed */
    double reading_kg, std_kg; /* mean reading, and its standard deviation without the uncertainty
                                * of the pressures' gains */
    double friction_kg;     /* part of the reading by dry friction, already subtracted */
    double drift_kg, drift_std_kg; /* part of the reading by the zeros' drift, already subtracted;
                                    * and its standard deviation, which is included in std_kg */
    int tests;
    double share[2][LEGS];  /* h1 and h2 */
};

/* Prepares the sums. The machine must have passed kinematics_init(). */
void weighing_init(struct weighing *w, const struct params *params);

/* Takes a cycle of a log. A zeroed struct ignores all cycles. A test that is repeated replaces the
 * earlier one. */
void weighing_take(struct weighing *w, const struct cycle *c);

/* A weight as stated: its mass and the standard deviation of this mass. */
struct weight {
    double kg, std_kg;
};

/* Finds the reading of a weight. friction: result of method C for the log without the weight.
 * Returns -2 if fewer than WEIGHING_LEAST tests are in both logs, their pressures at rest differ by
 * more than drift allows, a leg's dry friction is not determined, or the reading is too uncertain
 * or too far from the stated weight. */
int weighing_find(const struct weighing_log *without, const struct weighing_log *with, const struct params *params, struct weight weight,
                  const struct method_c *friction, struct weighing_found *found, struct error *error);

/* Puts the reading into the section `found`. */
void weighing_note(const struct weighing_found *found, struct params *params);

#endif
