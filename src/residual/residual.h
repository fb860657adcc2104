/* Equation residuals: what a model cannot account for in a measured motion, without its controller
 * and without a closed loop.
 *
 *   force     A1 P1 - A2 P2 - (inverse dynamics of the measured motion: all 13 rigid bodies,
 *             weight, friction), per leg, N
 *   pressure  P measured - P of the chambers when spool and oil follow the measured commands and
 *             the measured motion, per leg, Pa
 *
 * Signals are Fourier series: of the mean cycle where a test repeats one, else of a piece of the
 * record and what lies about it, of which the chambers see what is faster, too. So velocity and
 * acceleration need no differences; what the model's sensors do to lengths and pressures (scale,
 * offset, lag, delay) is undone there, before any law is applied. Commands are held for the
 * controller's cycle; those that a slower recording lacks are interpolated. Without pressures the
 * force is what its sensor or drive says; without pressures or commands the chambers are not
 * evaluated. One axis is a machine of one leg, whose inverse dynamics is m (a + g), springs and
 * friction. The physics is that of sim's rigid bodies, hydraulics and effects, written once. Both
 * residuals are rows of coefficients, in the units of the readings, as is the whitener's noise: a
 * sensor's scale does not make them smaller. Of a cycle they are its harmonics; of a piece local
 * cosines, whose windows overlap so that all of them together are orthogonal (Coifman, Meyer 1991)
 * and white noise stays white; measured and simulated alike go there by way of the series. For the
 * right model they are zero within the noise. Pure but for the heap. */
#ifndef HEXID_RESIDUAL_H
#define HEXID_RESIDUAL_H

#include "fast_motion.h"
#include "play.h"
#include "spectrum.h"

enum residual_kind { RESIDUAL_FORCE, RESIDUAL_P1, RESIDUAL_P2, RESIDUALS };
enum { CYCLE_STEPS = 1024 };
enum { RESIDUAL_HARMONICS = 8, RESIDUAL_SIZE = 1 + 2 * RESIDUAL_HARMONICS };

/* of a piece: its length times the highest frequency of its row, no unit */
#define RESIDUAL_BAND (0.5 * (RESIDUAL_SIZE - 0.5))
#define RESIDUAL_SETTLE_S 0.1 /* chambers forget the start, the measured pressures, in 30 ms */
double residual_margin_s(double piece_s); /* time of record that a piece needs on either side */
double residual_gap_s(double piece_s, double step_s); /* longest time without a good sample that
                                                       * a piece can have */

/* Parts of the residuals that can be computed by themselves. */
enum residual_part { PART_FORCE = 1, PART_PRESSURE = 2, PART_ALL = 3, PART_FORCE_SENSOR = 4 };

typedef double residual_row[LEGS][RESIDUALS][RESIDUAL_SIZE]; /* of one test */

