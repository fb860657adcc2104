/* Method C: inertia, viscous and dry friction in one estimate, from leg forces and any motion near
 * neutral. It goes beyond Tian 2015, which leaves dry friction to a symmetry rule.
 *
 * Along leg i, with J the Jacobian at the pose of each instant and v_i the leg's rate:
 *
 *   A1 P1 - A2 P2 = [J'^-1 (Mt xddot + K x + rest)]_i + b_i v_i + (e_i if v_i > 0, -r_i if v_i < 0)
 *
 * The unknowns are the 21 entries of a symmetric Mt at neutral, and for each leg viscous friction b
 * and dry friction e (extending) and r (retracting). A constant error of the force enters e and r
 * with opposite signs. K are springs on the coordinates of the pose (hoses and cables). They are
 * fitted only if model.tolerance allows any, with a prior of that width, because at a single
 * frequency they act like an inertia of -K / w^2. `rest` is small near neutral and computed from
 * the configured bodies: velocity terms, the change of Mt with the pose, the legs' weight. If the
 * payload differs from the configured one, the difference of its weight is part of the entries'
 * columns, so the stiffness that this weight causes is not mistaken for inertia, as it is in method
 * A. Effects in the configuration are left out. The ripple that held commands leave in synchronous
 * samples is subtracted (residual_staircase).
 *
 * Three kinds of dry friction are fitted beside the constants (friction_course.h): friction that
 * depends on speed (Stribeck, six basis functions), on the pressures, or on a seal that deforms
 * before it slides (presliding: Dahl's law with 20, 40, .. 320 um, and its dependence on speed).
 * Their prior has mean zero and a width that comes from the data (basis_sizes.h).
 *
 * Both sides are rows of coefficients (residual.h): harmonics of a steady test, local cosines of
 * any other motion. They are linear in the unknowns; generalised least squares with the sensors'
 * covariance, in which a length's noise enters through the acceleration, is maximum likelihood to
 * first order. Near a reversal, where a leg may stick, its friction goes from -r to e by an unknown
 * course. No friction law is assumed there: the covariance includes the variance of the course.
 * This variance depends on the size of friction, so several passes are made.
 *
 * The systematic errors of sensors and configured joint positions (systematic.h) are unknowns, too;
 * the skew of each test may depart from the common one (skews.h); and the payload counts as one
 * rigid body within model.tolerance.rigidity (payload_prior()). Noise that is in the columns as
 * well as in the right-hand side biases the estimate (attenuation); the mean of this bias is
 * subtracted. A standard deviation includes the sensors' noise, enlarged if the rows scatter by
 * more; the systematic errors and the legs' masses, as far as the data do not determine them; and
 * the uncertainty of the attenuation. A value is NaN if it is not determined: an entry whose
 * deviation exceeds a fifth of sqrt(M_ii M_jj); friction whose deviation (for viscous friction
 * times the legs' rms speed) exceeds a tenth of the rms of the varying force in the leg where it is
 * largest; a spring whose deviation exceeds half of its prior's. Ordinary threads; heap. */
#ifndef HEXID_METHOD_C_H
#define HEXID_METHOD_C_H

#include "equations.h"
#include "methods.h"
#include "payload.h"
#include "recording.h"

/* The matrix away from neutral, computed from the payload as found and the legs as configured. */
struct matrix_at_pose {
    /* determined: all ten parameters of the payload are determined */
    bool asked, determined;
    double pose[DOFS], mt[DOFS][DOFS];
};

/* A systematic error (systematic.h) as estimated: value, standard deviation, and standard deviation
 * of its stated prior; prior 0: there is no such error. */
struct systematic_found {
    double value, std, prior;
};

/* Causes of the uncertainty of an entry: the families of systematic errors, the legs' masses with
 * the payload's rigidity, attenuation, and noise. */
enum { CAUSE_LEGS = FAMILIES, CAUSE_ATTENUATION, CAUSE_NOISE, CAUSES };
const char *method_c_cause(int cause); /* name of a cause */

/* True if the data show a systematic error: zero is outside its 95 % interval. */
bool method_c_found(const struct systematic_found *error);

struct method_c {
    /* Symmetric. Entries that are not determined are NaN, and damping is in `viscous`. The
     * condition number is that of the normal matrix, entries in units of sqrt(M_ii M_jj), with
     * friction eliminated. */
    struct method_result matrix;
    double viscous[LEGS], viscous_std[LEGS];     /* viscous friction of each leg, N s/m */
    double dry[LEGS][2], dry_std[LEGS][2];       /* dry friction of each leg, N: extending, then
                                                  * retracting */
    bool springs;                                /* model.tolerance allows springs */
    double spring[DOFS], spring_std[DOFS];       /* springs on the coordinates of the pose, N/m and
                                                  * N m/rad */
    struct systematic_found systematic[SYSTEMATICS];
    double skew_test_s;                          /* standard deviation of single tests' skews about
                                                  * the common one (skews.h) */
    double share[CAUSES][DOFS][DOFS];            /* share of each cause in an entry's variance */
    struct payload payload;
    struct matrix_at_pose at_pose;
    /* rms residual of the coefficient rows, as a multiple of their noise: about 1 if the model is
     * right; less with dry friction, whose variance near reversals is an upper bound */
    double scatter;
};

/* Computes the equations of an admitted recording of a platform (admit.h). Returns -2, with
 * the reason, if the recording and the configured machine do not fit together (no pose has these
 * lengths, a force is constant) or a leg does not move in both directions; -3 without memory. */
int method_c_equations(const struct recording *recording, struct equations *equations, struct error *error);

/* Solves the equations of one recording, or the summed equations of several recordings of one
 * machine. result: the determined values; estimate: all values. Returns -2 if some leg does not
 * move in both directions, no entry is determined, or the configured geometry is impossible. */
int method_c_solve(const struct equations *equations, const struct params *configured, struct estimate *estimate, struct method_c *result,
                   struct error *error);

/* Computes and solves the equations of one admitted recording, by method_c_equations() and
 * method_c_solve(). */
int method_c(const struct recording *recording, struct method_c *result, struct error *error);

/* Fills m->at_pose for this pose. Returns -2 if a leg's stroke does not reach this pose. */
int method_c_at_pose(struct method_c *m, const struct params *params, const double pose[DOFS], struct error *error);

/* Value and standard deviation of an unknown, given by its index in the equations, which must be
 * below UNKNOWN_SYSTEMATIC; NaN: not determined. */
double method_c_value(const struct method_c *m, int unknown, double *std);

#endif
