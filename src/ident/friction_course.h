/* What is known of dry friction along a test before any force is asked: the direction in which each
 * leg moves, how sure that is, and the shapes that dry friction may have beside the constant of
 * each direction. Per newton of dry friction.
 *
 * The speed is that of the mean cycle, each harmonic shrunk by what its noise is of it (Wiener):
 * the higher ones of a steady test are mostly noise, and would turn a slow leg round where it does
 * not. It is also a speed in finitely many harmonics, which lags behind the leg's own where
 * friction turns round: that takes 2 F / m from the acceleration at once, and the mean of a speed
 * over some time about such a kink passes zero later than the speed itself, by anything between
 * nothing (F small against m a) and that time (a leg that stops), never earlier. So friction goes
 * by the speed half a resolution later; of a piece of any motion, which is no mean, by the speed,
 * give or take a resolution. A reversal is blurred by three things, independent of each
 * other: the speed's noise; that lag, uniform from none to the whole resolution; and stick, below
 * INVERSE_DYNAMICS_SLOW_MPS, during which friction is on its way from one direction to the other
 * by what all other forces do. So the direction is, on average, erf(v / sqrt(2 s^2)), s^2 the sum
 * of the three variances, and whatever its course between -1 and 1, its variance is at most
 * 1 - average^2.
 *
 * How long an error lasts: one reversal at a random instant of distribution G, which is the
 * worst of all monotone ways from -1 to 1, has the covariance 4 G(t) (1 - G(u)), t < u, that is
 * sqrt(1 - m^2) at both, times exp(-|atanh m(u) - atanh m(t)|). That is a Markov process in
 * atanh m, and so are reversals in a row. A leg that hardly moves at all, of which no reversal
 * is seen, forgets at the rate at which the others turn round (Rice 1945): rms acceleration over
 * rms speed. Pure. */
#ifndef HEXID_FRICTION_COURSE_H
#define HEXID_FRICTION_COURSE_H

#include "equations.h"
#include "inverse_dynamics.h"
#include "residual.h"

struct friction_course {
    double rate_mps[PHASES][LEGS];
    double direction[PHASES][LEGS];                     /* average, -1..1 */
    double doubt[PHASES][LEGS];                         /* 1 - direction^2, also where that is
                                                         * lost in rounding */
    double lasting[PHASES][LEGS];                       /* errors at two phases are alike by
                                                         * exp(-|difference|), */
    double round[LEGS];                                 /* and of a cycle the other way round: its
                                                         * whole length; else infinite */
    double shape[UNKNOWN_SHAPES][PHASES][LEGS];
};

/* P1 + P2 on average, of all tests and legs; 0: not measured. */
double friction_course_load(const struct residual_data *d);

/* load_pa: the P1 + P2 at which friction that goes with the pressures is part of Coulomb's, one for
 * all tests: with a mean of each test's own, Coulomb's friction would differ between them. 0:
 * pressures are not measured. */
void friction_course_find(struct friction_course *c, const struct residual_test *t, const struct params *params, double load_pa);

/* Of the row that a leg's friction of 1 N makes. */
void friction_course_covariance(const struct friction_course *c, const struct residual_test *t, int leg,
                                double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE]);

#endif
