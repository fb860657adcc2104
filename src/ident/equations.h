/* Method C's normal equations hold all that a log, or a part of a long one, says about the machine.
 * They add up: the sum of several logs' equations yields one estimate from all their rows, whatever
 * a single log leaves undetermined, so nothing else of a log need be kept.
 *
 * The unknowns are corrections to the configured machine: 21 entries of Mt, friction of each leg,
 * springs on the six coordinates of the pose.
 *
 * The covariance of an estimate has two parts. Noise is independent from log to log and averages
 * out. Errors that all logs of a machine share do not: each shifts the right-hand side of every
 * log, the right-hand sides add up, and many logs of one motion suffer as much as one. The shared
 * errors are 36 joint coordinates, each off its configured place by one standard deviation, and
 * attenuation (Fuller 1987 section 1.1): the noise of the accelerations is on both sides of the
 * equations, so an axis that moves only within that noise seems to have no mass. This bias of the
 * entries towards zero is the 37th. Pure, no heap. */
#ifndef HEXID_EQUATIONS_H
#define HEXID_EQUATIONS_H

#include <stdbool.h>

#include "payload.h"

/* Basis functions ("shapes") of each leg's dry friction beside the constants: six for low speed,
 * one for the pressures, and 15 for presliding, the deformation of a seal before it slides: five
 * lengths, each alone and times two functions of speed (friction_course.h). */
enum { UNKNOWN_SHAPES = 22 };
/* Indices of the first unknown of each kind, after the matrix entries. Each leg has two dry
 * frictions: extending, then retracting. */
enum {
    UNKNOWN_VISCOUS = MATRIX_ENTRIES,
    UNKNOWN_DRY = UNKNOWN_VISCOUS + LEGS,
    UNKNOWN_SPRING = UNKNOWN_DRY + 2 * LEGS,
    UNKNOWN_SHAPE = UNKNOWN_SPRING + DOFS,
    UNKNOWNS = UNKNOWN_SHAPE + UNKNOWN_SHAPES * LEGS
};
enum { JOINT_COORDINATES = 6 * LEGS, COMMON_ATTENUATION = JOINT_COORDINATES, COMMON };

struct equations {
    /* X' W X, lower triangle. W is the rows' inverse covariance, divided by scatter^2 if they
     * scatter by more than their noise. */
    double product[UNKNOWNS][UNKNOWNS];
    double with[UNKNOWNS];              /* X' W y, y the right-hand side */
    /* Change of `with` by a joint coordinate that is off by one standard deviation, or by
     * attenuation. */
    double common[COMMON][UNKNOWNS];
    /* Sum of squared residuals, weighted by their noise alone. */
    double rest;
    /* Degrees of freedom of `rest`: number of rows less that of unknowns. Coefficients of basis
     * functions are random by their prior, and do not count. */
    int free;
    double dry_n[LEGS];                 /* size of each leg's dry friction, N: the unit of its basis
                                         * functions' prior */
    /* Prior standard deviation of each spring, N/m and N m/rad; 0: no such spring is fitted. */
    double spring[DOFS];
    /* Scales of friction: rms of the varying part of a leg's force, and rms speed of a leg, each in
     * the leg and test where it is largest. */
    double force_n, rate_mps;
};

/* Solution of the equations. A prior keeps finite what the data leave undetermined. The prior of a
 * matrix entry has the standard deviation sqrt(M_ii M_jj) of the configured machine; the width of
 * the basis functions' prior comes from all data together (shape_sizes.h). */
struct estimate {
    double value[UNKNOWNS];
    double noise[UNKNOWNS][UNKNOWNS];           /* covariance by noise */
    double common[COMMON][UNKNOWNS];            /* change of `value` by each shared error */
};

/* Row and column of the matrix, from 0, with row <= column, for an unknown that is a matrix
 * entry. */
void equations_entry(int unknown, int *row, int *column);

/* Name of an unknown that is no basis function: "Mt15", "viscous leg 2", "dry leg 3 extending",
 * "spring theta". */
enum { EQUATIONS_NAME = 32 };
void equations_name(int unknown, char name[EQUATIONS_NAME]);

/* Rms residual of the coefficient rows, as a multiple of their noise. NaN unless there are more
 * rows than unknowns. */
double equations_scatter(const struct equations *e);

/* Prior variance, N^2, of the unknown UNKNOWN_SHAPE + i. size: relative size of each kind of basis
 * function, in units of dry friction. */
double equations_shape_variance(const struct equations *e, int i, const double size[UNKNOWN_SHAPES]);

/* Adds the equations of another log of the same machine and configuration. */
void equations_add(struct equations *sum, const struct equations *e);

/* Solves for the values alone. nominal: Mt as configured. Returns false if some unknown occurs in
 * no row, or a value is not finite. */
bool equations_values(const struct equations *e, double nominal[DOFS][DOFS], double value[UNKNOWNS]);

/* Solves for the values and their covariance. nominal: Mt as configured. Returns false if some
 * unknown occurs in no row, or a value is not finite. */
bool equations_solve(const struct equations *e, double nominal[DOFS][DOFS], struct estimate *estimate);

/* Covariance of two unknowns, by noise and by shared errors. */
double estimate_covariance(const struct estimate *e, int a, int b);

#endif
