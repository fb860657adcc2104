/* Gains of the controller that may be changed while it runs, and the limits of one change. SAFETY:
 * one change multiplies or divides a gain by at most 1.4, which is 3 dB, half of a gain margin of 6
 * dB. So neither a typing error, nor a client that does not check stability, changes the controller
 * much at once. A gain of 0 stays 0, and no gain becomes 0. Before the client asks for a change, it
 * computes whether the loop is stable with the new gains (src/cli/command_set.h). Pure, RT. */
#ifndef HEXID_GAINS_H
#define HEXID_GAINS_H

#include "params/control.h"
#include "types.h"

enum { GAIN_KP, GAIN_KI, GAIN_KD, GAIN_KFF, GAIN_KPF };

#define GAINS_FACTOR 1.4 /* largest factor of one change: 3 dB, half of a gain margin of 6 dB */
#define GAINS_REST_S 1.0 /* shortest time between two changes */

/* Configuration keys of the gains, and the largest permitted value of each, the same as in
 * src/io/config_keys.c. */
extern const char *const gain_keys[LOOP_GAINS];
extern const double gain_most[LOOP_GAINS];

struct gains gains_of(const struct control_params *control);
void gains_apply(const struct gains *gains, struct control_params *control);
bool gains_equal(const struct gains *a, const struct gains *b);

/* Returns the index GAIN_... of the first gain whose change from `from` to `to` is refused, because
 * of its range or its factor; LOOP_GAINS if none is refused. NaN is refused. */
int gains_refused(const struct gains *from, const struct gains *to);

#endif
