/* Method C: inertia, viscous and dry friction in one estimate, from leg forces and the measured motion. Goes beyond Tian 2015, which leaves dry
 * friction to a symmetry rule.
 *
 * Along leg i, with J the Jacobian at the pose of each instant:
 *
 *   A1 P1 - A2 P2 = [J'^-1 (Mt xddot + rest)]_i + b_i v_i + (e_i where v_i > 0, -r_i where v_i < 0)
 *
 * Unknown: the 21 entries of a symmetric Mt at neutral, and of each leg viscous friction b and dry friction e (extending) and r (retracting); a
 * constant that the force has too much is in both, with opposite signs. What Mt has beyond the configured machine weighs, too: the payload's
 * mass and moments m c, by which nothing need be known of the payload. rest: velocity terms, how Mt changes with the pose, and the weight of
 * the legs, all small, of the configured bodies; so the stiffness that weight makes is no inertia here, as it is to method A. What the
 * commands' staircase does to samples in step with it (residual_staircase) is taken off. Effects that the configuration has are left out; and
 * the difference to the configured payload is taken as it is at neutral, so the motion has to stay near it.
 *
 * Dry friction may depend on speed (Stribeck, two shapes) and on the pressures: such terms are fitted beside it, drawn to zero as strongly as
 * if they were of its size. Without dry friction they are nothing, and cost nothing.
 *
 * Both sides are rows of coefficients (residual.h), harmonics of a steady test or local cosines of any other motion: linear in the unknowns, and
 * generalised least squares with the sensors' covariance, that of a length through the acceleration, is maximum likelihood to first order. Where a leg may
 * stick, near a reversal, its friction is anything between -r and e: its variance there is in the covariance, and no law of friction is
 * asked. Hence more passes than one, with the friction that the pass before found.
 *
 * std has what the sensors' noise leaves, enlarged where the rows scatter by more than that, and what joints that are off by model.tolerance.joints_m
 * (uniform, each coordinate for itself) do to the result; an entry whose
 * deviation is above a fifth of sqrt(M_ii M_jj) is NaN. Ordinary threads; heap. */
#ifndef HEXID_METHOD_C_H
#define HEXID_METHOD_C_H

#include "methods.h"
#include "payload.h"
#include "recording.h"

struct method_c {
    struct method_result matrix;                 /* symmetric; an entry that these data do not determine is NaN; damping is below */
    double viscous[LEGS], viscous_std[LEGS];     /* N s/m */
    double dry[LEGS][2], dry_std[LEGS][2];       /* N, extending and retracting */
    struct payload payload;
    double scatter;                              /* of the rows, in units of the noise they should have: about 1 where the model holds, less with dry friction */
};

/* Of a checked recording of a platform (recording_check). -2: no pose has these lengths, or nothing is determined; -3: memory. */
int method_c(const struct recording *recording, struct method_c *result, struct error *error);

#endif
