/* Measurements of systematic errors that no motion shows, as the configuration's section `found`
 * has them:
 *
 *   weight  the reading of a known weight (weighing.h) is off by the sum of the pressures' gains,
 *           each times its share: it finds the gain that all pressures have in common
 *   stop    a leg on its lower end stop reads its zero and, by its gain, what it is shorter there
 *           than at neutral
 *
 * Each is one linear equation in the systematic errors s, h's = value within a standard deviation.
 * An estimate x of covariance C learns from it by Bayes' rule, the update of a Kalman filter:
 * K = C h / (h' C h + std^2), x + K (value - h'x), and the covariance (1 - K h') C (1 - K h')' +
 * K K' std^2. What attenuation pulls along (equations.h) is held while the equations are solved,
 * and moves here. Pure. */
#ifndef HEXID_CALIBRATION_H
#define HEXID_CALIBRATION_H

#include "equations.h"
#include "kinematics.h"

struct calibration {
    double of[SYSTEMATICS]; /* h: change of the reading for a unit of each error */
    double value, std;      /* the reading; std 0: it was not taken */
};

/* Gathers the measurements that the configuration holds. */
void calibration_find(const struct params *params, const struct kinematics *k, struct calibration row[CALIBRATIONS]);

/* Lets an estimate learn from one measurement, number `which`. Values of basis functions stay. */
void calibration_learn(const struct calibration *row, int which, struct estimate *e);

/* Lets an estimate learn from all measurements that the configuration holds. */
void calibration_apply(const struct params *params, const struct kinematics *k, struct estimate *e);

#endif
