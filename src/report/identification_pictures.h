/* The pictures of an identification as gnuplot scripts (plot.h, page_draw). */
#ifndef HEXID_IDENTIFICATION_PICTURES_H
#define HEXID_IDENTIFICATION_PICTURES_H

#include <stdio.h>

#include "identification_report.h"
#include "leg_friction.h"

/* Of a struct identification_report: how far each of ident_entries is from nominal, in per cent of
 * sqrt(Mii Mjj), with its 95 % interval; methods A and C and all logs one below the other. */
void picture_entries(FILE *script, const void *report);

/* A few periods of a test from the beginning of its evaluated part; of any motion a few
 * pieces in its middle. */
struct picture_test {
    const struct identification_log *log;
    int test;              /* of log->recording */
    double from_s, seconds;
};

/* Of a test that has an evaluated part; a motion in pieces is given by its first one. */
struct picture_test picture_of_test(const struct identification_log *log, int test);

/* Of a struct picture_test: the tested axis, or all of them, as measured and as commanded; below it
 * the legs' forces. */
void picture_test(FILE *script, const void *test);

struct picture_friction {
    const struct leg_friction *measured;
    const struct method_c *found;
    int leg;
};

/* Of a struct picture_friction: force over rate as measured, and what method C found drawn over it.
 * All legs on one scale. */
void picture_friction(FILE *script, const void *friction);

#endif
