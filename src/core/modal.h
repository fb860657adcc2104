/* Feedback in modal coordinates. The oil's stiffness and the platform's inertia have six modes of
 * oscillation. If all modes have the same gains, the slowest mode limits them. Here each mode has
 * gains of its own: kp, ki and kd grow with the mode's frequency w as (w / w1)^control.modal, where
 * w1 is that of the slowest mode.
 *
 * All legs' oil columns are assumed equally stiff. So a mode has w^2 proportional to 1 / m, where m
 * is its eigenvalue of the inertia M in leg coordinates, and the matrix W of the gains is a power
 * of M:
 *
 *     M  = F A^-1,   A, F: acceleration and force of each leg for a unit acceleration of each axis
 *     W  = (M / m1)^(-control.modal / 2),   m1 the largest eigenvalue
 *     e' = W (Lref - L)
 *
 * The controller of each leg (pid.h) then takes e' as its error. M is that of the neutral pose,
 * with the configured bodies and effects, so in other poses W couples the modes (loop_margin.h
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

/* Computes W. Returns -2 if the legs do not determine the platform at neutral, or if the inertia of
 * the configured bodies and effects is not positive definite; all modes then have the same
 * gains. */
int modal_init(struct modal *modal, const struct params *params, const struct kinematics *kinematics, struct error *error);

/* Returns the feedback along `to` for an error along `from`, to'W from. */
double modal_between(const struct modal *modal, const double to[LEGS], const double from[LEGS]);

/* Returns the factor of kp, ki and kd in a motion v of the legs, v'W v / v'v. It is exact for a
 * mode of the neutral pose, and correct to first order elsewhere. */
double modal_gain(const struct modal *modal, const double motion[LEGS]);

/* Computes the lengths Lref - e' that the legs' controllers get in place of the measured ones; if
 * modal->on is false, they equal the measured ones to the last bit. RT. */
void modal_lengths(const struct modal *modal, const double ref_m[LEGS], const double length_m[LEGS], double seen_m[LEGS]);

#endif
