/* The result of an identification as JSON, schema hexid.identification/1. Matrices are 6x6
 * row-major arrays of arrays in SI units, in the order x y z phi theta psi; values that were not
 * evaluated are null. Numbers read back exactly. */
#ifndef HEXID_IDENTIFICATION_JSON_H
#define HEXID_IDENTIFICATION_JSON_H

#include "ident.h"
#include "verdict.h"

struct loop_statistics {
    int64_t cycles, overruns, lost; /* lost: number of cycles that are not in the log */
    double period_s;
    bool timed;                     /* false: the clock was virtual or the log was imported, and
                                     * the members below mean nothing */
    double wake_us[4], exec_us[4];  /* percentiles p50, p99, p99.9 and maximum */
    double pace;                    /* elapsed loop time divided by elapsed host time; 1 if the loop
                                     * kept up */
    int64_t stalls;                 /* number of wake-ups that were late by a period or more */
    double longest_stall_s;
};

/* Returns the result as text, which the caller frees, or NULL without memory. */
char *identification_json(const struct identification *id, const struct verdicts *verdicts, const struct loop_statistics *loop);

#endif
