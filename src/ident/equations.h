/* Method C's normal equations contain all that a log, or a part of a long log, tells about the
 * machine. They add up: the sum of several logs' equations yields one estimate from all their rows,
 * whatever a single log leaves undetermined, so nothing else of a log need be kept.
 *
 * The unknowns are corrections to the configured machine: 21 entries of Mt, friction of each leg,
 * springs on the six coordinates of the pose, and the systematic errors of the sensors and of the
 * configured joint positions (systematic.h).
 *
 * The covariance of an estimate has two parts. Noise is independent from log to log and averages
 * out; the departures of single tests' skews (skews.h) are counted with noise. Errors that all logs
 * of a machine share do not average out: the systematic errors and the errors of the legs' masses,
 * as far as the data do not determine them, and attenuation (Fuller 1987 section 1.1). Attenuation
 * arises because the noise of the accelerations is on both sides of the equations: an axis that
 * moves only within this noise seems to have no mass, so the entries are biased towards zero.
 * Ordinary threads; heap. */
#ifndef HEXID_EQUATIONS_H
#define HEXID_EQUATIONS_H

#include <stdbool.h>

#include "payload.h"
#include "recording.h"
#include "systematic.h"

/* Basis functions of each leg's dry friction beside the constants: six for low speed, one for the
 * pressures, and 15 for presliding, the deformation of a seal before it slides. Presliding has five
 * lengths, each alone and times two functions of speed (friction_course.h). */
enum { BASIS_SIZE = 22 };
/* Indices of the first unknown of each kind, after the matrix entries. Each leg has two dry
 * frictions: extending, then retracting. */
enum {
    UNKNOWN_VISCOUS = MATRIX_ENTRIES,
    UNKNOWN_DRY = UNKNOWN_VISCOUS + LEGS,
    UNKNOWN_SPRING = UNKNOWN_DRY + 2 * LEGS,
    UNKNOWN_SYSTEMATIC = UNKNOWN_SPRING + DOFS,
    UNKNOWN_BASIS = UNKNOWN_SYSTEMATIC + SYSTEMATICS,
    UNKNOWNS = UNKNOWN_BASIS + BASIS_SIZE * LEGS
};
/* Measurements of systematic errors that do not use the equations of motion (calibration.h): a
 * known weight, and each leg on its stop. */
enum { CALIBRATION_WEIGHT, CALIBRATION_STOP, CALIBRATIONS = CALIBRATION_STOP + LEGS };
/* Errors that all logs of a machine share: the systematic errors, the departure of the matrix from
 * its prior (payload_prior()), the common scales of the pressures' and of the lengths' gains
 * (scale_of() in equations.c; always 0, because their effect is counted with the gains),
 * attenuation, and the errors of calibrations. */
enum { GAIN_SCALES = 2 };
enum {
    COMMON_MATRIX = SYSTEMATICS,
    COMMON_SCALE = COMMON_MATRIX + MATRIX_ENTRIES,
    COMMON_ATTENUATION = COMMON_SCALE + GAIN_SCALES,
    COMMON_CALIBRATION,
    COMMON = COMMON_CALIBRATION + CALIBRATIONS
};

/* Largest number of tests whose skews may depart from the common one (skews.h): as many as one log
 * can have. */
enum { SKEW_TESTS = RECORDING_TESTS };
/* A test's part of the normal equation of the common skew. */
struct test_skew {
    double product[UNKNOWNS], with;
};

