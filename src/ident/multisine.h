/* The survey's motion: a small multisine on all axes at once, periodic, with far more lines than
 * axes, and what was measured of it, line by line. Ordinary threads; heap.
 *
 * Lines are harmonics of 0.25 Hz, evenly spaced in log frequency from 1 Hz to 32 Hz (to a
 * sixteenth of the loop's rate, where that is less), given to the axes in turn. All move the legs
 * at the same speed; together the fastest leg has an rms rate of a twenty-fifth of what
 * limits.leg_rate_mps and the valve's full opening allow. Phases as Schroeder 1970, against high
 * peaks. The first pass is for settling. */
#ifndef HEXID_MULTISINE_H
#define HEXID_MULTISINE_H

#include <complex.h>

#include "recording.h"
#include "trajectory.h"

enum { MULTISINE_LINES = 36, MULTISINE_PASSES = 4 };

struct multisine_line {
    enum dof dof;
    double hz, amplitude, phase; /* amplitude sin(2 pi hz t + phase): m, rad */
};

struct multisine {
    double step_s, period_s;
    int samples;                 /* a period */
    int lines;
    struct multisine_line line[MULTISINE_LINES];
    double peak_mps;             /* of the fastest leg */
};

/* -2: no platform (mechanism: axis), impossible geometry, or a loop too slow for six lines an
 * axis. */
int multisine_init(struct multisine *m, const struct params *params, struct error *error);

/* Highest rate that every leg can have: the least of limits.leg_rate_mps and what the valves let
 * through at control.output_limit without load, in the slower direction. */
double multisine_rate_limit_mps(const struct params *params);

/* A knot for each cycle of one pass, to be run in MULTISINE_PASSES; to be released by
 * trajectory_free(). -3 without memory. */
int multisine_trajectory(const struct multisine *m, struct trajectory *trajectory, struct error *error);

/* The mean of the passes after the first. */
struct multisine_mean {
    const struct multisine *multisine;
    struct recording_sample *sample;          /* [samples]; test_time_s from the start of a pass */
    double complex *wave;                     /* [lines][samples]: 2 / samples exp(-i w t) */
    int passes;                               /* averaged */
    double noise_m[LEGS], noise_pa[2][LEGS];  /* rms of single samples about their mean at the same
                                               * place of the pass */
};

/* From the test as recorded; begin_s: test time at which its passes begin. -2: a place of the pass
 * at which no pass has a good sample; -3: memory. To be freed also then. */
int multisine_average(struct multisine_mean *mean, const struct multisine *m, const struct recording_test *test, double begin_s,
                      struct error *error);
void multisine_free(struct multisine_mean *mean);

/* Complex amplitude, at a line, of a series with one value per sample of the pass. */
double complex multisine_amplitude(const struct multisine_mean *mean, int line, const double *value);

#endif
