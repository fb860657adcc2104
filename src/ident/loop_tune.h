/* Controller gains from a configuration alone: performance of the configured gains, and first gains
 * with which the machine may be driven. All is computed with the linear loop in every pose where
 * the machine may be held (loop_places.h); nothing is simulated. docs/tuning.md derives the
 * formulas.
 *
 * kff follows from the speed of a leg at full opening, and from the amplitudes that the configured
 * tests then reach. kp is the largest with which, for some kpf, the loop meets four requirements;
 * ki is TUNE_INTEGRAL kp times the bandwidth. First, in every pose every mode must have a gain
 * margin of TUNE_GAIN_DB, a phase margin of TUNE_PHASE_DEG at the valve command, and stable poles.
 * Second, the slowest mode of the oil must have a damping ratio of TUNE_DAMPING or, if no gains
 * reach it, the largest smaller one of a list that gains do reach, at neutral and on the way down
 * to parking. Third, each mode must have a least damping at neutral (MODE_DAMPING in loop_tune.c).
 * Fourth, the acceleration that the sensors' noise causes must be small (NOISE_SHARE in
 * loop_tune.c). Ordinary threads; heap. */
#ifndef HEXID_LOOP_TUNE_H
#define HEXID_LOOP_TUNE_H

#include "loop_margin.h"
#include "loop_places.h"
#include "params/control.h"

#define TUNE_GAIN_DB 6.0
#define TUNE_PHASE_DEG 45.0
#define TUNE_DAMPING 0.3
/* ki / (kp bandwidth): the integral part costs 3 degrees of phase where the gain of the position
 * loop is 1 */
#define TUNE_INTEGRAL 0.05
/* largest bandwidth kp / kff, as a share of the slowest oil mode's frequency: with more, the
 * stability of the loop would depend on this mode's damping, which is the least certain value of
 * all */
#define TUNE_BANDWIDTH (1.0 / 3.0)
/* least delay margin of the loop with control.modal, as a share of the delay margin without it */
#define TUNE_MODAL_DELAY 0.5
/* largest error of a leg at its fastest motion, as a share of limits.following_m. It arises because
 * kff fits only the mean of the speeds in both directions */
#define TUNE_FOLLOWING 0.7

/* One margin, in the pose and the mode in which it is least. */
struct loop_least {
    double value, hz;
    enum dof dof;                /* axis that moves most in the mode */
    double pose[DOFS];
};

/* Performance of a controller on this machine. */
struct loop_standing {
    bool stable;                 /* the loop is stable in every pose */
    struct loop_least gain_db;   /* gain margin, up or down, at the valve command */
    struct loop_least phase_deg, delay_s;
    struct loop_least damping;   /* damping ratio of the slowest mode, at neutral and on the way
                                  * down to parking */
    double noise_mps2, noise_most_mps2;   /* rms acceleration that the sensors' noise causes, and
                                           * the largest accepted one */
    struct loop_least amplitude; /* largest error of a mode's amplitude, relative to its reference,
                                  * at the configured tests' frequencies, at neutral */
    double following_m;          /* error of a leg's length at the fastest motion. It arises because
                                  * kff is one value, but the speeds at full opening differ by
                                  * direction */
    struct loop_mode_standing {  /* modes by ascending frequency, at neutral */
        enum dof dof;
        double oil_hz, oil_damping;       /* without a controller */
        double hz, damping;               /* least damped pair of poles with the controller; hz NaN
                                           * and damping 1: there is none */
        double bandwidth_hz;
        struct loop_least gain_db, phase_deg; /* least margins over all poses */
    } mode[DOFS];
};

/* Part of the machine that keeps the loop from the required performance. */
enum loop_part { LOOP_PART_NONE, LOOP_PART_VALVE, LOOP_PART_CYCLE, LOOP_PART_OIL, LOOP_PARTS };

struct loop_tune {
    struct control_params now, gains;     /* configured gains, and found ones; limits and tf are the
                                           * same in both */
    struct loop_standing before, after;
    double out_mps, in_mps;      /* mean speeds of a leg at full opening, at neutral */
    double damping_wanted;       /* required damping of the slowest mode: TUNE_DAMPING, or the
                                  * largest that some gains reach */
    bool reached;                /* the found gains meet all requirements */
    enum loop_part limit;        /* part whose improvement adds most damping; none: all requirements
                                  * are met, the parts were not tried, or no part helps alone */
    double part_damping[LOOP_PARTS]; /* damping of the slowest mode that is reached with the valve,
                                      * or the cycle and the delays, four times as fast, or with oil
                                      * twice as stiff; 0: not tried, or no gains found */
};

/* Finds gains. bus: the machine is on a field bus. parts: if the requirements are not met, also
 * look for the limiting part; each part takes as long as finding the gains. Returns -2 if the
 * supply cannot hold the platform up at neutral, modal_init() cannot compute the modal weights of
 * the configured controller, or a delay exceeds LOOP_DELAY_MOST cycles; -3 without memory. */
int loop_tune(const struct params *params, bool bus, bool parts, struct loop_tune *result, struct error *error);

/* Finds gains for the machine as a survey found it at neutral, in place of the configured one:
 * payload, friction, oil, valves, and delays including those of a bus. The survey must be
 * determined. Errors as loop_tune(). */
struct loop_survey;
int loop_tune_surveyed(const struct params *params, const struct loop_survey *survey, struct loop_tune *result, struct error *error);

/* Finds the performance of the configured gains, without looking for others. Errors as
 * loop_tune(). */
int loop_tune_stand(const struct params *params, bool bus, struct loop_standing *standing, struct error *error);

/* Upper bound of a leg's speed in the moves and in the configured tests, m/s. A trajectory counts
 * as 0, because its speeds are not known here. */
double loop_fastest_mps(const struct params *params);

/* Axis and value of the pose as text: "z 0.45 m"; "neutral". */
enum { LOOP_POSE_SIZE = 40 };
void loop_pose_text(const double pose[DOFS], char text[LOOP_POSE_SIZE]);

#endif
