/* Measurements of systematic errors that do not use the equations of motion, from the
 * configuration's section `found`:
 *
 *   weight  the relative error of a known weight's reading (weighing.h) is the sum of the
 *           pressures' gain errors, each times the pressure's share in the reading; it shows the
 *           gain error that all pressures have in common
 *   stop    the error of a leg's reading on its lower end stop is the zero of the leg's length,
 *           plus the length's gain error times the distance from neutral to the stop
 *
 * Each is one linear equation h' s = value in the vector s of the systematic errors, with an error
 * of standard deviation std. An estimate x of covariance C is corrected by Bayes' rule, the update
 * of a Kalman filter: K = C h / (h' C h + std^2), x + K (value - h'x), and the covariance (1 - K
 * h') C (1 - K h')' + K K' std^2. The common gains, which attenuation would bias (scale_of() in
 * equations.c), are held at zero while the equations are solved, and are corrected here. Pure. */
#ifndef HEXID_CALIBRATION_H
#define HEXID_CALIBRATION_H

#include "equations.h"
#include "kinematics.h"

struct calibration {
    double of[SYSTEMATICS]; /* h: change of the reading by one unit of each error */
    double value, std;      /* error of the reading (weight: relative; stop: m), and its standard
                             * deviation; std 0: there was no reading */
};

/* The gain error that all pressure sensors (or force sensors) have in common. No motion shows it:
 * it scales all forces, so masses, inertias and frictions are at best as exact as this gain. The
 * priors of the single gains are independent, so their mean has the standard deviation `std`. */
struct common_gain {
    int sensors;           /* number of sensors with a prior; 0: none, or a known weight was read */
    bool pressures;        /* the sensors measure pressures, not forces */
    double tolerance;      /* standard deviation of one gain, model.tolerance.pressure_gain */
    double std;            /* standard deviation of the mean */
};

/* Counts the sensors that have a gain error, and finds the standard deviation of their common gain
 * error. systematic: prior standard deviations, as in struct equations. */
struct common_gain calibration_common_gain(const struct params *params, const double systematic[SYSTEMATICS]);

/* Gathers the measurements that the configuration contains. */
void calibration_find(const struct params *params, const struct kinematics *k, struct calibration row[CALIBRATIONS]);

/* Corrects an estimate by one measurement. which: its index, CALIBRATION_WEIGHT or CALIBRATION_STOP
 * + leg. The coefficients of basis functions are not corrected. */
void calibration_learn(const struct calibration *row, int which, struct estimate *e);

/* Corrects an estimate by all measurements that the configuration contains. */
void calibration_apply(const struct params *params, const struct kinematics *k, struct estimate *e);

#endif
