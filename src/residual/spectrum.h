/* A test as harmonics of its frequency: means over some of its cycles, and the spread of single
 * cycles about them. The spread measures the noise and its correlation between successive cycles,
 * for a motion that wanders slowly drags its rounding errors along. Errors in step with the motion
 * (quantisation) do not show in it; they are computed from the sensor's resolution. Pure.
 *
 * A coefficient row is [constant, sin wt, cos wt, sin 2wt, ...], t the test time. */
#ifndef HEXID_SPECTRUM_H
#define HEXID_SPECTRUM_H

#include "recording.h"

enum channel { CHANNEL_LENGTH, CHANNEL_P1, CHANNEL_P2, CHANNEL_VALVE, CHANNEL_FORCE, CHANNELS };
enum { SPECTRUM_HARMONICS = 16, SPECTRUM_SIZE = 1 + 2 * SPECTRUM_HARMONICS, CYCLES_MAX = 400 };

/* Cycles, or pieces, of a test by place; hexid gap holds the odd ones out of its fits. */
enum cycles { CYCLES_EVEN = 1, CYCLES_ODD = 2, CYCLES_ALL = 3 };

struct spectrum {
    double omega;                /* rad/s */
    int harmonics;               /* fewer than SPECTRUM_HARMONICS where the sampling is slow */
    int cycles;                  /* cycles averaged; 0 for a piece */
    double speed_gain;           /* for a piece: standard deviation of a leg's speed over that of a
                                  * sample, 1/s */
    double mean[CHANNELS][LEGS][SPECTRUM_SIZE];
    double std[CHANNELS][LEGS][SPECTRUM_SIZE];  /* standard deviation of the mean */
    double noise[CHANNELS][LEGS];               /* rms of samples about mean cycle, less drift */
    int offsets;                 /* number of distinct sampling phases of the cycles: 1 if a cycle
                                  * is a whole number of samples */
    double scatter_m[LEGS];      /* scatter of lengths at one phase from cycle to cycle, drift
                                  * included; 0 for a piece, or if no two cycles share their
                                  * phases */
};

typedef double spectrum_cycle[CHANNELS][LEGS][SPECTRUM_SIZE];

/* room: working memory for the single cycles. False: fewer than two cycles have nine tenths of
 * their samples present and good. */
bool spectrum_measure(struct spectrum *s, spectrum_cycle room[CYCLES_MAX], const struct recording_test *test, enum cycles which);

/* Fourier coefficients of any motion, by least squares over the samples with from_s <= t <=
 * until_s; the period is longer than that, so that the ends need not match. inverse: of the normal
 * equations; a coefficient's std is the samples' noise times the square root of its diagonal.
 * False: too few good samples, or a gap. */
bool spectrum_cut(struct spectrum *s, const struct recording_test *test, double from_s, double until_s, double omega,
                  double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]);

/* Longest time without a good sample, s, the ends included. */
double spectrum_gap(const struct recording_test *test, double from_s, double until_s);

/* Values of one channel of a sample, all legs. */
const double *spectrum_channel(const struct recording_sample *sample, enum channel channel);

/* [1, sin wt, cos wt, ...], 1 + 2 harmonics values. */
void spectrum_basis(double phase, int harmonics, double *basis);

/* Value of a coefficient row and its first two derivatives in time. spectrum_at takes the phase as
 * a basis of at least so many harmonics. */
void spectrum_at(const double *row, int harmonics, double omega, const double *basis, double value[3]);
void spectrum_value(const double *row, int harmonics, double omega, double t_s, double value[3]);

/* Standard deviation that quantisation gives each coefficient of a sinusoid of this amplitude, read
 * in steps, with so many distinct samples a cycle. It covers the rounding errors that repeat in
 * every cycle, unseen in the spread between cycles: tones sin(2 pi k x / step) step / (pi k) of the
 * motion x, less the part that its wander from cycle to cycle averages away (dither); scatter, the
 * spread of samples at one phase, tells how much. Tone k spreads over the harmonics up to z = 2 pi
 * k amplitude / step (Bessel functions: J_n(z)^2 is 1 / (pi z) on average); beyond z = samples it
 * aliases evenly onto all. The larger of the two is taken, up to twice too much just below that. */
double spectrum_quantisation(double amplitude, double step, double scatter, double samples);

/* Standard deviation of a leg's speed in the mean cycle of so many harmonics, m/s, with position
 * sensors of this resolution. For a piece all its harmonics count. */
double spectrum_speed_std(const struct spectrum *s, int leg, int harmonics, double step_m, double samples);

#endif
