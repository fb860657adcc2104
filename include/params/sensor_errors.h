/* Systematic errors of the sensors, as found by an estimate from measured motion; 0: none. No key
 * of the configuration sets them: model.tolerance states their standard deviations, and
 * src/residual/systematic.h lists them. */
#ifndef HEXID_PARAMS_SENSOR_ERRORS_H
#define HEXID_PARAMS_SENSOR_ERRORS_H

#include "types.h"

struct sensor_errors {
    double p1_gain[LEGS], p2_gain[LEGS]; /* relative errors of the gains; p1_gain also stands for
                                          * the gain of a force sensor */
    double length_gain[LEGS], length_zero_m[LEGS];
    double skew_s; /* age of the lengths less age of the pressures */
    /* Lag of the pressures, and length of the pipe between pressure sensor and chamber. lag_s and
     * pipe_m are common to all legs; lag_rest_s and pipe_rest_m are each leg's difference from
     * them. */
    double lag_s, lag_rest_s[LEGS];
    double pipe_m, pipe_rest_m[LEGS];
};

#endif
