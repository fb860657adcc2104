/* Systematic errors of the sensors, as an estimate from measured motion sets them (params.h). No
 * configuration states them: model.tolerance states how large they usually are, and
 * src/residual/systematic.h lists them. */
#ifndef HEXID_PARAMS_SENSOR_ERRORS_H
#define HEXID_PARAMS_SENSOR_ERRORS_H

#include "types.h"

struct sensor_errors {
    double p1_gain[LEGS], p2_gain[LEGS]; /* a force sensor takes the place of P1's */
    double length_gain[LEGS], length_zero_m[LEGS];
    double skew_s; /* age of the lengths less age of the pressures */
    /* lag of the pressures, and length of the pipe between pressure sensor and chamber: of all
     * legs, and of a leg beside that */
    double lag_s, lag_rest_s[LEGS];
    double pipe_m, pipe_rest_m[LEGS];
};

#endif
