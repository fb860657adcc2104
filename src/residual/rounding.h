/* Rounding errors that repeat in every cycle of a steady sinusoid, because its samples are at the
 * same places of each cycle. They cause no spread between cycles and do not average out over many
 * cycles; they are therefore computed from the sensor's step.
 *
 * A rounding error is a sum of tones of the motion x: sin(2 pi k x / step) step / (pi k), k = 1, 2,
 * .. . Variation from cycle to cycle weakens the mean of a tone (dither). Noise of standard
 * deviation s weakens tone k by the factor exp(-2 (pi k s / step)^2); drift weakens it by the mean
 * of exp(2 pi i k drift / step) over all cycles. Noise and drift must be treated separately: a
 * machine drifts by whole steps of the sensor only while it settles, and most cycles of a long test
 * come after that.
 *
 * The position of x within a step counts as unknown, so that the phase of each tone is random. The
 * place of the motion's peaks within a step counts as unknown, too, because the mean cycle contains
 * the errors that are sought. Apart from that the mean cycle decides how much of a tone falls on
 * each harmonic: a sinusoid of amplitude A spreads the tone over the harmonics up to z = 2 pi k A /
 * step (Bessel functions), most of it just below z, where the motion reverses. N samples a cycle
 * fold the harmonics above N / 2 back onto lower ones. Pure. */
#ifndef HEXID_ROUNDING_H
#define HEXID_ROUNDING_H

enum { ROUNDING_TONES = 20, ROUNDING_HARMONICS = 16 };

/* A signal that is read in steps. */
struct rounding {
    double step;
    /* scatter: standard deviation of samples at one place, from one cycle to the next. first_phase:
     * phase of the first sample, rad. */
    double scatter, first_phase;
    int places;                /* number of evenly spaced places in a cycle that have samples */
    int cycles;
    const double *middle;      /* [cycles]: mean of each cycle */
};

/* Shares of the tones that fall on each coefficient of a mean cycle: variance of the coefficient,
 * in the signal's unit squared, by a tone of mean square 1 step^2. The shares depend on the motion
 * and on the places of its samples. The cycles for which they are found decide how many tones
 * count, and which harmonics are motion. */
struct rounding_shares {
    int tones;                 /* number of tones up to the last one that counts; 0: there are no
                                * rounding errors */
    double of[ROUNDING_TONES][1 + 2 * ROUNDING_HARMONICS];
};

/* Finds the shares for a mean cycle `row` of 1 + 2 harmonics coefficients. */
void rounding_find_shares(const struct rounding *r, int harmonics, const double *row, struct rounding_shares *shares);

/* Computes the variance that the rounding errors described above give each of the 1 + 2 harmonics
 * coefficients of the mean cycle. The shares may be those of other cycles at the same places. */
void rounding_in_step(const struct rounding *r, const struct rounding_shares *shares, int harmonics, double *variance);

#endif
