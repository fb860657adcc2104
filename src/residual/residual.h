/* Equation residuals: the part of a measured motion that a model cannot account for, without
 * controller and without a closed loop.
 *
 *   force     A1 P1 - A2 P2 - (inverse dynamics of the measured motion: all 13 rigid bodies,
 *             weight, friction), per leg, N
 *   pressure  P measured - P of the chambers when spool and oil follow the measured commands and
 *             the measured motion, per leg, Pa
 *
 * Signals are Fourier series, so that velocity and acceleration need no differences: of the mean
 * cycle of a test that repeats one, otherwise of a piece (motion.h) and its margins; the chambers
 * also see the motion that is too fast for a piece's series. The effects of the model's sensors
 * (scale, offset, lag, delay) are undone in the series, before any law is applied. Commands are
 * held for the controller's cycle; those that a slower recording lacks are interpolated. Without
 * pressures the force is the reading of its sensor or drive; without pressures or commands the
 * chambers are not evaluated. One axis is a machine of one leg, whose inverse dynamics is m (a +
 * g), springs and friction. Rigid bodies, hydraulics and effects are sim's. Both residuals are rows
 * of coefficients in the units of the readings, as the whitener's noise is, so that a sensor's
 * scale cannot shrink them. A cycle's row holds its harmonics. A piece's row holds local cosines,
 * whose overlapping windows are orthogonal (Coifman, Meyer 1991), so that white noise stays white;
 * measured and simulated values both reach it through the series. For the right model the rows are
 * zero within the noise. Pure but for the heap. */
#ifndef HEXID_RESIDUAL_H
#define HEXID_RESIDUAL_H

#include "fast_motion.h"
#include "play.h"
#include "spectrum.h"

enum residual_kind { RESIDUAL_FORCE, RESIDUAL_P1, RESIDUAL_P2, RESIDUALS };
enum { CYCLE_STEPS = 1024 };
enum { RESIDUAL_HARMONICS = 8, RESIDUAL_SIZE = 1 + 2 * RESIDUAL_HARMONICS };

/* length of a piece times the highest frequency of its row, no unit */
#define RESIDUAL_BAND (0.5 * (RESIDUAL_SIZE - 0.5))
#define RESIDUAL_SETTLE_S 0.1 /* chambers forget their start, the measured pressures, in 30 ms */
double residual_margin_s(double piece_s); /* margin of record that a piece needs on either side */
double residual_gap_s(double piece_s, double step_s); /* longest time in a piece without a good
                                                       * sample */

/* Parts of the residuals that can be computed separately. */
enum residual_part { PART_FORCE = 1, PART_PRESSURE = 2, PART_ALL = 3, PART_FORCE_SENSOR = 4 };

typedef double residual_row[LEGS][RESIDUALS][RESIDUAL_SIZE]; /* rows of one test */

