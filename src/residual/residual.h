/* Equation residuals: the part of a measured motion that a model cannot account for, without
 * controller and without a closed loop.
 *
 *   force     A1 P1 - A2 P2 - (inverse dynamics of the measured motion: all 13 rigid bodies,
 *             weight, friction), per leg, N
 *   pressure  P measured - P of the chambers when spool and oil follow the measured commands and
 *             the measured motion, per leg, Pa
 *
 * Signals are Fourier series, so that velocity and acceleration need no difference quotients. A
 * test that repeats its motion gives the series of its mean cycle; any other motion is cut into
 * segments (motion.h), each with a series of its own over the segment and its margins. The
 * chambers' simulation also gets the motion that is too fast for a segment's series. The effects of
 * the model's sensors (scale, offset, lag, delay, pipes) are undone in the series, before any law
 * is applied. Commands are held for the controller's cycle; those that a slower recording lacks are
 * interpolated. Without pressures the force is the reading of its sensor or drive; without
 * pressures or commands the chambers are not evaluated. One axis is a machine of one leg, whose
 * inverse dynamics is m (a + g), springs and friction. Rigid bodies, hydraulics and effects are
 * those of sim.
 *
 * A residual is a row of coefficients. Its unit is that of the readings, as in the whitener's
 * noise, so that a sensor's scale cannot reduce the residual. The row of a cycle contains its
 * harmonics. The row of a segment contains local cosines, whose overlapping windows are orthogonal
 * (Coifman, Meyer 1991), so that white noise stays white; measured and simulated values both pass
 * through the series. For the right model all coefficients are zero within the noise. Pure, except
 * for the heap. */
#ifndef HEXID_RESIDUAL_H
#define HEXID_RESIDUAL_H

#include "fast_motion.h"
#include "measured.h"
#include "play.h"

enum residual_kind { RESIDUAL_FORCE, RESIDUAL_P1, RESIDUAL_P2, RESIDUALS };
enum { RESIDUAL_HARMONICS = 8, RESIDUAL_SIZE = 1 + 2 * RESIDUAL_HARMONICS };

/* Highest frequency of a segment's coefficient row, times the length of the segment; no unit. */
#define RESIDUAL_BAND (0.5 * (RESIDUAL_SIZE - 0.5))
double residual_margin_s(double segment_s); /* length of record that a segment needs on either side,
                                             * s */
double residual_gap_s(double segment_s, double step_s); /* longest time without a good sample that a
                                                         * segment may have, s */

/* Parts of the residuals that can be computed separately; EQUATIONS_FORCE_SENSOR marks a force
 * that is measured, not computed from pressures. */
enum residual_equations { EQUATIONS_FORCE = 1, EQUATIONS_PRESSURE = 2, EQUATIONS_ALL = 3, EQUATIONS_FORCE_SENSOR = 4 };

typedef double residual_row[LEGS][RESIDUALS][RESIDUAL_SIZE]; /* [leg][residual][coefficient]:
                                                              * residuals of a test */

struct residual_test {
    int of;                      /* index of the test in the recording */
    struct spectrum spectrum;
    int legs;                    /* number of legs of the mechanism; coefficients of the others are
                                  * zero */
    /* pressures: pressures are measured, and the force is computed from them. chambers: commands
     * are measured as well, so that the chambers' pressures are evaluated. */
    bool pressures, chambers;
    int harmonics;               /* harmonics of the motion's series */
    int size;                    /* coefficients in a row, at most RESIDUAL_SIZE */
    double rate[RESIDUAL_SIZE];  /* frequency of each coefficient, rad/s */
    double weight[RESIDUAL_SIZE];/* weight of each coefficient's square in the mean square */
    double curve[RESIDUAL_SIZE]; /* noise of an acceleration divided by the noise of a length,
                                  * 1/s^2: rate^2, or more where a window's slope adds to it */
    /* coefficient rows of the measured values, and their standard deviations by noise and, for a
     * cycle, by rounding in step with the motion */
    double row[CHANNELS][LEGS][RESIDUAL_SIZE], std[CHANNELS][LEGS][RESIDUAL_SIZE];
    double speed_std_mps[LEGS];  /* standard deviation of each leg's speed */
    double force_std_n[LEGS];    /* standard deviation of each leg's force residual at an instant */
    bool slides;                 /* legs that may be held have the friction of sliding ones (struct
                                  * inverse_dynamics) */
    struct play_noise play_noise;
    double (*coupling)[SPECTRUM_SIZE]; /* [size]: matrix from Fourier coefficients to a coefficient
                                        * row */
    /* first_s: test time of the first simulated sample. step_s: time between commands, which is the
     * sampling period, or the controller's period where the recording is slower. */
    double first_s, step_s;
    bool in_step;                /* every sample falls on a command's instant */
    int measured;                /* measured samples per cycle; 0 for a segment */
    /* samples: number of simulated samples. fitted: number of samples at their end that are
     * compared with the measured ones */
    int samples, fitted;
    int substeps;                /* simulation steps per command */
    int phases;                  /* number of instants at which the force is evaluated; PHASES of
                                  * them fill a period of the series */
    double *cycle;               /* [PHASES][SPECTRUM_SIZE]: Fourier basis over a period of the
                                  * series, from the first phase on */
    double (*basis)[RESIDUAL_SIZE];   /* [phases]: value at a phase of the function that belongs to
                                       * each element of a row */
    double (*project)[RESIDUAL_SIZE]; /* [phases]: contribution of a value of 1 at a phase to each
                                       * element of a row */
    double (*series)[SPECTRUM_SIZE];  /* [phases]: contribution of a value of 1 at a phase to each
                                       * Fourier coefficient */
    double *node;                /* [2 substeps samples + 1][1 + 2 harmonics]: Fourier basis at the
                                  * nodes, which are the ends and middles of the simulation steps;
                                  * NULL without residual_tabulate() */
    struct fast_motion fast;     /* for segments: measured motion that the series lacks. It is too
                                  * fast for the rows, but the chambers need it: the valve's flow
                                  * law bends where the spool crosses zero, and so converts fast
                                  * motion to slower pressure changes */
    int lead;                    /* for segments: number of commands before the first simulated
                                  * sample */
    double *valve;               /* [lead + samples][leg]: commands */
    double *dither;              /* [samples][leg]: noise of the sent commands, which their mean
                                  * cycle lacks; NULL: `valve` includes it */
    double *projection;          /* [size][fitted]: matrix from simulated samples to a coefficient
                                  * row */
};

