/* Feedback in modal coordinates. The oil and the platform's inertia have six modes, and the slowest
 * one limits the gains that all may have together. Here each mode has gains of its own: kp, ki and
 * kd grow with the mode's frequency w, from the slowest mode's w1, by (w / w1)^control.modal.
 *
 * The legs' oil columns are taken to be equally stiff. So w^2 is proportional to 1 / m, where m are
 * the eigenvalues of the inertia M in leg coordinates, and the matrix of all gains is a power of M:
 *
 *     M  = F A^-1,   A, F: acceleration and force of each leg for a unit acceleration of each axis
 *     W  = (M / m1)^(-control.modal / 2),   m1 the largest eigenvalue
 *     e' = W (Lref - L)
 *
 * The controller of each leg (pid.h) then has e' for its error. M is that of the neutral pose, with
 * the configured bodies and effects, so in other poses W mixes the modes (loop_margin.h has margins
 * for that). Pure; modal_init() is not RT. */
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

/* Computes W. Returns -2 if the legs do not determine the platform at neutral, or the inertia that
 * the configured bodies and effects give it is not positive; all modes then have the same gains. */
int modal_init(struct modal *modal, const struct params *params, const struct kinematics *kinematics, struct error *error);

/* Returns the feedback along `to` for an error along `from`, to'W from. */
double modal_between(const struct modal *modal, const double to[LEGS], const double from[LEGS]);

/* Returns the factor of kp, ki and kd in a motion v of the legs, v'W v / v'v. It is exact for a
 * mode of the neutral pose, and of first order elsewhere. */
double modal_gain(const struct modal *modal, const double motion[LEGS]);

/* Computes the lengths that the legs' controllers take for measured ones, Lref - e'; the measured
 * ones to the last bit if the weights are off. RT. */
void modal_lengths(const struct modal *modal, const double ref_m[LEGS], const double length_m[LEGS], double seen_m[LEGS]);

#endif
