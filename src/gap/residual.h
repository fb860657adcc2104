/* Equation residuals: what a model cannot account for in a measured motion, without its controller and without a closed loop.
 *
 *   force     A1 P1 - A2 P2 - (inverse dynamics of the measured motion: all 13 rigid bodies, weight, friction)      per leg, N
 *   pressure  P measured - P of the chambers when spool and oil follow the measured commands and the measured motion   per leg, Pa
 *
 * The motion is the mean cycle's harmonics, so velocity and acceleration cost no differences; what the model's sensors do to it and to the
 * pressures (scale, offset, lag, delay) is undone there, before any law is asked. Commands are held between the sampling instants exactly as
 * they were. Without pressures the force is what its sensor or drive says; without them, or without commands, the chambers are not
 * evaluated. One axis is a machine of one leg, whose inverse dynamics is m (a + g) and friction. Physics: sim's rigid bodies, hydraulics and
 * effects, written once. Both residuals are returned as coefficient rows (spectrum.h), in the units of the readings, where the whitener's
 * noise is: a sensor's scale does not make them smaller. At rest in the noise they are zero for the right model. Pure but for the heap. */
#ifndef HEXID_RESIDUAL_H
#define HEXID_RESIDUAL_H

#include "spectrum.h"

enum residual_kind { RESIDUAL_FORCE, RESIDUAL_P1, RESIDUAL_P2, RESIDUALS };
enum { CYCLE_STEPS = 1024 };
enum { RESIDUAL_HARMONICS = 8, RESIDUAL_SIZE = 1 + 2 * RESIDUAL_HARMONICS };

/* What has to be computed again. */
enum residual_part { PART_FORCE = 1, PART_PRESSURE = 2, PART_ALL = 3 };

typedef double residual_row[LEGS][RESIDUALS][RESIDUAL_SIZE]; /* of one test */

struct residual_test {
    struct spectrum spectrum;
    int legs;                    /* that the mechanism has; rows of the others are zero */
    bool pressures, chambers;    /* measured: pressures, else a force; pressures and the commands that made them */
    int harmonics;               /* at most RESIDUAL_HARMONICS */
    double first_s, step_s;      /* test time of the first simulated sample; sampling */
    int samples, fitted;         /* simulated; the last so many are compared */
    int substeps;                /* a sample */
    double *cycle;               /* [CYCLE_STEPS][SPECTRUM_SIZE]: basis over a cycle */
    double *node;                /* [2 substeps samples + 1][RESIDUAL_SIZE]: basis at the ends and middles of the substeps */
    double *valve;               /* [samples][leg] */
    double *projection;          /* [1 + 2 harmonics][fitted]: samples to coefficients */
};

struct residual_data {
    int tests;
    enum residual_part parts;    /* that can be evaluated; the rows of others are zero */
    struct residual_test *test;
};

/* Of the cycles given. 0, or -2 (fewer than two whole cycles) or -3 (memory). */
int residual_prepare(struct residual_data *d, const struct recording *recording, enum cycles which, struct error *error);
void residual_free(struct residual_data *d);

/* Rows of a test under a model; kinds outside `parts` are left as they are. False where the motion is no motion of this model,
 * or there can be no such machine. */
bool residual_evaluate(const struct residual_test *t, const struct params *model, enum residual_part parts, residual_row row);

/* No leg's own constants move another leg's residuals: they neither share lines to the power unit nor move the pose by play. */
bool residual_legs_apart(const struct params *model);

/* Inverse dynamics alone: the hydraulic force each leg needs for the measured motion (friction included). */
bool residual_required(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]);

#endif
