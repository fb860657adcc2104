/* SAFETY: an unstable loop shakes the platform harder and harder, and every reading of it is
 * plausible. This monitor compares two estimates of the platform's acceleration with what the
 * reference asks for. Pure, RT: no heap, some 300 floating-point operations a cycle.
 *
 *   measured   second difference of the pose over twice 16 ms; it sees up to some 40 Hz. Steps and
 *              white noise of the readings are taken off: they make a second difference over one
 *              cycle, which a motion below 40 Hz does not.
 *   commanded  rate of change of the legs' speeds that the valve commands stand for (speed at
 *              full opening times command, through the valve's own lag), carried to the platform.
 *              It sees from there up to half the loop's rate, where lengths of 50 um show nothing.
 *              White noise is taken off by the fourth difference.
 *   asked      the same second difference of the reference, over 16 ms and over one cycle.
 *
 * All three are norms of the origin's acceleration and arm_m times the angular one, m/s^2, rms
 * over blocks of 50 ms. It is an oscillation when in four of the last five blocks, a quarter of
 * a second, one of the first two is more than 1.8 times what was asked for in that time, plus
 * limits.oscillation_mps2. A jolt fills two blocks at most.
 *
 * Neither estimate knows the masses: near a resonance the platform does up to three times what
 * the command stands for, and far above it much less. docs/safety.md has the figures. */
#ifndef HEXID_OSCILLATION_H
#define HEXID_OSCILLATION_H

#include "kinematics.h"

enum {
    OSCILLATION_PAST = 2 * 160 + 1, /* poses: 16 ms, twice, of a loop of 10 kHz */
    OSCILLATION_BLOCKS = 5,
};

/* Mean squares over a block, (m/s^2)^2. */
struct oscillation_block {
    double measured, commanded;
    double white;            /* of `commanded`, if its fourth difference were noise */
    double asked_measured, asked_commanded; /* seen as each of the two sees it */
    double leg[LEGS];        /* of the legs' own commanded accelerations */
};

struct oscillation {
    /* constants of a configuration */
    double limit_mps2, period_s;
    double arm_m;            /* what an angle moves */
    double to_platform[LEGS][DOFS]; /* rate of a leg -> of the platform, angles times arm_m */
    double speed_mps[LEGS];  /* of a leg at full opening, half the supply on each port */
    double follows;          /* of the way to its command that a valve goes in a cycle, twice in
                              * a row */
    double white;            /* mean square of an acceleration from white commands, over that of
                              * their fourth difference, 1/s^2 */
    int lag, every;          /* cycles: 16 ms; a block */
    int past;                /* poses that are kept: 2 lag + 1 */
    /* since driving began */
    double pose[OSCILLATION_PAST][DOFS], ref[OSCILLATION_PAST][DOFS];
    double asked_mps[LEGS][5];              /* speeds that the commands stand for, newest first */
    double half_mps[LEGS], valve_mps[LEGS]; /* behind the valve's two lags */
    int newest, in_block;    /* place of the newest pose; cycles of the block so far */
    struct oscillation_block sum, block[OSCILLATION_BLOCKS]; /* newest first */
    /* of the worse estimate after the last block */
    double found_mps2, allowed_mps2;
    uint32_t legs;           /* fault_leg() of those whose valves swing most; 0: none oscillates */
};

/* k must hold the platform at neutral (kinematics_init). */
void oscillation_init(struct oscillation *o, const struct params *params, const struct kinematics *k);

/* Starts anew when driving begins, at rest in this pose. */
void oscillation_reset(struct oscillation *o, const double pose[DOFS]);

/* Adds a cycle whose sample was believed: its pose, the reference at the same instant and the
 * command that follows. Other cycles are left out of all three alike. Returns true if the
 * platform oscillates, judged by the complete blocks. */
bool oscillation_step(struct oscillation *o, const double pose[DOFS], const double ref[DOFS], const double valve[LEGS]);

#endif
