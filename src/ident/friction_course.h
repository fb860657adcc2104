/* What is known of dry friction along a test before any force is evaluated: the direction in which
 * each leg moves, how sure that is, and the shapes that dry friction may have beside a constant for
 * each direction. Per newton of dry friction.
 *
 * The speed is that of the mean cycle, each harmonic shrunk by its share of noise (Wiener): the
 * higher ones of a steady test are mostly noise, and would reverse a slow leg where it does not. A
 * speed in finitely many harmonics also lags behind the leg's own where friction reverses: that
 * takes 2 F / m from the acceleration at once, and the mean of a speed over some time about such a
 * kink passes zero later than the speed itself, by anything between nothing (F small against m a)
 * and that time (a leg that stops), never earlier. So the direction of friction is that of the
 * speed half a resolution later; of a piece of any motion, which is no mean, that of the speed,
 * give or take a resolution. A reversal is blurred by three things, independent of each other: the
 * speed's noise; that lag, uniform from none to the whole resolution; and stick, below
 * INVERSE_DYNAMICS_SLOW_MPS, during which friction goes from one direction to the other as all
 * other forces demand. So the direction is, on average, erf(v / sqrt(2 s^2)), s^2 the sum of the
 * three variances, and whatever its course between -1 and 1, its variance is at most 1 - average^2.
 *
 * How long an error lasts: let m be that average, and let friction jump once from -1 to 1 at a
 * random instant of distribution G = (1 + m) / 2, the worst of all monotone courses. Its covariance
 * 4 G(t) (1 - G(u)), t < u, is the product of sqrt(1 - m^2) at t and at u, times exp(-|atanh m(u) -
 * atanh m(t)|). That is a Markov process in atanh m, and so are reversals in a row. A leg that
 * hardly moves, of which no reversal is seen, forgets at the rate at which the legs reverse (Rice
 * 1945): rms acceleration over rms speed. Pure. */
#ifndef HEXID_FRICTION_COURSE_H
#define HEXID_FRICTION_COURSE_H

#include "equations.h"
#include "inverse_dynamics.h"
#include "residual.h"

struct friction_course {
    double rate_mps[PHASES][LEGS];
    double direction[PHASES][LEGS];                     /* average, -1..1 */
    double doubt[PHASES][LEGS];                         /* 1 - direction^2, without loss to
                                                         * rounding */
    double lasting[PHASES][LEGS];                       /* errors at two phases correlate by
                                                         * exp(-|difference|), */
    double round[LEGS];                                 /* and of a cycle also the other way round:
                                                         * its whole length; a piece: infinite */
    double shape[UNKNOWN_SHAPES][PHASES][LEGS];
};

/* Mean P1 + P2 of all tests and legs, Pa; 0: not measured. */
double friction_course_load(const struct residual_data *d);

/* load_pa: the P1 + P2 at which friction that goes with the pressures is wholly part of Coulomb's,
 * one for all tests: with a mean of each test's own, Coulomb's friction would differ between them.
 * 0: pressures are not measured. */
void friction_course_find(struct friction_course *c, const struct residual_test *t, const struct params *params, double load_pa);

/* Covariance of the row that a leg's friction of 1 N makes, from the uncertain direction. */
void friction_course_covariance(const struct friction_course *c, const struct residual_test *t, int leg,
                                double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE]);

#endif
