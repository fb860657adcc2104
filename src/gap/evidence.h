/* Evidence for a model by Laplace's approximation (MacKay 1992): the probability density of the
 * measured residuals, averaged over the priors of the model's values. Ordinary threads; heap. */
#ifndef HEXID_EVIDENCE_H
#define HEXID_EVIDENCE_H

#include "covariance.h"
#include "held.h"

/* A model, linearised where it was fitted. Residuals that are not evaluated are left out. */
struct linearised {
    int rows, variables;
    double *white;  /* [rows]: residuals in units of the noise */
    double *column; /* [variables][rows]: Jacobian of the residuals */
    /* For each variable. inverse_std: 1 / standard deviation of its prior; for a uniform prior,
     * that of a normal distribution with the same density. off: distance of the variable's value
     * from the prior's mean; 0 for a uniform prior */
    double inverse_std[FIT_VARIABLES], off[FIT_VARIABLES];
    bool uniform[FIT_VARIABLES];
    double least[FIT_VARIABLES], most[FIT_VARIABLES]; /* changes that move the value to the lower
                                                       * end of its range, <= 0, and to the upper
                                                       * end */
    struct held held;               /* friction of legs that may be held */
    int one_sided; /* number of variables whose prior is half a normal distribution */
};

/* Takes the linearisation of a diagnosis. variance: [values], the variances that the whiteners of d
 * assume, relative to those of the noise. */
void linearised_init(struct linearised *l, const struct diagnosis *d, const struct covariance *c, const double *variance);
void linearised_free(struct linearised *l);

/* Returns the log evidence of a model under a covariance, without a constant that all models share.
 * change: [variables], set to the most probable changes of the values. std: [variables], set to
 * their standard deviations; it is left unchanged if there are fewer rows than variables and
 * features of the covariance together, or if the normal equations are singular. Either may be
 * NULL. */
double evidence_of(const struct linearised *l, const struct covariance *c, const struct covariance_size *size, double *change, double *std);

#endif
