/* Feedback in modal coordinates. The oil's stiffness and the platform's inertia make six modes of
 * oscillation. If all modes have the same gains, the slowest mode limits these gains. Here each
 * mode has gains of its own: kp, ki and kd grow with the mode's frequency w as
 * (w / w1)^control.modal, where w1 is the frequency of the slowest mode.
 *
 * All legs' oil columns are assumed equally stiff. So w^2 of a mode is proportional to 1 / m, where
 * m is the mode's eigenvalue of the inertia M in leg coordinates, and the matrix W of the gains is
 * a power of M:
 *
 *     M  = F A^-1,   A, F: acceleration and force of each leg for a unit acceleration of each axis
 *     W  = (M / m1)^(-control.modal / 2),   m1 the largest eigenvalue
 *     e' = W (Lref - L)
 *
 * The controller of each leg (pid.h) takes e' as its error. M is computed for the neutral pose,
 * with the configured bodies and effects. In other poses W couples the modes (loop_margin.h
 * computes the margins of coupled modes). Pure; modal_init() is not RT. */
#ifndef HEXID_MODAL_H
#define HEXID_MODAL_H

#include <stdbool.h>

#include "kinematics.h"
#include "status.h"

struct params;

struct modal {
    bool on;                   /* false: all modes have the same gains */
    double weight[LEGS][LEGS]; /* W, symmetric */
};

/* Computes W. Returns -2 if the legs do not determine the platform at neutral, or the inertia of
 * the configured bodies and effects is not positive definite; modal->on is then false. */
int modal_init(struct modal *modal, const struct params *params, const struct kinematics *kinematics, struct error *error);

/* Returns to' W from: the feedback along `to` for an error along `from`. */
double modal_between(const struct modal *modal, const double to[LEGS], const double from[LEGS]);

/* Returns v'W v / v'v: the factor of kp, ki and kd in a motion v of the legs. It is exact for a
 * mode of the neutral pose, and correct to first order for other motions. */
double modal_gain(const struct modal *modal, const double motion[LEGS]);

/* Computes the lengths Lref - e', which the legs' controllers get in place of the measured lengths.
 * If modal->on is false, the measured lengths are returned to the last bit. RT. */
void modal_lengths(const struct modal *modal, const double ref_m[LEGS], const double length_m[LEGS], double seen_m[LEGS]);

#endif
