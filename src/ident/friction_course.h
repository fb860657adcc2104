/* Dry friction as far as the motion alone determines it: each leg's direction of motion, how
 * certain this direction is, and the basis functions of dry friction beside a constant for each
 * direction. All values are for one newton of dry friction.
 *
 * The speed is that of the mean cycle, each harmonic reduced by its share of noise (Wiener),
 * because the higher harmonics of a steady test are mostly noise and would add false reversals of a
 * slow leg. A speed of finitely many harmonics is a mean over some time, its resolution. Such a
 * mean also lags where a leg reverses, because a friction F that reverses changes the leg's
 * acceleration a at once, by 2 F / m. The mean then passes zero later than the speed itself; the
 * lag is between zero (if F is small against m a) and a whole resolution (if the leg stops). So
 * friction is given the sign that the mean speed has half a resolution later. A segment's series is
 * no mean cycle: for it no lag is assumed, and the reversal is uncertain by one resolution to
 * either side.
 *
 * The instant of a reversal is uncertain for three independent reasons: the speed's noise; the lag,
 * uniform from zero to the whole resolution; and stick, below INVERSE_DYNAMICS_SLOW_MPS, where
 * friction takes whatever value balances all other forces. So the mean direction is erf(v / sqrt(2
 * s^2)), s^2 the sum of the three variances. The direction stays between -1 and 1, so its variance
 * is at most 1 - mean^2, whatever its course.
 *
 * The errors are correlated in time. Let m be the mean direction, and let friction jump once from
 * -1 to 1 at a random instant of distribution G = (1 + m) / 2, the worst of all monotone courses.
 * The covariance 4 G(t) (1 - G(u)), t < u, is the product of sqrt(1 - m^2) at t and at u, times
 * exp(-|atanh m(u) - atanh m(t)|). This is a Markov process in atanh m, and so are several
 * reversals in a row. A leg that hardly moves shows no reversals; its errors decay at the rate at
 * which the legs reverse (Rice 1945): rms acceleration over rms speed. Pure. */
#ifndef HEXID_FRICTION_COURSE_H
#define HEXID_FRICTION_COURSE_H

#include "equations.h"
#include "inverse_dynamics.h"
#include "residual.h"

struct friction_course {
    double rate_mps[PHASES][LEGS];
    double direction[PHASES][LEGS];                     /* mean direction of each leg, -1..1 */
    /* Variance of the direction, 1 - direction^2, computed without cancellation. */
    double doubt[PHASES][LEGS];
    /* Sum of the magnitudes of all changes of atanh(direction) since the first phase, plus the time
     * times the rate at which the legs reverse. Errors at two phases correlate by exp(-|difference
     * of `lasting`|). */
    double lasting[PHASES][LEGS];
    /* Change of `lasting` over a whole cycle; as a cycle repeats, its errors also correlate across
     * its end. Infinite for a segment. */
    double round[LEGS];
    double basis[BASIS_SIZE][PHASES][LEGS];
};

/* Mean of P1 + P2 over all tests and legs, Pa; 0 if pressures are not measured. */
double friction_course_load(const struct residual_data *d);

/* Finds the directions and the basis functions of one test. load_pa: P1 + P2 at which friction that
 * grows with the pressures counts entirely as Coulomb friction; 0 if pressures are not measured.
 * All tests need the same value, so that they have one Coulomb friction in common. */
void friction_course_find(struct friction_course *c, const struct residual_test *t, double load_pa);

/* Computes the covariance that the uncertain direction gives to the coefficient row of a leg's dry
 * friction, for a dry friction of 1 N. */
void friction_course_covariance(const struct friction_course *c, const struct residual_test *t, int leg,
                                double covariance[RESIDUAL_SIZE][RESIDUAL_SIZE]);

#endif
