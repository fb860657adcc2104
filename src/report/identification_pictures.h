/* The pictures of an identification as gnuplot scripts (plot.h), by functions of the type
 * page_script (page.h). */
#ifndef HEXID_IDENTIFICATION_PICTURES_H
#define HEXID_IDENTIFICATION_PICTURES_H

#include <stdio.h>

#include "identification_report.h"
#include "leg_friction.h"

/* Plots a struct identification_report: for each of ident_entries the difference from nominal, in
 * per cent of sqrt(Mii Mjj), with its 95 % interval, for methods A and C and all logs. */
void picture_entries(FILE *script, const void *report);

/* Time to be plotted: the first three periods of a test's evaluated part, or six segments from the
 * middle of any other motion. */
struct picture_test {
    const struct identification_log *log;
    int test;              /* index of the test in log->recording */
    double from_s, seconds;
};

/* Chooses the stretch of time of a test that is plotted. The test must have an evaluated part.
 * test: its index in log->recording; for a motion in segments, the index of its first segment. */
struct picture_test picture_of_test(const struct identification_log *log, int test);

/* Plots a struct picture_test: measured pose and, if recorded, reference, of the tested axis or of
 * all, and below them the leg forces. */
void picture_test(FILE *script, const void *test);

struct picture_friction {
    const struct leg_friction *measured;
    const struct method_c *found;
    int leg;
};

/* Plots a struct picture_friction: a leg's measured friction over its rate, with method C's result,
 * if determined, drawn over it. All legs have one scale. */
void picture_friction(FILE *script, const void *friction);

#endif
