/* The controller of a leg, sampled with period dt; its command is held until the next sample
 * (docs/method.md section 5).
 *
 *     e     = Lref - L
 *     I    += Ki e dt, clamped to +-integral_limit; unchanged while the output is saturated and e
 *          would drive it further (anti-windup)
 *     d    += dt/(Tf+dt) ((e - e_prev)/dt - d)                            filtered derivative
 *     flp  += dt/(Tp+dt) (f - flp)                                        low-passed leg force
 *     u     = Kp e + I + Kd d + Kff (Lref - Lref_prev)/dt - s Kpf (f - flp), clamped
 *           to +-output_limit
 *
 * The order is as given: I, d and flp are updated before u is computed. f = A1 P1 - A2 P2 in
 * newton, L in metres, u -1..1; s = 1 except near the ends of the stroke (1 - oil_feedback_cut()).
 * RT, pure. */
#ifndef HEXID_PID_H
#define HEXID_PID_H

#include <stdbool.h>

struct control_params;

struct pid {
    double integral;       /* integral part I of the output, as a share of full opening */
    double derivative_mps; /* filtered rate d of the error, for the derivative part */
    double force_lp_n;     /* low-passed leg force flp */
    double error_m;        /* error of the previous step, e_prev */
    double ref_m;          /* reference of the previous step, Lref_prev */
    double feedback_cut;   /* 1 - s; the caller sets it before each step, pid_reset() sets it to
                            * 0 */
    double output;         /* output u of the last step */
    bool saturated;        /* the last output u, or the command that the law `model` computed from
                            * it, was clamped */
};

/* Starts without a bump: no error, no reference rate, force filter settled. If the first step has
 * Lref = L = length_m and f = force_n, its output is 0. */
void pid_reset(struct pid *c, double length_m, double force_n);

double pid_step(struct pid *c, const struct control_params *g, double dt_s, double ref_m, double length_m, double force_n);

/* Does what pid_step() does, with this feed-forward in place of Kff (Lref - Lref_prev)/dt. */
double pid_step_forward(struct pid *c, const struct control_params *g, double dt_s, double ref_m, double length_m, double force_n,
                        double forward);

/* Readings of a leg whose reference rests. */
struct pid_reading {
    double length_m, force_n;
    double ref_force_n; /* part of the leg force above the force filter's low-pass that the
                         * reference itself needs; kpf feeds back only the difference from it. 0
                         * with the law `pid` */
};

/* Prepares a bumpless change of gains while the reference rests: sets the integral so that the next
 * step with the gains `to` and this reading has the output that the gains `from` would give.
 * Returns false, and changes nothing, if the integral would exceed its limit. */
bool pid_change(struct pid *c, const struct control_params *from, const struct control_params *to, double dt_s,
                const struct pid_reading *reading);

/* Replaces pid_step() in a cycle without a trusted sample. The caller holds the last u. Lref_prev
 * becomes this reference, so that the next step does not contain the reference motion of several
 * cycles. */
void pid_hold(struct pid *c, double ref_m);

#endif
