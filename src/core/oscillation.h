/* SAFETY: an unstable loop shakes the platform more and more, while every single reading is
 * plausible. This monitor compares estimates of the platform's acceleration with the requested one.
 * Pure, RT: no heap, some 300 floating-point operations a cycle, 800 with a
 * dead band.
 *
 *   measured   second difference of the pose over twice 16 ms; sees up to some 40 Hz. Steps and
 *              white noise of the readings are subtracted: they show in a second difference over
 *              one cycle, in which a motion below 40 Hz does not show.
 *   commanded  rate of change of the leg speeds that correspond to the valve commands (speed at
 *              full opening times command, through the valve's lag), converted to the platform.
 *              Sees from some 40 Hz up to half the loop's rate, where lengths in steps of 50 um
 *              show nothing. White noise is subtracted by means of the fourth difference.
 *   opened     the same of the valves' openings: commands less the configured null and dead band.
 *   forced     the legs' forces above 3 Hz, through the inertia of the configured bodies; white
 *              noise is subtracted likewise. Dry friction is in it. A payload that is configured
 *              too heavy, and slow pressure sensors, make it smaller.
 *   requested  the same second difference of the reference, over 16 ms and over one cycle.
 *
 * All are norms of the origin's acceleration and arm_m times the angular one, m/s^2, rms over
 * blocks of 50 ms. The limit is OSCILLATION_ASKED times the requested one of the same time plus
 * limits.oscillation_mps2. The motion is an oscillation if in four of the last five blocks, a
 * quarter of a second,
 *
 *   - measured exceeds the limit, or
 *   - opened exceeds it, or
 *   - commanded exceeds it, and forced does so by limits.oscillation_mps2.
 *
 * A jolt fills two blocks at most. The last line holds only if the law `model` drives valves with a
 * configured dead band; otherwise `opened` is of the whole command, and neither commanded nor
 * forced is computed. The commands of that law jump through the dead band, which moves nothing; but
 * if the real valve has no dead band, the jumps shake the platform, and the forces show it. If a
 * pressure is no valid reading, or the inertia is unknown, forced counts as infinite: the commands
 * then decide alone.
 *
 * The commands' estimates do not know the masses: near a resonance the platform moves up to three
 * times as much as the command corresponds to, and far above it much less. docs/safety.md has the
 * figures. */
#ifndef HEXID_OSCILLATION_H
#define HEXID_OSCILLATION_H

#include "kinematics.h"
#include "valve_flow.h"

/* An acceleration counts as an oscillation if it exceeds this times the requested one by more than
 * limits.oscillation_mps2; a loop that follows badly reaches 1.5. */
#define OSCILLATION_ASKED 1.8

enum {
    OSCILLATION_PAST = 2 * 160 + 1, /* number of poses in 32 ms (two lags) of a loop of 10 kHz */
    OSCILLATION_BLOCKS = 5,
};

/* Mean squares of accelerations over a block, (m/s^2)^2; those of `leg` are sums. */
struct oscillation_block {
    double measured, commanded, opened, forced; /* forced: infinite without good pressures */
    /* noise parts of commanded, opened and forced, if their fourth differences were only noise */
    double white, opened_white, forced_white;
    double asked_measured, asked_commanded; /* acceleration of the reference, filtered as `measured`
                                             * and as `commanded` */
    double leg[LEGS];        /* each leg's own commanded acceleration */
};

struct oscillation {
    /* the group below is constant for a configuration */
    double limit_mps2, period_s;
    double arm_m;            /* kinematics.arm_m, which converts angles to lengths */
    double to_platform[LEGS][DOFS]; /* converts leg rates to rates of the platform, angles times
                                     * arm_m */
    double push[LEGS][DOFS]; /* acceleration of the platform per force of a leg, angles times
                              * arm_m, 1/kg */
    double slower;           /* share of the distance to its input that the slow force covers in a
                              * cycle */
    bool weighs;             /* false: `push` is not known */
    bool jumps;              /* the law `model` jumps through a configured dead band: `commanded`
                              * and `forced` are computed */
    struct valve_flow valve[LEGS]; /* configured valves, for null and dead band */
    double speed_mps[LEGS];  /* speed of each leg at full opening, with half the supply's pressure
                              * drop on each port */
    double follows;          /* share of the remaining distance to its input that each of a valve's
                              * two lags covers in a cycle */
    double white;            /* mean square of the acceleration from white commands, divided by that
                              * of their fourth difference, 1/s^2 */
    int lag, every;          /* number of cycles in 16 ms, and in a block */
    int past;                /* number of poses kept: 2 lag + 1 */
    /* the group below has been collected since driving began */
    double pose[OSCILLATION_PAST][DOFS], ref[OSCILLATION_PAST][DOFS];
    /* Leg speeds that correspond to the commands, and to the openings: newest first, and after the
     * valve's first and second lag. */
    struct oscillation_valves {
        double asked_mps[LEGS][5], half_mps[LEGS], valve_mps[LEGS];
    } commanded, opened;
    double slow_n[LEGS], forced_mps2[DOFS][5]; /* forces below 3 Hz; acceleration by the forces
                                                * above, newest first */
    bool knows_force;        /* slow_n has begun */
    int newest, in_block;   /* index of the newest pose, and number of cycles of the block so far */
    struct oscillation_block sum, block[OSCILLATION_BLOCKS]; /* sums of the current block; last
                                                              * blocks, newest first */
    /* rms acceleration of the worse estimate after the last block, and its limit then */
    double found_mps2, allowed_mps2;
    uint32_t legs;          /* fault_leg() bits of the legs whose valves swing most; 0: no
                             * oscillation was found */
};

/* Initialises the monitor. k must come from kinematics_init(), so that it is regular at neutral. */
void oscillation_init(struct oscillation *o, const struct params *params, const struct kinematics *k);

/* Restarts the monitor when driving begins, at rest in this pose. */
void oscillation_reset(struct oscillation *o, const double pose[DOFS]);

/* Adds a cycle with a trusted sample: its pose, the reference at the same time, the command that
 * follows, and the legs' forces (NULL: its pressures are not trusted). Cycles without a trusted
 * sample are left out. Returns true if the platform oscillates according to the complete blocks. */
bool oscillation_step(struct oscillation *o, const double pose[DOFS], const double ref[DOFS], const double valve[LEGS],
                      const double force_n[LEGS]);

#endif
