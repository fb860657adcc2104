/* Method C's normal equations: all that one log, or a part of a long one, says about the machine.
 * They add up: the sum of several logs' equations is one estimate from all their rows, whatever
 * each of them leaves undetermined; and nothing else of a log need be kept.
 *
 * The unknowns are what is to be added to the configured machine: 21 entries of Mt, friction of
 * each leg, springs on the six coordinates of the pose.
 *
 * The covariance of an estimate has two parts. Noise is each log's own, and shrinks with every
 * further one. Errors that all logs of a machine share do not: each moves the right-hand side of
 * every log in a way of its own, the right-hand sides are added, and what the sum does to the
 * estimate is no smaller for many logs of one motion than for one. These are joints that are not
 * where they are configured, 36 coordinates, each off by one standard deviation; and attenuation
 * (Fuller 1987 section 1.1): the noise of the accelerations is on both sides of the equations, so
 * that an axis which moves only within that noise seems to have no mass. How far this draws the
 * entries towards zero is the 37th. Pure, no heap. */
#ifndef HEXID_EQUATIONS_H
#define HEXID_EQUATIONS_H

#include <stdbool.h>

#include "payload.h"

/* Shapes of each leg's dry friction beside a constant: six of low speed, one of the pressures, and
 * the way after a reversal of a seal that deforms before it slides, of five lengths, each by itself
 * and times two functions of the speed (friction_course.h). */
enum { UNKNOWN_SHAPES = 22 };
/* places of the unknowns; dry friction of each leg: extending, retracting */
enum {
    UNKNOWN_VISCOUS = MATRIX_ENTRIES,
    UNKNOWN_DRY = UNKNOWN_VISCOUS + LEGS,
    UNKNOWN_SPRING = UNKNOWN_DRY + 2 * LEGS,
    UNKNOWN_SHAPE = UNKNOWN_SPRING + DOFS,
    UNKNOWNS = UNKNOWN_SHAPE + UNKNOWN_SHAPES * LEGS
};
enum { JOINT_COORDINATES = 6 * LEGS, COMMON_ATTENUATION = JOINT_COORDINATES, COMMON };

struct equations {
    double product[UNKNOWNS][UNKNOWNS]; /* X' W X, lower triangle; W the inverse covariance of the
                                         * rows, whose noise is enlarged where they scatter by
                                         * more */
    double with[UNKNOWNS];              /* X' W y */
    double common[COMMON][UNKNOWNS];    /* added to `with` by a joint coordinate that is off by one
                                         * standard deviation, and by attenuation */
    double rest;                        /* weighted sum of squares that is left, W by the noise
                                         * alone, */
    int free;                           /* and its degrees of freedom: rows less unknowns; shapes,
                                         * random by their prior, do not count */
    double dry_n[LEGS];                 /* size of dry friction, N: the unit of its shapes' prior */
    double spring[DOFS];                /* prior standard deviation of the springs, N/m and N m/rad;
                                         * 0: there are none, and no rows have any */
    double force_n, rate_mps;           /* rms of the varying part of a leg's force, and of its
                                         * speed, in the leg and test where it is largest: scales of
                                         * friction */
};

/* A prior keeps finite what the data leave undetermined: that of an entry has the deviation
 * sqrt(M_ii M_jj) of the configured machine, that of the shapes is as wide as all data together say
 * (shape_sizes.h). */
struct estimate {
    double value[UNKNOWNS];
    double noise[UNKNOWNS][UNKNOWNS];           /* covariance */
    double common[COMMON][UNKNOWNS];            /* what each shared error adds to `value` */
};

/* Row and column in the matrix, from 0, of an unknown that is an entry; row <= column. */
void equations_entry(int unknown, int *row, int *column);

/* "Mt15", "viscous leg 2", "dry leg 3 extending", "spring theta": all but the shapes. */
enum { EQUATIONS_NAME = 32 };
void equations_name(int unknown, char name[EQUATIONS_NAME]);

/* rms of what the fit leaves of the rows, in units of their noise. NaN: no more rows than
 * unknowns. */
double equations_scatter(const struct equations *e);

/* Prior variance of the shape UNKNOWN_SHAPE + i, N^2; size: of each kind, in units of dry
 * friction. */
double equations_shape_variance(const struct equations *e, int i, const double size[UNKNOWN_SHAPES]);

/* sum += e, of the same configured machine. */
void equations_add(struct equations *sum, const struct equations *e);

/* The values alone; nominal: Mt as configured. False: some unknown is in no row, or a value is not
 * finite. */
bool equations_values(const struct equations *e, double nominal[DOFS][DOFS], double value[UNKNOWNS]);

/* Values and covariance; otherwise the same. */
bool equations_solve(const struct equations *e, double nominal[DOFS][DOFS], struct estimate *estimate);

/* Covariance of two unknowns, both parts. */
double estimate_covariance(const struct estimate *e, int a, int b);

#endif
