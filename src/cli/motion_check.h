/* SAFETY: compares a run's whole motion, as the loop will request it cycle by cycle, with the
 * machine's abilities before anything moves: every test with its ramps, and stops in it at
 * intervals of a tenth of tests.ramp_out_s. A motion that repeats after 64 cycles or more is
 * stopped only in its ramp-in and first period, a trajectory also near its end. For each leg:
 *
 *     length   within limits.length_min_m .. length_max_m and actuator.stroke_m
 *     rate     limits.leg_rate_mps; and the valve's flow at full opening (control.output_limit),
 *              extending and retracting:
 *
 *                  v = k sqrt((A1 ps - A2 pt - F) / (A1^3 + A2^3))
 *                  v = k sqrt((A2 ps - A1 pt + F) / (A1^3 + A2^3))
 *
 *              A1, A2 areas; ps, pt supply and tank; F the required leg force;
 *              k = hydraulics.valve_flow_m3_per_s / sqrt(valve_drop_pa): in- and outflow through
 *              two equal edges, incompressible oil
 *     force    F from the rigid bodies with weight, inertia and friction: limits.force_n, and the
 *              force that the supply can hold. This limits the acceleration
 *
 * The result is as good as the configuration. Ordinary threads. */
#ifndef HEXID_MOTION_CHECK_H
#define HEXID_MOTION_CHECK_H

#include "status.h"
#include "trajectory.h"

struct params;

/* Checks a motion. trajectory: NULL for sinusoids. Returns -2 with the test, leg, time, value and
 * limit, and the necessary reduction of the motion. */
int motion_check(const struct params *params, const struct trajectory *trajectory, struct error *error);

/* Checks the configured tests. Loads their trajectory, if any (to be freed; knot NULL: none), and
 * sets tests.duration_s to its length. Returns -2 as motion_check() does; -3: the trajectory cannot
 * be read. */
int motion_check_tests(struct params *params, struct trajectory *trajectory, struct error *error);

#endif
