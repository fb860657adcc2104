/* Method C's normal equations: all that one log, or a part of a long one, says about the machine.
 * They add up, so that several logs together are one estimate of all their rows, whatever each of
 * them leaves open; and nothing of a log need be kept but these.
 *
 * Unknown is what is to be added to the configured machine: 21 entries of Mt, friction of each leg,
 * springs on the six coordinates of the pose.
 * Of the covariance of an estimate there are two parts. The noise is each log's own, and gets
 * smaller with every further one. What logs of a machine have in common moves every log's
 * right-hand side in a way of its own; the right-hand sides are added, and what the sum does to the
 * estimate is no smaller for many logs of one motion than for one. These are joints which are not
 * where they are configured, 36 coordinates, each a standard deviation off; and the noise of the
 * accelerations, which belongs to both sides of the equations: an axis that does not move but in
 * that noise seems to have no mass (attenuation, Fuller 1987 section 1.1), and how far that draws
 * the entries is the 37th. Pure, no heap. */
#ifndef HEXID_EQUATIONS_H
#define HEXID_EQUATIONS_H

#include <stdbool.h>

#include "payload.h"

/* of dry friction that is not the same all the time: at six low speeds, with the pressures, and
 * after reversals of a seal that gives, by five lengths, each by itself and times two functions of
 * the speed (friction_course.h) */
enum { UNKNOWN_SHAPES = 22 };
/* of each leg extending, retracting */
enum {
    UNKNOWN_VISCOUS = MATRIX_ENTRIES,
    UNKNOWN_DRY = UNKNOWN_VISCOUS + LEGS,
    UNKNOWN_SPRING = UNKNOWN_DRY + 2 * LEGS,
    UNKNOWN_SHAPE = UNKNOWN_SPRING + DOFS,
    UNKNOWNS = UNKNOWN_SHAPE + UNKNOWN_SHAPES * LEGS
};
enum { JOINT_COORDINATES = 6 * LEGS, COMMON_ATTENUATION = JOINT_COORDINATES, COMMON };

struct equations {
    double product[UNKNOWNS][UNKNOWNS]; /* X' W X, lower triangle; W in units of what the rows
                                         * scatter by, where that is more than their noise */
    double with[UNKNOWNS];              /* X' W y */
    double common[COMMON][UNKNOWNS];    /* what is added to `with` by a coordinate that is one
                                         * standard deviation off, and by attenuation */
    double rest;                        /* weighted sum of squares that is left, W as
                                         * the noise alone has it, */
    int free;                           /* and its mean: rows less unknowns; shapes are random
                                         * by their prior, and no unknowns here */
    double dry_n[LEGS];                 /* how large dry friction may be: the unit
                                         * of its shapes' prior */
    double spring[DOFS];                /* deviation of the springs a priori, N/m and
                                         * N m/rad; 0: there is none, and no rows have it */
    double force_n, rate_mps;           /* root mean square of what varies of a leg's force and of
                                         * its speed, where it is most: scales of friction */
};

/* The prior that keeps finite what the data leave open: for each entry sqrt(M_ii M_jj) of the
 * configured machine. That of the shapes is as wide as the data, all of them together, say
 * (shape_sizes.h). */
struct estimate {
    double value[UNKNOWNS];
    double noise[UNKNOWNS][UNKNOWNS];           /* covariance */
    double common[COMMON][UNKNOWNS];            /* what each of them adds to `value` */
};

/* Where an entry of the unknowns stands in the matrix, row <= column. */
void equations_entry(int unknown, int *row, int *column);

/* "Mt15", "viscous leg 2", "dry leg 3 extending", "spring theta": all but the shapes. */
enum { EQUATIONS_NAME = 32 };
void equations_name(int unknown, char name[EQUATIONS_NAME]);

/* What the rows scatter by, in units of the noise that they should have. NaN: no more
 * rows than unknowns. */
double equations_scatter(const struct equations *e);

/* A priori, of the shape UNKNOWN_SHAPE + i; size: of each kind, in units of dry friction. */
double equations_shape_variance(const struct equations *e, int i, const double size[UNKNOWN_SHAPES]);

void equations_add(struct equations *sum, const struct equations *e);

/* The values alone. False: some unknown is in no row, or a value is no number. */
bool equations_values(const struct equations *e, double nominal[DOFS][DOFS], double value[UNKNOWNS]);

bool equations_solve(const struct equations *e, double nominal[DOFS][DOFS], struct estimate *estimate);

/* Of two unknowns, both parts. */
double estimate_covariance(const struct estimate *e, int a, int b);

#endif
