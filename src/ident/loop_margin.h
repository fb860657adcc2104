/* Gain and phase margins of the loops of the leg modes, opened at the valve commands, through which
 * kp, ki, kd and kpf all act. So the margins are also the errors that the loop tolerates in the
 * gain and delay of all valves together. The margins have a meaning only for a stable loop
 * (loop_poles.h finds whether it is). Ordinary threads, no heap. */
#ifndef HEXID_LOOP_MARGIN_H
#define HEXID_LOOP_MARGIN_H

#include "loop_poles.h"

struct control_params;

struct loop_margin {
    double gain_db, gain_hz;     /* increase of the gain that makes the loop oscillate, and
                                  * frequency of the oscillation; inf: no increase does */
    double drop_db;              /* decrease of the gain that makes the loop oscillate; inf: no
                                  * decrease does */
    double phase_deg, phase_hz;  /* least distance of the phase from -180 degrees where the gain is
                                  * 1; inf: the gain is 1 nowhere */
    double delay_s, delay_hz;    /* additional delay that makes the loop oscillate, and the
                                  * frequency at which it does; inf: the gain never is 1 */
    double bandwidth_hz;         /* highest frequency at which the gain of the position loop is 1,
                                  * with the force loop closed; 0: it is 1 nowhere */
};

/* Complex amplitude of a mode's length relative to its reference, at the frequency of `plant` that
 * is nearest to radps. It includes the feed-forward kff of the reference's rate. */
double complex loop_follow(const struct loop_plant *plant, const struct control_params *control, double radps, double dt_s);

/* Returns the margins of one mode, alone. */
struct loop_margin loop_margin(const struct loop_plant *plant, const struct control_params *control, double dt_s);

/* Finds the margins of six modes that the weights `mix` (loop_model.h) connect: those of the six
 * eigenvalues of the loop's gain matrix. Each eigenvalue is assigned to the mode to which it
 * belongs at the lowest frequency, a thousandth of the fastest mode's frequency. The bandwidths are
 * those of the modes alone. If the weights connect no modes, the margins are those of
 * loop_margin(). Returns how many more unstable poles the connected modes have than the modes alone
 * (Nyquist: from the encirclements by det(1 + gain), less those of the modes alone). If the
 * eigenvalues cannot be computed, returns DOFS, with gain_db, phase_deg and delay_s 0. */
int loop_margins(const struct loop_plant plant[DOFS], const double mix[DOFS][DOFS], const struct control_params *control, double dt_s,
                 struct loop_margin margin[DOFS]);

#endif
