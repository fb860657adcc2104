/* A test as harmonics of its frequency, cycle by cycle: means over some of the cycles, and how far
 * single cycles lie from them. That spread is the noise, measured, and so is the correlation of the
 * noise of successive cycles: a motion that wanders slowly drags its rounding errors along. What is
 * in step with the motion (quantisation) does not show in it and is known from the sensor. Pure.
 *
 * A coefficient row is [constant, sin wt, cos wt, sin 2wt, ...], t the test time. */
#ifndef HEXID_SPECTRUM_H
#define HEXID_SPECTRUM_H

#include "recording.h"

enum channel { CHANNEL_LENGTH, CHANNEL_P1, CHANNEL_P2, CHANNEL_VALVE, CHANNEL_FORCE, CHANNELS };
enum { SPECTRUM_HARMONICS = 16, SPECTRUM_SIZE = 1 + 2 * SPECTRUM_HARMONICS, CYCLES_MAX = 400 };

/* Cycles, or pieces, of a test by place; hexid gap keeps the odd ones from its fits. */
enum cycles { CYCLES_EVEN = 1, CYCLES_ODD = 2, CYCLES_ALL = 3 };

struct spectrum {
    double omega;                /* rad/s */
    int harmonics;               /* fewer than SPECTRUM_HARMONICS where the sampling is slow */
    int cycles;                  /* number averaged; 0: of a piece */
    double speed_gain;           /* of a piece: standard deviation of a leg's speed over that of a
                                  * sample, 1/s */
    double mean[CHANNELS][LEGS][SPECTRUM_SIZE];
    double std[CHANNELS][LEGS][SPECTRUM_SIZE];  /* of the mean */
    double noise[CHANNELS][LEGS];               /* rms of the samples about the mean
                                                 * cycle, drift taken out */
    int offsets;                 /* different ways in which samples fall on a cycle: 1 where it is a
                                  * whole number of them */
    double scatter_m[LEGS];      /* scatter of lengths at one phase from cycle to cycle, drift
                                  * included; 0: of a piece, or no two cycles have the same
                                  * phases */
};

typedef double spectrum_cycle[CHANNELS][LEGS][SPECTRUM_SIZE];

/* room: working memory for the single cycles. False: fewer than two cycles of which nine tenths of
 * the samples are there and good. */
bool spectrum_measure(struct spectrum *s, spectrum_cycle room[CYCLES_MAX], const struct recording_test *test, enum cycles which);

/* Fourier coefficients of any motion, of the samples with from_s <= t <= until_s: of a period
 * longer than that, by least squares, so that the ends need not fit each other. std is that of a
 * coefficient; inverse: of the normal equations, whose diagonal's square root times the samples'
 * noise it is. False: too few good samples, or a gap among them. */
bool spectrum_cut(struct spectrum *s, const struct recording_test *test, double from_s, double until_s, double omega,
                  double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]);

/* The longest time without a good sample, s, up to both ends. */
double spectrum_gap(const struct recording_test *test, double from_s, double until_s);

/* A sample's values of all legs. */
const double *spectrum_channel(const struct recording_sample *sample, enum channel channel);

/* [1, sin wt, cos wt, ...], 1 + 2 harmonics values. */
void spectrum_basis(double phase, int harmonics, double *basis);

/* Value of a coefficient row and its first two derivatives in time; spectrum_at: at the phase of a
 * basis of at least so many harmonics. */
void spectrum_at(const double *row, int harmonics, double omega, const double *basis, double value[3]);
void spectrum_value(const double *row, int harmonics, double omega, double t_s, double value[3]);

/* Standard deviation of one coefficient of a sinusoid of this amplitude, read in steps, in so many
 * different samples a cycle, that the spread between cycles does not show: the rounding errors that
 * are the same in every cycle. They are lines sin(2 pi k x / step) step / (pi k) of the motion x,
 * less what the motion's wander from cycle to cycle averages away (dither; scatter, that of samples
 * at one phase, tells how much). The k-th is spread over the harmonics up to z = 2 pi k amplitude /
 * step (Bessel functions: J_n(z)^2 is 1 / (pi z) on average); beyond z = samples it aliases, alike
 * on all harmonics. The larger of the two is taken, up to twice too much just below that. */
double spectrum_quantisation(double amplitude, double step, double scatter, double samples);

/* Standard deviation of a leg's speed in the mean cycle of so many harmonics, m/s, with position
 * sensors of this resolution; of a piece with all its harmonics. */
double spectrum_speed_std(const struct spectrum *s, int leg, int harmonics, double step_m, double samples);

#endif
