/* Covariance of white residuals in which no model is exact. Beside the noise, whose variance is 1,
 * each value has a remainder: what no law of the catalogue makes. It has three parts, each with a
 * size that is not known.
 *
 *   spread   does not repeat with the motion; its spectrum, by channel and band of frequency, is
 *            that of the residuals that the richest good model leaves
 *   repeats  is a smooth function of position and speed, of an axis; so it is the same in all
 *            pieces of a record that repeat a motion, and many pieces are no more evidence than one
 *   law      is a share of what each family of effects contributes, as no law is exact
 *
 * All models are compared under the same covariance, because otherwise a worse model would buy its
 * own excuse. Ordinary threads; heap. */
#ifndef HEXID_COVARIANCE_H
#define HEXID_COVARIANCE_H

#include "diagnose.h"

struct covariance_size {
    double spread, repeats; /* times the size that the residuals of the reference show */
    double law;             /* share of a family's contribution, beside the laws' own law_error */
};

struct covariance {
    int values, features;
    bool *evaluated;    /* [values] */
    double *spread;     /* [values]: variances of the spread of size 1 */
    double *law, *least; /* [values]: variances by a law error of 1, and by the effects'
                          * law_error */
    double *feature;    /* [features][values]: functions of position and speed, each with a weight
                         * of standard deviation 1 at size 1 */
};

/* Finds the covariance from a diagnosis whose whiteners are those of noise alone: the reference is
 * its model. */
void covariance_init(struct covariance *c, const struct diagnosis *reference, const struct fit_data *data);
void covariance_free(struct covariance *c);

/* Variance of a value, the noise included and the repeating part left out. */
double covariance_of(const struct covariance *c, const struct covariance_size *size, int value);

#endif