struct residual_test {
    int of;                      /* its place in the recording */
    struct spectrum spectrum;
    int legs;                    /* that the mechanism has; rows of the others are zero */
    bool pressures, chambers;    /* pressures are measured, else a force; commands are, too: the
                                  * chambers are evaluated */
    int harmonics;               /* of the motion */
    int size;                    /* of a row, at most RESIDUAL_SIZE */
    double rate[RESIDUAL_SIZE];  /* rad/s, of each coefficient, */
    double weight[RESIDUAL_SIZE];/* and weight of its square in the mean square, */
    double curve[RESIDUAL_SIZE]; /* and an acceleration's noise over a length's, 1/s^2: rate^2, more
                                  * where a window bends */
    /* what was measured, and its standard deviation */
    double row[CHANNELS][LEGS][RESIDUAL_SIZE], std[CHANNELS][LEGS][RESIDUAL_SIZE];
    double speed_std_mps[LEGS];  /* of the legs' speeds, by noise and rounding */
    double force_std_n[LEGS];    /* of the force residual at an instant */
    struct play_noise play_noise;
    double (*coupling)[SPECTRUM_SIZE]; /* [size]: from Fourier coefficients to a row */
    double first_s, step_s;      /* test time of the first simulated sample; from command to
                                  * command: sampling, or the controller's cycle where the
                                  * recording has not every one */
    bool in_step;                /* samples and commands fall on the same instants */
    int measured;                /* samples a cycle */
    int samples, fitted;         /* simulated; the last so many are compared */
    int substeps;                /* a command */
    int phases;                  /* at which the force is evaluated, PHASES a period of the
                                  * series */
    double *cycle;               /* [CYCLE_STEPS][SPECTRUM_SIZE]: the series' basis over its period,
                                  * from the first phase on */
    double (*shape)[RESIDUAL_SIZE];   /* [phases]: value there of each coefficient of a row, */
    double (*project)[RESIDUAL_SIZE]; /* and what a value there adds to a row, */
    double (*series)[SPECTRUM_SIZE];  /* and to the Fourier coefficients */
    double *node;                /* [2 substeps samples + 1][1 + 2 harmonics]: basis at the ends and
                                  * middles of the substeps */
    struct fast_motion fast;     /* of a piece: what the measured motion has beyond the series; the
                                  * chambers see it, since the valve's flow law changes where the
                                  * spool crosses zero, so that motion above the rows' band makes
                                  * errors of pressure within it */
    int lead;                    /* of a piece: commands before the first simulated sample */
    double *valve;               /* [lead + samples][leg] */
    double *dither;              /* [samples][leg]: noise that the commands were sent with and that
                                  * their mean cycle has not; NULL: valve has it */
    double *projection;          /* [size][fitted]: samples to a row */
};

/* Coefficients of the motion's series. */
static inline int residual_motion_size(const struct residual_test *t) { return 1 + 2 * t->harmonics; }

struct residual_data {
    int tests;
    enum residual_part parts;    /* parts that can be evaluated; the rows of others are zero;
                                  * PART_FORCE_SENSOR: from a force sensor, not from pressures */
    struct residual_test *test;
};

/* Makes the tables of each test, from the cycles or pieces of `which`. 0, or -2 (fewer than two
 * whole cycles) or -3 (memory). To be freed in any case. */
int residual_prepare(struct residual_data *d, const struct recording *recording, enum cycles which, struct error *error);
void residual_free(struct residual_data *d);

enum { ALL_LEGS = -1 };

/* Rows of a test under a model; kinds outside `parts` are left as they are. leg: ALL_LEGS, or the
 * only one whose pressures are computed, where residual_legs_apart() has these. False where no
 * machine of this model can move like this, or there can be no such machine. */
bool residual_evaluate(const struct residual_test *t, const struct params *model, enum residual_part parts, int leg, residual_row row);

/* The parts in which the legs are independent, so that no leg's own constants move another leg's
 * residuals: none where they share lines to the power unit; not the force where play moves the
 * pose, nor anything where pipes are before that. */
enum residual_part residual_legs_apart(const struct params *model);

/* The rate of a leg's length as a row, m/s. */
void residual_rate(const struct residual_test *t, int leg, double row[RESIDUAL_SIZE]);

/* Mean square of the varying part of a channel. */
double residual_variation(const struct residual_test *t, enum channel channel, int leg);

/* Commands that are held from sample to sample make the force ripple, and samples in step with them
 * see the ripple always at the same phase: how much of the measured force that is, by the model's
 * chambers. Zero where commands are 0.5 ms apart or less (the ripple is then a sixteenth of that at
 * 2 ms), or samples are not in step. False where the chambers are not evaluated. */
bool residual_staircase(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]);

/* Inverse dynamics alone: the hydraulic force that each leg needs for the measured motion, friction
 * included. */
bool residual_required(const struct residual_test *t, const struct params *model, double force_n[LEGS][RESIDUAL_SIZE]);

#endif
