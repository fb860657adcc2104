/* SAFETY: a run's whole motion, as the loop will ask for it cycle by cycle, against what the
 * machine can do, before anything moves: every test with its ramps, and stops in it, a tenth of
 * tests.ramp_out_s apart. A motion that repeats after 64 cycles or more is stopped only in its
 * ramp-in and first period, a trajectory also near its end. Of each leg:
 *
 *     length   within limits.length_min_m .. length_max_m and actuator.stroke_m
 *     rate     limits.leg_rate_mps; and what the valve lets through at full opening
 *              (control.output_limit), extending and retracting:
 *
 *                  v = k sqrt((A1 ps - A2 pt - F) / (A1^3 + A2^3))
 *                  v = k sqrt((A2 ps - A1 pt + F) / (A1^3 + A2^3))
 *
 *              A1, A2 areas, ps, pt supply and tank, F the force that the leg needs,
 *              k = hydraulics.valve_flow_m3_per_s / sqrt(valve_drop_pa): flow in and out through
 *              two equal edges, the oil not compressed
 *     force    F from the rigid bodies with weight, inertia and friction: limits.force_n, and what
 *              the supply can hold. It is what limits the acceleration
 *
 * It is as good as the configuration. Ordinary threads. */
#ifndef HEXID_MOTION_CHECK_H
#define HEXID_MOTION_CHECK_H

#include "params.h"
#include "status.h"
#include "trajectory.h"

/* trajectory: NULL where the tests are sinusoids. -2 with the test, the leg, the instant, the value
 * and its limit, and how much smaller the motion would have to be. */
int motion_check(const struct params *params, const struct trajectory *trajectory, struct error *error);

/* The configured tests: their trajectory is loaded where there is one (to be freed; knot NULL:
 * none), and tests.duration_s is then its length; all is checked. -2 as above; -3: a trajectory
 * that cannot be read. */
int motion_check_tests(struct params *params, struct trajectory *trajectory, struct error *error);

#endif
