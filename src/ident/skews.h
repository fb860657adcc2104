/* Skews of single tests. The common skew of lengths and pressures (systematic.h) is an unknown that
 * all tests of a machine share. If the devices' clocks run freely, or a recorder is started anew
 * for each test, a test's skew departs from the common one by a random value d of its own, of mean
 * zero.
 *
 * In the rows of test t the departure has the same column D as the common skew. With the other
 * unknowns x, all tests together minimise
 *
 *   |y - X x - D d|^2_W + x' P x + d' d / size^2
 *
 * so that d = (D'WD + 1/size^2)^-1 D'W (y - X x), and the other unknowns' normal equations become
 * X'WX - X'WD (D'WD + 1/size^2)^-1 D'WX and X'Wy - X'WD (D'WD + 1/size^2)^-1 D'Wy: the departures
 * are eliminated. This is generalised least squares with the rows' covariance W^-1 + D D' size^2.
 *
 * The size, at most model.tolerance.skew_test_s, is found from the data, by the iteration of
 * basis_sizes.h: at the maximum of the likelihood size^2 is sum d^2, divided by the number of
 * departures that the data determine, sum (1 - variance / size^2). If all tests do share one skew,
 * the departures then hardly cost accuracy. Pure, no heap. */
#ifndef HEXID_SKEWS_H
#define HEXID_SKEWS_H

#include "equations.h"

/* Returns the equation of the common skew as it is now. */
struct test_skew skews_now(const struct equations *e);

/* Adds a test, whose rows are those that were added to the equations since `before`. The departure
 * of a test beyond SKEW_TESTS is eliminated at once, with the size skew_test_s, and its value is
 * not found. */
void skews_add(struct equations *e, const struct test_skew *before);

/* Adds the tests of another log, whose rows are in the sum already. */
void skews_join(struct equations *sum, const struct equations *e);

/* Finds the size of the departures, s; 0: there are none. factor: Cholesky factor of X'WX + P, P
 * the inverse covariance of the priors, with no departure eliminated. */
double skews_size(const struct equations *e, double factor[UNKNOWNS][UNKNOWNS]);

/* Eliminates the departures of this size from `product` and `with`; the list of tests stays. */
void skews_eliminate(struct equations *e, double size);

/* Finds the departures, s, for given values of the unknowns. */
void skews_departures(const struct equations *e, double size, const double value[UNKNOWNS], double departure[SKEW_TESTS]);

#endif
