/* Gains from a configuration alone: how the configured ones stand, and the first ones with which
 * the machine may be driven. All is computed with the linear loop in every pose where the machine
 * may be held (loop_places.h); nothing is simulated. docs/tuning.md derives the formulas.
 *
 * Wanted: kff from the speed of a leg at full opening, and from the amplitudes that the configured
 * tests then reach; the largest kp with which, with ki of
 * TUNE_INTEGRAL of the bandwidth and some kpf, every mode in every pose keeps a gain margin of
 * TUNE_GAIN_DB, a phase margin of TUNE_PHASE_DEG at the valve command and stable poles, the slowest
 * mode of the oil a damping of TUNE_DAMPING wherever the platform is driven, and the sensors'
 * noise does not shake it. Ordinary threads; heap. */
#ifndef HEXID_LOOP_TUNE_H
#define HEXID_LOOP_TUNE_H

#include "loop_margin.h"
#include "loop_places.h"
#include "params/control.h"

#define TUNE_GAIN_DB 6.0
#define TUNE_PHASE_DEG 45.0
#define TUNE_DAMPING 0.3
/* ki / (kp bandwidth): the integral part takes 3 degrees of phase where position's gain is 1 */
#define TUNE_INTEGRAL 0.05
/* largest bandwidth kp / kff as a share of the slowest oil mode's frequency: nearer to it the loop
 * stands or falls with that mode's damping, which is known worst of all */
#define TUNE_BANDWIDTH (1.0 / 3.0)
/* share of limits.following_m that a leg may be off because kff suits the mean of both
 * directions */
#define TUNE_FOLLOWING 0.7

/* One margin, in the pose and the mode in which it is least. */
struct loop_least {
    double value, hz;
    enum dof dof;                /* axis that moves most in the mode */
    double pose[DOFS];
};

/* How a controller does on this machine. */
struct loop_standing {
    bool stable;                 /* in every pose */
    struct loop_least gain_db;   /* gain margin, up or down, at the valve command */
    struct loop_least phase_deg, delay_s;
    struct loop_least damping;   /* of the slowest mode, at neutral and on the way down to
                                  * parking */
    double noise_mps2, noise_most_mps2;   /* shaking by the sensors' noise, and what is borne */
    struct loop_least amplitude; /* largest error of a mode's amplitude, relative to its reference,
                                  * at the configured tests' frequencies, at neutral */
    double following_m;          /* error at the fastest motion by the speeds of both directions */
    struct loop_mode_standing {  /* modes by ascending frequency, at neutral */
        enum dof dof;
        double oil_hz, oil_damping;       /* without a controller */
        double hz, damping;               /* least damped pair of poles with it; NaN: none */
        double bandwidth_hz;
        struct loop_least gain_db, phase_deg; /* of all poses */
    } mode[DOFS];
};

/* Part of the machine that keeps the loop from what is wanted. */
enum loop_part { LOOP_PART_NONE, LOOP_PART_VALVE, LOOP_PART_CYCLE, LOOP_PART_OIL, LOOP_PARTS };

struct loop_tune {
    struct control_params now, gains;     /* configured, and found; limits and tf are the same */
    struct loop_standing before, after;
    double out_mps, in_mps;      /* mean speeds of a leg at full opening, at neutral */
    double damping_wanted;       /* least damping of the slowest mode that was asked for:
                                  * TUNE_DAMPING, or the largest that some gains reach */
    bool reached;                /* the found gains reach all that is wanted */
    enum loop_part limit;        /* part with which most would be gained; none: reached, not asked,
                                  * or no part alone helps */
    double part_damping[LOOP_PARTS]; /* damping of the slowest mode that is reached with the valve
                                      * or the cycle and its delay four times as fast, or oil twice
                                      * as stiff; 0: not asked */
};

/* Finds gains. bus: the machine is on a field bus. parts: look for the limiting part, which takes
 * as long again for each. Returns -2 if the supply cannot hold the platform up at neutral, or a
 * delay exceeds LOOP_DELAY_MOST cycles; -3 without memory. */
int loop_tune(const struct params *params, bool bus, bool parts, struct loop_tune *result, struct error *error);

/* The same with the machine as a survey found it, at neutral, in place of the configured one:
 * payload, friction, oil, valves, and delays, a bus's among them. The survey must be determined. */
struct loop_survey;
int loop_tune_surveyed(const struct params *params, const struct loop_survey *survey, struct loop_tune *result, struct error *error);

/* Finds how the configured gains stand, without looking for others. Errors as loop_tune(). */
int loop_tune_stand(const struct params *params, bool bus, struct loop_standing *standing, struct error *error);

/* Upper bound of a leg's speed in the moves and in the configured tests, m/s. */
double loop_fastest_mps(const struct params *params);

/* Axis and value of the pose as text: "z 0.45 m"; "neutral". */
enum { LOOP_POSE_SIZE = 40 };
void loop_pose_text(const double pose[DOFS], char text[LOOP_POSE_SIZE]);

#endif
