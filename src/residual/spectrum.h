/* A test as harmonics of its frequency: means over some of its cycles, and the spread of single
 * cycles about the means. The spread shows the noise and its correlation between successive cycles,
 * as that of rounding errors in a motion that drifts slowly. Errors that repeat in every cycle
 * (rounding.h) do not show in the spread. Pure.
 *
 * A coefficient row is [constant, sin wt, cos wt, sin 2wt, ...], t the test time. */
#ifndef HEXID_SPECTRUM_H
#define HEXID_SPECTRUM_H

#include "recording.h"

enum channel { CHANNEL_LENGTH, CHANNEL_P1, CHANNEL_P2, CHANNEL_VALVE, CHANNEL_FORCE, CHANNELS };
enum { SPECTRUM_HARMONICS = 16, SPECTRUM_SIZE = 1 + 2 * SPECTRUM_HARMONICS, CYCLES_MAX = 400 };

/* Cycles or segments of a test by their number, from 0; hexid gap holds the odd ones out of its
 * fits. */
enum cycles { CYCLES_EVEN = 1, CYCLES_ODD = 2, CYCLES_ALL = 3 };

struct spectrum {
    double omega;                /* fundamental, rad/s */
    int harmonics;               /* number of harmonics: fewer than SPECTRUM_HARMONICS if the
                                  * sampling is slow */
    int cycles;                  /* number of averaged cycles; 0 for a segment */
    double speed_gain;           /* for a segment: standard deviation of a leg's speed for one unit
                                  * of the noise of a sample's length, 1/s */
    double mean[CHANNELS][LEGS][SPECTRUM_SIZE];
    double std[CHANNELS][LEGS][SPECTRUM_SIZE];  /* standard deviation of each coefficient of mean */
    double drift[CHANNELS][LEGS];               /* slope of the constants of all whole cycles, in
                                                 * the channel's unit per second; 0 for a segment */
    double noise[CHANNELS][LEGS];               /* rms of the samples less the mean cycle and the
                                                 * drift, or less a segment's series */
    int offsets;                 /* number of different sampling phases of the averaged cycles: 1 if
                                  * a cycle is a whole number of samples */
    double scatter[CHANNELS][LEGS]; /* standard deviation of samples at one phase, from one cycle to
                                     * the next; 0 for a segment, or if no two cycles share their
                                     * phases */
    /* Standard deviation of each coefficient by rounding errors that repeat in every cycle and are
     * not in std (rounding.h); 0 for a segment. measured_make() fills it. */
    double in_step[CHANNELS][LEGS][SPECTRUM_SIZE];
};

typedef double spectrum_cycle[CHANNELS][LEGS][SPECTRUM_SIZE];

/* Measures the mean cycle of a steady sinusoid over those of the first CYCLES_MAX whole cycles that
 * are in `which`; the drift is that of all these whole cycles. room: receives the coefficients of
 * the averaged cycles, from index 0. step_s: sampling period. Returns false if the sampling is too
 * slow for one harmonic, or if fewer than two cycles of `which` are complete; a complete cycle has
 * nine tenths of its samples good and no long gap. */
bool spectrum_measure(struct spectrum *s, spectrum_cycle room[CYCLES_MAX], const struct recording_test *test, double step_s,
                      enum cycles which);

/* Fits a Fourier series to any motion by least squares, over the samples with from_s <= t <=
 * until_s. Choose 2 pi / omega > until_s - from_s, so that the ends need not match. inverse:
 * inverse of the normal equations; a coefficient's std is the samples' noise times the square root
 * of its diagonal element. Returns false if there are too few good samples, or a gap. */
bool spectrum_cut(struct spectrum *s, const struct recording_test *test, double from_s, double until_s, double omega,
                  double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]);

/* Longest time without a good sample between from_s and until_s, s. */
double spectrum_gap(const struct recording_test *test, double from_s, double until_s);

/* Values of one channel in a sample, one for each leg. */
const double *spectrum_channel(const struct recording_sample *sample, enum channel channel);

/* Fourier basis at a phase: [1, sin phase, cos phase, sin 2 phase, ...], 1 + 2 harmonics values. */
void spectrum_basis(double phase, int harmonics, double *basis);

/* Value of a coefficient row and its first two derivatives in time. spectrum_at takes the instant
 * as a Fourier basis of at least `harmonics` harmonics, spectrum_value as a test time. */
void spectrum_at(const double *row, int harmonics, double omega, const double *basis, double value[3]);
void spectrum_value(const double *row, int harmonics, double omega, double t_s, double value[3]);

/* Standard deviation of a leg's speed by noise, m/s, in a mean cycle of `harmonics` harmonics, or
 * in a segment, of which all harmonics count. */
double spectrum_speed_std(const struct spectrum *s, int leg, int harmonics);

#endif