struct equations {
    /* X' W X, lower triangle. X holds the coefficients of the rows. W is the rows' inverse
     * covariance, divided by scatter^2 if the scatter (equations_scatter) exceeds 1. */
    double product[UNKNOWNS][UNKNOWNS];
    double with[UNKNOWNS];              /* X' W y, y the right-hand side */
    /* Attenuation: change of `with` by noise that a column and the right-hand side share. For gains
     * of pressures and lengths the member is the expected change, which is still in `with`. For all
     * other unknowns the expected change has been subtracted from `with`, and the member is its
     * standard deviation. */
    double attenuation[UNKNOWNS];
    double systematic[SYSTEMATICS];     /* prior standard deviation of each systematic error; 0:
                                         * there is no such error */
    /* Tests whose skews depart from the common one, and the largest standard deviation of such a
     * departure, s; 0: all tests share one skew. `product` and `with` hold no departures. */
    struct test_skew skew[SKEW_TESTS];
    int skews;
    double skew_test_s;
    /* Sum of squared residuals, weighted by W before its division by scatter^2. */
    double rest;
    /* Degrees of freedom of `rest`: number of rows less number of unknowns. Systematic errors and
     * coefficients of basis functions are random by their prior, and do not count; the matrix
     * counts as ten unknowns if its prior makes the payload rigid. */
    int free;
    /* Variance of `rest` by rounding errors that repeat in every cycle (rounding.h). */
    double repeating;
    /* Number of cycles of the shortest test; the noise of its rows is estimated from the
     * differences between its cycles. Infinite if all tests are segments, whose noise is known
     * well. */
    double cycles;
    double dry_n[LEGS];                 /* size of each leg's dry friction, N: the unit of its basis
                                         * functions' prior */
    /* Prior standard deviation of each spring, N/m and N m/rad; 0: no such spring is fitted. */
    double spring[DOFS];
    /* Scales of friction: rms of the varying part of a leg's force, and rms speed of a leg, each in
     * the leg and test where it is largest. */
    double force_n, rate_mps;
};

/* Solution of the equations. A prior keeps values finite that the data leave undetermined. The
 * prior of the matrix is given; the width of the basis functions' prior is found from all data
 * together (basis_sizes.h).
 *
 * With C = (X'WX + P)^-1, P = L L' the inverse covariance of the priors, shared errors of one
 * standard deviation change the values by the columns of -C L, and noise alone has the covariance C
 * less the sum of the outer products of these changes. The changes by gains also include the effect
 * of the gains' common scales, which are held at zero. */
struct estimate {
    double value[UNKNOWNS];
    double noise[UNKNOWN_BASIS][UNKNOWN_BASIS];  /* covariance by noise, without basis functions */
    double common[COMMON][UNKNOWN_BASIS];        /* change of `value` by each shared error of one
                                                  * standard deviation */
    double skew_test_s; /* standard deviation of the tests' skews about the common one, as found */
    /* compliance_prior: prior standard deviation of the compliance, narrowed to what the data show;
     * the unit of the compliance's shared error. compliance_std: standard deviation of the
     * estimated compliance with the stated prior. */
    double compliance_prior, compliance_std;
    double surprise[CALIBRATIONS]; /* reading of each calibration less the reading predicted from
                                    * motion and priors, in standard deviations of the difference;
                                    * 0: there was no reading */
};

/* Row and column of the matrix, from 0, with row <= column, for an unknown that is a matrix
 * entry. */
void equations_entry(int unknown, int *row, int *column);

/* Name of an unknown that is no basis function: "Mt15", "viscous leg 2", "dry leg 3 extending",
 * "spring theta", "gain of P1, leg 3". */
enum { EQUATIONS_NAME = SYSTEMATIC_NAME };
void equations_name(int unknown, char name[EQUATIONS_NAME]);

/* Rms residual of the coefficient rows, as a multiple of their noise. NaN unless there are more
 * rows than unknowns. */
double equations_scatter(const struct equations *e);

/* Prior variance, N^2, of the unknown UNKNOWN_BASIS + i. size: size of each kind of basis function,
 * as a multiple of the leg's dry friction. */
double equations_basis_variance(const struct equations *e, int i, const double size[BASIS_SIZE]);

/* Adds the equations of another log of the same machine and configuration. */
void equations_add(struct equations *sum, const struct equations *e);

/* Solves for the values without their covariance, and for the departure of each test's skew from
 * the common one, s. matrix: inverse covariance of the matrix entries' prior. Returns false if some
 * unknown occurs in no row, a value is not finite, or memory is short. */
bool equations_values(const struct equations *e, double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES], double value[UNKNOWNS],
                      double departure[SKEW_TESTS]);

/* Solves for the values and their covariance. matrix and the returned value are as in
 * equations_values(). */
bool equations_solve(const struct equations *e, double matrix[MATRIX_ENTRIES][MATRIX_ENTRIES], struct estimate *estimate);

/* Change of an unknown by one unit of a shared error. The unit is the same for several estimates,
 * although their priors of the compliance may differ: a compliance of `compliance` m/N, or one
 * standard deviation of any other error. */
double estimate_common(const struct estimate *e, int error, int unknown, double compliance);

/* Covariance of two unknowns, by noise and by shared errors. */
double estimate_covariance(const struct estimate *e, int a, int b);

#endif
