/* The result as JSON, schema hexid.identification/1: matrices are 6x6 row-major arrays of arrays,
 * SI units, order x y z phi theta psi; values not evaluated are null. Numbers read back exactly. */
#ifndef HEXID_IDENTIFICATION_JSON_H
#define HEXID_IDENTIFICATION_JSON_H

#include "ident.h"
#include "verdict.h"

struct loop_statistics {
    int64_t cycles, overruns, lost;
    double period_s;
    bool timed;                     /* false on a virtual clock: the times below mean nothing */
    double wake_us[4], exec_us[4];  /* p50, p99, p99.9, max */
    double pace;                    /* the loop's own time over the host's, 1 if it kept up */
    int64_t stalls;                 /* wake-ups a period or more late */
    double longest_stall_s;
};

/* The caller frees the text. NULL without memory. */
char *identification_json(const struct identification *id, const struct verdict *verdict, const struct loop_statistics *loop);

#endif
