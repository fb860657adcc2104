/* The survey's motion, a small periodic multisine on all axes at once, with far more tones than
 * axes; and its measured response, tone by tone. Ordinary threads; heap.
 *
 * Tones are harmonics of 0.25 Hz, evenly spaced in log frequency from 1 Hz to 32 Hz (at most a
 * sixteenth of the loop's rate), given to the axes in turn. Each tone moves its fastest leg at the
 * same speed. All tones together give the fastest leg an rms rate of a twenty-fifth of
 * multisine_rate_limit_mps(). Phases after Schroeder 1970 avoid peaks. The first pass is for
 * settling. */
#ifndef HEXID_MULTISINE_H
#define HEXID_MULTISINE_H

#include <complex.h>

#include "recording.h"
#include "trajectory.h"

enum { MULTISINE_TONES = 36, MULTISINE_PASSES = 4 };

struct multisine_tone {
    enum dof dof;
    double hz, amplitude, phase; /* the tone is amplitude sin(2 pi hz t + phase), m or rad */
};

struct multisine {
    double step_s, period_s;
    int samples;                 /* samples in a period */
    int tones;
    struct multisine_tone tone[MULTISINE_TONES];
    double peak_mps;             /* peak rate of the fastest leg */
};

/* Computes the motion. Returns -2 for a mechanism that has no survey, impossible geometry, or a
 * loop that is too slow for six tones an axis. */
int multisine_init(struct multisine *m, const struct params *params, struct error *error);

/* Highest rate that every leg can reach: the least of limits.leg_rate_mps and of the valves' rates
 * at control.output_limit without load, in the slower direction. */
double multisine_rate_limit_mps(const struct params *params);

/* Makes the trajectory of one pass, a knot for each cycle, to be run in MULTISINE_PASSES passes.
 * Release it by trajectory_free(). Returns -3 without memory. */
int multisine_trajectory(const struct multisine *m, struct trajectory *trajectory, struct error *error);

/* Mean of the passes after the first. */
struct multisine_mean {
    const struct multisine *multisine;
    struct recording_sample *sample; /* [samples]: mean samples; test_time_s counts from the start
                                      * of a pass */
    double complex *wave;                     /* [tones][samples]: weights 2 / samples exp(-i w t);
                                               * the sum of a series times these weights is a tone's
                                               * amplitude */
    int passes;                               /* mean number of samples that were averaged at an
                                               * instant of the pass, rounded down */
    /* rms deviation of single samples from the mean at the same instant of the pass */
    double noise_m[LEGS], noise_pa[2][LEGS];
};

/* Averages the passes after the first of a recorded test. The first pass begins at the test time
 * begin_s. Returns -2 if some instant has no good sample in any pass, -3 without memory. Free the
 * mean also after an error. */
int multisine_average(struct multisine_mean *mean, const struct multisine *m, const struct recording_test *test, double begin_s,
                      struct error *error);
void multisine_free(struct multisine_mean *mean);

/* Complex amplitude of a tone in a series with one value for each sample of the pass. */
double complex multisine_amplitude(const struct multisine_mean *mean, int tone, const double *value);

#endif
