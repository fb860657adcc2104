/* The pictures of an identification as gnuplot scripts (plot.h, page_draw). */
#ifndef HEXID_IDENTIFICATION_PICTURES_H
#define HEXID_IDENTIFICATION_PICTURES_H

#include <stdio.h>

#include "identification_report.h"
#include "leg_friction.h"

/* Plots a struct identification_report: difference of each of ident_entries from nominal, in per
 * cent of sqrt(Mii Mjj), with its 95 % interval; methods A and C and all logs in turn. */
void picture_entries(FILE *script, const void *report);

/* First periods of a test's evaluated part, or some pieces from the middle of any motion. */
struct picture_test {
    const struct identification_log *log;
    int test;              /* index in log->recording */
    double from_s, seconds;
};

/* Selects them for a test with an evaluated part; a motion in pieces is given by its first one. */
struct picture_test picture_of_test(const struct identification_log *log, int test);

/* Plots a struct picture_test: the tested axis, or all, measured and commanded; below, leg
 * forces. */
void picture_test(FILE *script, const void *test);

struct picture_friction {
    const struct leg_friction *measured;
    const struct method_c *found;
    int leg;
};

/* Plots a struct picture_friction: measured force over rate, with method C's result drawn over it.
 * All legs have one scale. */
void picture_friction(FILE *script, const void *friction);

#endif
