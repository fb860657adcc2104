/* Covariance of white residuals that allows for models that are not exact. Besides the noise, whose
 * variance is 1, each value has a remainder that no law of the catalogue explains. The remainder
 * has three parts of unknown size.
 *
 *   spread   differs from one repetition of the motion to the next; its spectrum, by channel and
 *            band of frequency, is that of the reference model's residuals (covariance_init)
 *   repeats  is a smooth function of position and speed, on a single axis; it is the same in all
 *            pieces of a record that repeat a motion, so many pieces are no more evidence than one
 *   law      is a share of the contribution of each family of effects, as no law is exact
 *
 * All models are compared under the same covariance, because otherwise a worse model would enlarge
 * the covariance that excuses it. Ordinary threads; heap. */
#ifndef HEXID_COVARIANCE_H
#define HEXID_COVARIANCE_H

#include "diagnose.h"

struct covariance_size {
    double spread, repeats; /* sizes of the parts `spread` and `repeats` of the remainder (above),
                             * as multiples of the size that the reference model's residuals
                             * show */
    double law;             /* error of the laws, as a share of a family's contribution, in addition
                             * to their own law_error */
};

struct covariance {
    int values, features;
    bool *evaluated;    /* [values] */
    double *spread;     /* [values]: variances of the spread, at size 1 */
    double *law, *least; /* [values], as variances. law: what a law error of 1 would add. least:
                          * what the effects' own law_error adds */
    double *feature;    /* [features][values]: functions of position and speed that make up the
                         * remainder's part `repeats`; if the size of this part is 1, the weight of
                         * each function has a standard deviation of 1 */
};

/* Finds the covariance. reference: a diagnosis whose whiteners contain noise alone, and whose model
 * is the reference model. data: the data whose white residuals have this covariance. */
void covariance_init(struct covariance *c, const struct diagnosis *reference, const struct fit_data *data);
void covariance_free(struct covariance *c);

/* Variance of a white value, with the noise but without the part `repeats`. */
double covariance_of(const struct covariance *c, const struct covariance_size *size, int value);

#endif