struct residual_test {
    int of;                      /* place in the recording */
    struct spectrum spectrum;
    int legs;                    /* legs of the mechanism; rows of the others are zero */
    bool pressures, chambers;    /* pressures are measured, not a force; commands are measured, too,
                                  * so that chambers are evaluated */
    int harmonics;               /* harmonics of the motion */
    int size;                    /* coefficients of a row, at most RESIDUAL_SIZE */
    double rate[RESIDUAL_SIZE];  /* frequency of each coefficient, rad/s */
    double weight[RESIDUAL_SIZE];/* weight of a coefficient's square in the mean square */
    double curve[RESIDUAL_SIZE]; /* noise of an acceleration over that of a length, 1/s^2: rate^2,
                                  * more where a window bends */
    /* measured rows and their standard deviations */
    double row[CHANNELS][LEGS][RESIDUAL_SIZE], std[CHANNELS][LEGS][RESIDUAL_SIZE];
    double speed_std_mps[LEGS];  /* standard deviations of the legs' speeds */
    double force_std_n[LEGS];    /* standard deviation of the force residual at an instant */
    struct play_noise play_noise;
    double (*coupling)[SPECTRUM_SIZE]; /* [size]: Fourier coefficients to a row */
    double first_s, step_s;      /* test time of the first simulated sample; time between commands:
                                  * the sampling period, or the controller's where the recording is
                                  * slower */
    bool in_step;                /* samples and commands fall on the same instants */
    int measured;                /* measured samples per cycle */
    int samples, fitted;         /* simulated; only the last `fitted` are compared */
    int substeps;                /* substeps per command */
    int phases;                  /* instants at which the force is evaluated; PHASES fill a period
                                  * of the series */
    double *cycle;               /* [CYCLE_STEPS][SPECTRUM_SIZE]: basis of the series over its
                                  * period, from the first phase on */
    double (*shape)[RESIDUAL_SIZE];   /* [phases]: values of a row's functions at a phase */
    double (*project)[RESIDUAL_SIZE]; /* contribution of a value at a phase to a row */
    double (*series)[SPECTRUM_SIZE];  /* contribution of a value at a phase to the series */
    double *node;                /* [2 substeps samples + 1][1 + 2 harmonics]: basis at the ends and
                                  * middles of the substeps */
    struct fast_motion fast;     /* for pieces: measured motion beyond the series. The chambers see
                                  * it because the valve's flow law bends where the spool crosses
                                  * zero, so that motion above the rows' band makes pressure errors
                                  * within it */
    int lead;                    /* for pieces: commands before the first simulated sample */
    double *valve;               /* [lead + samples][leg]: commands */
    double *dither;              /* [samples][leg]: noise of the sent commands, which their mean
                                  * cycle lacks; NULL: valve includes it */
    double *projection;          /* [size][fitted]: samples to a row */
};

/* Number of coefficients of the motion's series. */
static inline int residual_motion_size(const struct residual_test *t) { return 1 + 2 * t->harmonics; }

struct residual_data {
    int tests;
    enum residual_part parts;    /* parts that can be evaluated; other rows are zero.
                                  * PART_FORCE_SENSOR: force from a sensor, not from pressures */
    struct residual_test *test;
};

/* Makes the tables of each test, from the cycles or pieces of `which`. 0, -2 (fewer than two whole
 * cycles) or -3 (memory). Call residual_free in any case. */
int residual_prepare(struct residual_data *d, const struct recording *recording, enum cycles which, struct error *error);
void residual_free(struct residual_data *d);

enum { ALL_LEGS = -1 };

/* Computes the rows of a test under a model; kinds outside `parts` stay as they are. leg: ALL_LEGS,
 * or the only leg whose pressures are computed, where residual_legs_apart() includes them. False if
 * no machine of this model can move like this, or no such machine can exist. */
bool residual_evaluate(const struct residual_test *t, const struct params *model, enum residual_part parts, int leg, residual_row row);

/* Parts in which the legs are independent, so that a leg's own constants move no other leg's
 * residuals: none if the legs share hoses to the power unit; not the force if backlash moves the
 * pose, and nothing if there are hoses to the gauges as well. */
enum residual_part residual_legs_apart(const struct params *model);

/* Rate of a leg's length as a row, m/s. */
void residual_rate(const struct residual_test *t, int leg, double row[RESIDUAL_SIZE]);

/* Mean square of the varying part of a channel. */
double residual_variation(const struct residual_test *t, enum channel channel, int leg);

/* Ripple in the measured force, by the model's chambers. Commands held from sample to sample make
 * the force ripple, and samples in step with them always see the same phase of it. Zero where
 * commands are 0.5 ms apart or less (the ripple is then a sixteenth of that at 2 ms) or samples are
 * not in step. False where the chambers are not evaluated. */
bool residual_staircase(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]);

/* Inverse dynamics alone: hydraulic force of each leg for the measured motion, with friction. */
bool residual_required(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]);

#endif
