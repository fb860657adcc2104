/* SAFETY: an unstable loop shakes the platform more and more, while every single reading is
 * plausible. This monitor compares estimates of the platform's acceleration with the acceleration
 * that the reference requests. Pure, RT: no heap, some 300 floating-point operations a cycle, 800
 * with a dead band.
 *
 *   measured   second difference of the pose with a step of 16 ms; shows motion up to some 40 Hz.
 *              Steps and white noise of the readings are subtracted; their size follows from a
 *              second difference over one cycle, in which a motion below 40 Hz does not show.
 *   commanded  rate of change of the leg speeds that correspond to the valve commands (speed at
 *              full opening times command, through the valve's lag), converted to the platform.
 *              Shows motion from some 40 Hz up to half the loop's rate, where lengths in steps of
 *              50 um show none. White noise is subtracted by means of the fourth difference.
 *   opened     like commanded, but from the valves' openings, which are the commands less the
 *              configured null and dead band.
 *   forced     acceleration by the legs' forces above 3 Hz, computed with the inertia of the
 *              configured bodies. White noise is subtracted as for commanded. The forces include
 *              dry friction. The estimate is too small if the payload is configured too heavy, or
 *              the pressure sensors are slow.
 *   requested  second difference of the reference, with a step of 16 ms (for measured) and of one
 *              cycle (for the others).
 *
 * Each estimate is the norm of the origin's acceleration and of arm_m times the angular
 * acceleration, m/s^2, rms over blocks of 50 ms. The limit is limits.oscillation_mps2 plus
 * OSCILLATION_ASKED times `requested` at the same time. The motion is an oscillation if in four of
 * the last five blocks, which last a quarter of a second,
 *
 *   - measured exceeds the limit, or
 *   - opened exceeds the limit, or
 *   - commanded exceeds the limit, and forced exceeds the limit by more than
 *     limits.oscillation_mps2.
 *
 * A single jolt fills two blocks at most. The third condition is checked only if the law `model`
 * drives valves with a configured dead band. Otherwise `opened` is computed without a dead band,
 * and commanded and forced are not computed. The commands of the law `model` jump through the dead
 * band, and these jumps move nothing; but if the real valve has no dead band, they shake the
 * platform, and the forces show that. If a pressure is no valid reading, or the inertia is unknown,
 * forced counts as infinite, so that commanded decides alone.
 *
 * `commanded` and `opened` do not depend on the masses: near a resonance the platform moves up to
 * three times as much as these estimates, and far above the resonance much less. docs/safety.md has
 * the figures. */
#ifndef HEXID_OSCILLATION_H
#define HEXID_OSCILLATION_H

#include "kinematics.h"
#include "valve_flow.h"

/* Factor of the requested acceleration in the limit. A stable loop that follows its reference badly
 * reaches 1.5 times the requested acceleration. */
#define OSCILLATION_ASKED 1.8

enum {
    OSCILLATION_PAST = 2 * 160 + 1, /* number of poses in 32 ms (two lags) of a loop of 10 kHz */
    OSCILLATION_BLOCKS = 5,
};

/* Mean squares of accelerations over a block, (m/s^2)^2; in `leg`, sums of squares. */
struct oscillation_block {
    double measured, commanded, opened, forced; /* `forced` is infinite if pressures are not valid,
                                                 * or the inertia is unknown */
    /* white noise in commanded, opened and forced, as if their fourth differences were white noise
     * alone */
    double white, opened_white, forced_white;
    double asked_measured, asked_commanded; /* acceleration of the reference, from second
                                             * differences with steps of 16 ms and of one cycle */
    double leg[LEGS];        /* sum of squares of each leg's own acceleration by its opening, and by
                              * its command if `commanded` is computed */
};

struct oscillation {
    /* the members up to `past` are constant for a configuration */
    double limit_mps2, period_s;
    double arm_m;            /* kinematics.arm_m, which converts angles to lengths */
    double to_platform[LEGS][DOFS]; /* converts leg rates to rates of the platform, with angles
                                     * multiplied by arm_m */
    double push[LEGS][DOFS]; /* acceleration of the platform per leg force, with angles multiplied
                              * by arm_m, 1/kg */
    double slower;           /* coefficient of the forces' low-pass: each cycle adds slower * (force
                              * - slow_n) to slow_n */
    bool weighs;             /* false: `push` is unknown, because the inertia could not be
                              * computed */
    bool jumps;              /* `commanded` and `forced` are computed, because the law `model` jumps
                              * through a configured dead band */
    struct valve_flow valve[LEGS]; /* valves as configured, of which null and dead band are used */
    double speed_mps[LEGS];  /* speed of each leg at full opening, if half the supply pressure drops
                              * at each port */
    double follows;          /* coefficient of both first-order lags of a valve: each cycle adds
                              * follows * (input - output) to a lag's output */
    double white;            /* ratio for white noise: mean square of a leg's acceleration over mean
                              * square of the fourth difference of its commanded speed, 1/s^2 */
    int lag, every;          /* number of cycles in 16 ms, and in a block */
    int past;                /* number of poses kept: 2 lag + 1 */
    /* the members below are collected while the valves are driven */
    double pose[OSCILLATION_PAST][DOFS], ref[OSCILLATION_PAST][DOFS];
    /* Leg speeds that correspond to the commands (commanded) and to the openings (opened).
     * asked_mps: last five, newest first. half_mps, valve_mps: newest one after the valve's first
     * and after its second lag. */
    struct oscillation_valves {
        double asked_mps[LEGS][5], half_mps[LEGS], valve_mps[LEGS];
    } commanded, opened;
    double slow_n[LEGS], forced_mps2[DOFS][5]; /* slow_n: part of the forces below 3 Hz.
                                                * forced_mps2: acceleration by the part above 3 Hz,
                                                * last five, newest first */
    bool knows_force;        /* slow_n has a value */
    int newest, in_block;   /* index of the newest pose; number of cycles in the current block so
                             * far */
    struct oscillation_block sum, block[OSCILLATION_BLOCKS]; /* sums of the current block; complete
                                                              * blocks, newest first */
    /* after the last block: rms acceleration of the estimate that exceeds its limit most (or comes
     * nearest to it), and that limit */
    double found_mps2, allowed_mps2;
    uint32_t legs;          /* fault_leg() bits of the legs whose commands oscillate most; 0: no
                             * oscillation was found */
};

/* Initialises the monitor. k must come from kinematics_init(), so that it is regular at neutral. */
void oscillation_init(struct oscillation *o, const struct params *params, const struct kinematics *k);

/* Restarts the monitor when driving begins, at rest in this pose. */
void oscillation_reset(struct oscillation *o, const double pose[DOFS]);

/* Adds a cycle: the pose of a trusted sample, the reference at the same time, the command computed
 * from them, and the legs' forces (NULL if the sample's pressures are not trusted). The caller
 * leaves out cycles without a trusted sample. Returns true if the platform oscillates, as judged
 * after the last complete block. */
bool oscillation_step(struct oscillation *o, const double pose[DOFS], const double ref[DOFS], const double valve[LEGS],
                      const double force_n[LEGS]);

#endif
