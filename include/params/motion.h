/* Section `motion` of the configuration (params.h). */
#ifndef HEXID_PARAMS_MOTION_H
#define HEXID_PARAMS_MOTION_H

#include <stdbool.h>

struct motion_params {
    double engage_s, park_s;      /* durations of the moves from parked to neutral and back; longer
                                   * if rate_mps or accel_mps2 require it */
    double rate_mps, accel_mps2;  /* largest speed and acceleration in a move: norms over all axes,
                                   * with angles multiplied by kinematics.arm_m */
    double park_z_m;              /* pose z at which the platform is put down; z points down */
    double rest_s;                /* time at rest before `automatic` engages; an `engage` command
                                   * does not wait for it */
    double hold_s;                /* time at neutral before `automatic` starts the tests, and again
                                   * before `automatic` parks; `start` and `park` commands do not
                                   * wait for it */
    bool automatic;               /* the daemon engages, tests and parks without commands */
};

#endif
