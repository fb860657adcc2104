/* Method C: inertia, viscous and dry friction in one estimate, from leg forces and any motion near
 * neutral. It goes beyond Tian 2015, which leaves dry friction to a symmetry rule.
 *
 * Along leg i, with J the Jacobian at the pose of each instant and v_i the leg's rate:
 *
 *   A1 P1 - A2 P2 = [J'^-1 (Mt xddot + K x + rest)]_i + b_i v_i + (e_i if v_i > 0, -r_i if v_i < 0)
 *
 * Unknown are the 21 entries of a symmetric Mt at neutral, and of each leg viscous friction b and
 * dry friction e (extending) and r (retracting). A constant error of the force is in e and r, with
 * opposite signs. K are springs on the coordinates of the pose, hoses and cables, where
 * model.tolerance allows any: with a prior as wide as it says, since at one frequency they are an
 * inertia of -K / w^2. `rest` is what is small near neutral and taken from the
 * configured bodies: velocity terms, how Mt changes with the pose, the legs' weight. A payload that
 * is not as configured weighs otherwise, too; its weight is part of the entries' columns, so the
 * stiffness that weight makes is not taken for inertia, as method A does. Effects in the
 * configuration are left out. The ripple that held commands leave in samples in step with them is
 * subtracted (residual_staircase).
 *
 * Dry friction that depends on speed (Stribeck, six shapes), on the pressures, or on a seal that
 * deforms before it slides (presliding: Dahl's law, by 20, 40, .. 320 um, and how it depends on
 * speed) is fitted beside it (friction_course.h), with a prior of mean zero whose width comes from
 * the data (shape_sizes.h).
 *
 * Both sides are rows of coefficients (residual.h): harmonics of a steady test, local cosines of
 * any other motion. They are linear in the unknowns; generalised least squares with the sensors'
 * covariance, that of a length through the acceleration, is maximum likelihood to first order. Near
 * a reversal, where a leg may stick, its friction is on its way from -r to e by whatever course:
 * the variance of that is in the covariance, and no law of friction is assumed there. It needs the
 * friction's size, hence several passes.
 *
 * A standard deviation has three parts: the sensors' noise, enlarged where the rows scatter by
 * more; joints that are off by model.tolerance.joints_m (uniform, each coordinate); and how far the
 * accelerations' noise draws the entries to zero (equations.h). An entry whose deviation is above a
 * fifth of sqrt(M_ii M_jj) is not determined: NaN; so is friction whose deviation, that of viscous
 * friction times the legs' rms speed, is above a tenth of the rms of the varying force in the leg
 * where it is largest; so is a spring whose deviation is above a half of its prior's. Ordinary
 * threads; heap. */
#ifndef HEXID_METHOD_C_H
#define HEXID_METHOD_C_H

#include "equations.h"
#include "methods.h"
#include "payload.h"
#include "recording.h"

/* The matrix elsewhere than at neutral, from the payload found and the legs as configured. */
struct matrix_at_pose {
    bool asked, determined;                      /* determined: all ten parameters of the payload
                                                  * are */
    double pose[DOFS], mt[DOFS][DOFS];
};

struct method_c {
    /* symmetric; an entry that these data do not determine is NaN; damping is below. The condition
     * number is the normal matrix's, entries in units of sqrt(M_ii M_jj), friction eliminated */
    struct method_result matrix;
    double viscous[LEGS], viscous_std[LEGS];     /* N s/m */
    double dry[LEGS][2], dry_std[LEGS][2];       /* N, extending and retracting */
    bool springs;                                /* model.tolerance allows some */
    double spring[DOFS], spring_std[DOFS];       /* N/m, N m/rad */
    struct payload payload;
    struct matrix_at_pose at_pose;
    double scatter;                              /* rms of the rows over their noise: about 1 where
                                                  * the model holds, less with dry friction */
};

/* From a checked recording of a platform (recording_check). -2: no pose has these lengths, or a leg
 * does not move; -3: memory. */
int method_c_equations(const struct recording *recording, struct equations *equations, struct error *error);

/* Refuses data that recording_check() passes and method C cannot use: -2, with the leg and the
 * remedy, where a valve's command is at its limit for a good part of a test. The motion is then the
 * limit's doing, and much the same whatever was asked. */
int method_c_check(const struct recording *recording, struct error *error);

/* Solves one recording's equations, or the sum of those of several recordings of one machine.
 * `result` has what is determined, `estimate` all of it. -2 as above, or no entry is determined. */
int method_c_solve(const struct equations *equations, const struct params *configured, struct estimate *estimate, struct method_c *result,
                   struct error *error);

/* method_c_equations() and method_c_solve() of one checked recording. -3 also without memory. */
int method_c(const struct recording *recording, struct method_c *result, struct error *error);

/* Fills at_pose. -2: a leg's stroke does not reach the pose. */
int method_c_at_pose(struct method_c *m, const struct params *params, const double pose[DOFS], struct error *error);

/* Entries, viscous and dry friction and springs by their place in the equations, below
 * UNKNOWN_SHAPE; NaN: not determined. */
double method_c_value(const struct method_c *m, int unknown, double *std);

#endif