/* Number of Fourier coefficients of the motion. */
static inline int residual_motion_size(const struct residual_test *t) { return 1 + 2 * t->harmonics; }

struct residual_data {
    int tests;
    enum residual_equations equations; /* equations that can be evaluated; coefficients of others
                                        * are zero */
    struct residual_test *test;
};

/* Makes the tables of each test from the cycles or segments of `which`. Returns 0, -2 (fewer than
 * two whole cycles, or too many samples missing) or -3 (no memory). Call residual_free in any
 * case. */
int residual_prepare(struct residual_data *d, const struct recording *recording, enum cycles which, struct error *error);
void residual_free(struct residual_data *d);

/* Keeps the Fourier basis at all nodes of the simulations, up to 5 MB a test, for a caller that
 * evaluates many models. Without this table each evaluation computes the basis anew, with the same
 * result. Returns 0, or -3 without memory. */
int residual_tabulate(struct residual_data *d, struct error *error);

/* Computes the Fourier basis at a node of a test's simulation: 1 + 2 harmonics values. */
void residual_node(const struct residual_test *t, int node, double *basis);

enum { ALL_LEGS = -1 };

/* Computes the coefficient rows of a test under a model. Rows outside `equations` stay as they are,
 * except that rows of legs and pressures that are not evaluated become zero, and that with hoses
 * between gauges and chambers all rows are computed. leg: ALL_LEGS, or the only leg whose pressures
 * are computed, which is allowed if residual_legs_apart() includes EQUATIONS_PRESSURE. Returns
 * false if the model's machine cannot exist, or cannot move like this. */
bool residual_evaluate(const struct residual_test *t, const struct params *model, enum residual_equations equations, int leg,
                       residual_row row);

/* Returns the equations in which the legs are independent, so that a leg's own constants change no
 * other leg's residuals. There are none if the legs share hoses to the power unit, or if there are
 * both backlash and hoses between gauges and chambers. With backlash alone the force is not among
 * them, because backlash moves the pose. Otherwise all equations are returned. */
enum residual_equations residual_legs_apart(const struct params *model);

/* Computes the covariance, N^2, that the unknown friction of a leg gives its force row while the
 * leg may be held. At an instant the variance of this friction is inverse_dynamics_held_variance().
 * The covariance is zero for a leg that is never held, and for all legs if the model cannot move
 * like this. */
void residual_held(const struct residual_test *t, const struct params *model, double covariance[LEGS][RESIDUAL_SIZE][RESIDUAL_SIZE]);

/* Coefficient row of the rate of a leg's length, m/s. */
void residual_rate(const struct residual_test *t, int leg, double row[RESIDUAL_SIZE]);

/* Mean square of the varying part of a measured channel. */
double residual_variation(const struct residual_test *t, enum channel channel, int leg);

/* Computes coefficient rows of the ripple that sampling adds to the measured force, by simulating
 * the model's chambers. Held commands make the force ripple, and samples in step with them always
 * read the same phase. If commands are at most 0.5 ms apart (the ripple is then a sixteenth of the
 * one at 2 ms), or samples are not in step, the rows are zero and the result is true. Otherwise
 * returns false if the chambers are not evaluated, or without memory. */
bool residual_staircase(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]);

/* Computes the coefficient rows of the hydraulic force that each leg needs for the measured motion,
 * friction included, by inverse dynamics alone. Returns false if no pose has these lengths. */
bool residual_required(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]);

#endif
