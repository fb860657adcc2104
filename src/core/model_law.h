/* The control law `model`: feed-forward through the machine's own dynamics and flow equations, and
 * the leg controller of pid.h for deviations from the feed-forward (docs/control.md).
 *
 * The reference is known ahead of time, and with it the force and the length of each leg at the
 * beginning t1 and at the end t2 of the time in which this cycle's command acts. Their differences
 * give the mean rates of force and length. For these two rates valve_flow.h gives the opening o, at
 * pressures that are predicted from the measured ones for the middle of that time:
 *
 *     t1 = now + delay, t2 = t1 + dt            delay: of spool and command, mean of all legs
 *     f(t)  = force by dynamics.h + friction(L', L'')
 *     o     = opening for f' = (f(t2) - f(t1)) / dt at L' = (L(t2) - L(t1)) / dt
 *     u     = Kp e + I + Kd d + o - s Kpf [(f - flp) - (fr - frlp)]
 *
 * where fr = f(now) is the reference force, frlp is fr behind the same low-pass as flp, and s is
 * that of pid.h. The command is valve_flow_command() of u, clamped to +-output_limit. Dry friction
 * F enters the reference force as F tanh(L' / (v0 + tau |L''|)): its reversal takes about 4 tau,
 * and it is 0 for a leg at rest.
 *
 * Doubts: if a pressure is no valid reading, a pose is singular or not finite, or a command beyond
 * +-output_limit is needed (the supply is too low), the law hands over to the PID in that cycle
 * without a bump: the difference of the two feed-forwards decays with the time constant FADE_S.
 * Once all inputs have been good for a second, the law takes over again gradually, in the time
 * RETURN_S (both in model_law.c). SAFETY: the supervisor's limits and the limit of the output apply
 * to either law. RT, no heap, pure. */
#ifndef HEXID_MODEL_LAW_H
#define HEXID_MODEL_LAW_H

#include "dynamics.h"
#include "effect.h"
#include "force.h"
#include "params/control.h"
#include "pid.h"
#include "reference.h"
#include "valve_flow.h"

/* Reasons why the law hands over to the PID, a bit each. */
enum {
    DOUBT_PRESSURE = 1u << 0, /* a pressure is no valid reading */
    DOUBT_SUPPLY = 1u << 1,   /* the command for the feed-forward's opening is beyond
                               * +-output_limit */
    DOUBT_SINGULAR = 1u << 2, /* the legs do not determine the platform, or a number is not
                               * finite */
    DOUBTS = 3,
};

enum { MODEL_DELAY_CYCLES = 32 }; /* longest delay from sample to spool, in cycles */

struct model_law {
    const struct params *params;
    struct dynamics dynamics;
    struct valve_flow valve[LEGS];
    struct {
        int count;
        struct {
            const struct effect *effect;
            const struct effect_values *values;
        } of[EFFECTS_MAX];
    } friction;              /* effects that are on and add friction along the legs */
    double delay_s;          /* delay from the sample to the spool's motion, mean of all legs */
    int delay_cycles;        /* delay_s, rounded up to whole cycles */
    double area_m2[2][LEGS]; /* piston areas, rodless and rod side */
    /* the members below are the law's state */
    double p1_pa[LEGS], p2_pa[LEGS];      /* last trusted pressures */
    double force_ref_lp_n[LEGS];          /* low-passed reference force frlp */
    double excess_lp_n[LEGS];             /* measured less reference force, low-passed like flp */
    double varying_ref_n[LEGS];           /* reference force fr less its low-passed value frlp */
    bool settled[LEGS];                   /* the low-passes of this leg have started since
                                           * model_law_reset() */
    double bump[LEGS];                    /* rest, not yet decayed, of the jumps of the feed-forward
                                           * at hand-overs */
    double opening[LEGS];                 /* last valid opening o */
    double sent[LEGS][MODEL_DELAY_CYCLES]; /* openings u of the last cycles, a ring buffer */
    int newest;              /* index of the newest element of `sent` */
    double share;            /* share of this law in the feed-forward; the remaining share is the
                              * PID's */
    double handed_over;      /* share of the feed-forward that passed to the PID in this cycle */
    double good_s;           /* time since the last doubt */
    uint32_t doubts;         /* DOUBT_... that have come up since the law last had the full share */
};

/* Prepares the law; params and kinematics must outlive it. Returns -2 if params choose this law and
 * the delay is longer than MODEL_DELAY_CYCLES. */
int model_law_init(struct model_law *law, const struct params *params, const struct kinematics *k, struct error *error);

/* Restarts the law: the PID drives first, and the law takes over from it in the time RETURN_S
 * (model_law.c). */
void model_law_reset(struct model_law *law);

/* Inputs of a cycle. */
struct model_law_input {
    const struct reference *reference; /* reference after reference_step() of this cycle */
    const double *p1_pa, *p2_pa;       /* measured pressures of the legs */
    uint32_t suspect;                  /* fault_leg() of legs whose pressures are no valid
                                        * readings */
};

/* Computes openings and reference forces for this cycle. */
void model_law_step(struct model_law *law, const struct model_law_input *in);

/* Replaces model_law_step() and model_law_command() in a cycle without a trusted sample, in which
 * the commands stay the same. */
void model_law_hold(struct model_law *law);

/* Computes a leg's command with these gains, after model_law_step(); takes the place of
 * pid_step(). */
double model_law_command(struct model_law *law, const struct control_params *gains, int leg, struct pid *pid, double ref_m, double length_m,
                         double force_n);

/* Returns a description of the first of these doubts; "none" for 0. */
const char *model_law_doubt(uint32_t doubts);

#endif
