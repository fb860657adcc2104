/* SAFETY: compares the motion of all tests, as the loop will request it cycle by cycle, with the
 * machine's abilities before anything moves: every test with its ramps, and again with a stop,
 * which is tried at intervals of a tenth of tests.ramp_out_s. If the motion repeats after 64 cycles
 * or more, stops are tried only in the ramp-in and the first period, for a trajectory also near its
 * end. For each leg:
 *
 *     length   within limits.length_min_m .. length_max_m and actuator.stroke_m
 *     rate     limits.leg_rate_mps; and the valve's flow at full opening (control.output_limit
 *              less dead band and null): the speed v at which the two edges' pressure drops leave
 *              the required force F,
 *
 *                  Ai (ps - ((Ai v + L) / ki)^2) - Ao (pt + ((Ao v + L) / ko)^2) = F
 *
 *              Ai, Ao areas of the chambers that oil enters and leaves; ki, ko the gains of their
 *              edges; ps, pt supply and tank; F against the motion; L = c (Pi - Po) the leakage
 *              across the piston; incompressible oil. Gains and leakage include the configured
 *              effects
 *     force    F of inverse_dynamics.h, from weight, inertia and friction: limits.force_n, and the
 *              force that the supply can hold, the left side of the equation with v = 0. This
 *              limits the acceleration
 *
 * The result is only as good as the configuration. Ordinary threads. */
#ifndef HEXID_MOTION_CHECK_H
#define HEXID_MOTION_CHECK_H

#include "status.h"
#include "trajectory.h"

struct params;

/* Checks a motion. trajectory: NULL for sinusoids. Returns -2 with test, leg, time, value and limit
 * of the largest excess, and the scale to which the motion must be reduced. */
int motion_check(const struct params *params, const struct trajectory *trajectory, struct error *error);

/* Checks the configured tests. If they have a trajectory, loads it, which the caller frees, and
 * sets tests.duration_s to its duration. `trajectory` must be zeroed before; without a trajectory
 * its knot stays NULL. Returns -2 as motion_check() does, or for impossible tests; -3: the
 * trajectory cannot be read. */
int motion_check_tests(struct params *params, struct trajectory *trajectory, struct error *error);

#endif
