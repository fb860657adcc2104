/* Systematic errors of the sensors, as an estimate from measured motion sets them; 0: none. No
 * configuration states them: model.tolerance states their standard deviations, and
 * src/residual/systematic.h lists them. */
#ifndef HEXID_PARAMS_SENSOR_ERRORS_H
#define HEXID_PARAMS_SENSOR_ERRORS_H

#include "types.h"

struct sensor_errors {
    double p1_gain[LEGS], p2_gain[LEGS]; /* relative errors; a force sensor has the gain of P1 */
    double length_gain[LEGS], length_zero_m[LEGS];
    double skew_s; /* age of the lengths less age of the pressures */
    /* lag of the pressures, and length of the pipe between pressure sensor and chamber: a value
     * common to all legs, and each leg's difference from it */
    double lag_s, lag_rest_s[LEGS];
    double pipe_m, pipe_rest_m[LEGS];
};

#endif
