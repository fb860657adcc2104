/* Inverse and forward kinematics of the six-leg platform (docs/method.md section 2; frames in
 * types.h). Pure, RT, no heap. */
#ifndef HEXID_KINEMATICS_H
#define HEXID_KINEMATICS_H

#include "status.h"
#include "types.h"

struct actuator_params;
struct params;

struct kinematics {
    double upper[LEGS][3];       /* joints on the platform, in {M} */
    double lower[LEGS][3];       /* joints on the base, in {B} */
    double neutral_length_m[LEGS];
    double arm_m;                /* rms distance of the upper joints from their mean position;
                                  * converts angles to lengths */
};

struct fk_result {
    int iterations;       /* number of Newton steps taken */
    double residual_m;    /* largest length error, m. If the iteration ended with a step of at most
                           * 0.1 um, the error is estimated as that step squared over arm_m;
                           * otherwise it is that of the last pose tried */
    double pivot_ratio;   /* smallest over largest pivot of the matrix of the last step, with
                           * angles in units of 1/arm_m: 1 at best, 0 if singular; 1 if no step
                           * was needed */
    bool converged;
};

/* Fills in joints and neutral lengths, without checks. */
void kinematics_place(struct kinematics *k, const struct params *params);

/* Fills in joints and neutral lengths, and checks that the neutral pose lies within the legs'
 * strokes and is not singular, that no two legs collide, and that no joint's axis is along its leg.
 * Returns -2 with the key to change if a check fails. */
int kinematics_init(struct kinematics *k, const struct params *params, struct error *error);

/* Leg lengths at the ends and the middle of the stroke. */
struct stroke {
    double least_m, middle_m, most_m;
};
struct stroke kinematics_stroke(const struct kinematics *k, const struct actuator_params *actuator, int leg);

void rotation_from_angles(double phi, double theta, double psi, double t[3][3]);

/* Computes the leg lengths of a pose. */
void ik_lengths(const struct kinematics *k, const double pose[DOFS], double length_m[LEGS]);

/* Computes the Jacobian, which converts the twist [velocity of the origin of {M}; angular
 * velocity], both in {B}, to leg rates. Row i is [n_i', (T a_i x n_i)']: n_i is the unit vector
 * along leg i, and T a_i leads from the origin of {M} to the leg's upper joint. */
void ik_jacobian(const struct kinematics *k, const double pose[DOFS], double j[LEGS][DOFS]);

/* Computes the pose of given leg lengths by Newton's method, in at most FK_ITERATIONS steps, to
 * 1e-13 m. `pose` is the start value (the last pose) and the result; it stays unchanged if the
 * iteration does not converge. Convergence is quadratic, because the matrix is the exact derivative
 * of the lengths by the six coordinates of the pose. */
enum { FK_ITERATIONS = 6 };
struct fk_result fk_solve(const struct kinematics *k, const double length_m[LEGS], double pose[DOFS]);

/* Computes the platform's wrench F = J' f from the leg forces f. */
void wrench_from_forces(const struct kinematics *k, const double pose[DOFS], const double force_n[LEGS], double wrench[DOFS]);

#endif
