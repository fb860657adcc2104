/* Fits model parameters to white residuals inside a box, by Gauss-Newton steps that are damped
 * until they improve the fit. An active set keeps variables at the bounds of the box. During the
 * search the only base variables with a prior are the errors of sensors and those that are
 * PARALLEL_DRAWN (hypothesis.h), so that no other prior decides for or against an effect. Ordinary
 * threads; heap. */
#ifndef HEXID_FIT_H
#define HEXID_FIT_H

#include "whiten.h"

/* LINEAR_BESIDE: most variables that a fit moves beside a linear part of FIT_VARIABLES. */
enum { FIT_VARIABLES = 224, LINEAR_BESIDE = 48 };

/* One number of the model that is fitted. */
struct variable {
    const char *name;        /* configuration key, such as "hydraulics.bulk_modulus_pa"; for an
                              * effect, name of its key; for a sensor's error, name of its kind */
    size_t offset;           /* offset in struct params of the number, or of the first in a list */
    /* leg: the only leg to which the variable belongs, or -1: all legs have the same value. legs:
     * length of the list of numbers; 1: there is a single number. */
    int leg, legs;
    bool own;                /* affects only its own leg's residuals, in equations whose legs are
                              * independent (residual_legs_apart) */
    /* effect: index of the effect to which the variable belongs, and which variable_set() switches
     * on; -1: none. key: number of the variable's key in the effect. */
    int effect, key;
    bool base;               /* part of the base model, so never a finding */
    bool penalised;          /* base variable that is the error of a sensor; its prior counts in the
                              * sum of squares, as that of an effect does */
    double min, max;         /* bounds of the value */
    double neutral;          /* value at which an effect's parameter has no effect; mean of the
                              * prior */
    double prior_inverse_std; /* 1 / standard deviation of the prior, which decides where the data
                               * do not; 0: no prior */
    double step;             /* change of the value in difference quotients */
    enum residual_equations equations;/* equations of the residuals that depend on the variable */
};

void variable_set(const struct variable *v, struct params *params, double value);
double variable_get(const struct variable *v, const struct params *params);

/* Data to fit: the residuals of all tests, and their whiteners. */
struct fit_data {
    const struct residual_data *residual;
    struct whitener *whitener;    /* [tests] */
    int values;                   /* number of white values, counted over all tests */
    int evaluated;                /* number of white values that are evaluated; the others are
                                   * zero */
    int threads;                  /* number of threads, which evaluate tests or columns */
};

void fit_data_init(struct fit_data *d, const struct residual_data *residual, const struct params *model, int threads);
void fit_data_free(struct fit_data *d);

/* Computes a model's residuals, d->values numbers: fit_residual() white ones, fit_raw() raw ones.
 * Returns false if the model cannot make the measured motion. */
bool fit_residual(const struct fit_data *d, const struct params *model, double *white);
bool fit_raw(const struct fit_data *d, const struct params *model, double *raw);
double fit_square(int n, const double *white); /* sum of squares of white residuals */

/* Computes the contribution of one effect to a model's white residuals. Returns false if the model
 * cannot make the measured motion, with the effect or without it. */
bool fit_contribution(const struct fit_data *d, const struct params *model, int effect, double *white);

/* Computes the Jacobian of the white residuals at the model, [variables][values]. raw: the model's
 * raw residuals. known: [variables], an existing column, which is not computed, or NULL for each
 * variable; `known` itself may be NULL. Returns false if a moved model cannot make the measured
 * motion; the columns are then undefined. */
bool fit_columns(const struct fit_data *d, const struct params *model, const double *raw, int variables, const struct variable *v,
                 const double *const *known, double *column);

/* Prior of a variable: 1 / standard deviation, and the present distance of the variable from the
 * prior's mean. */
struct fit_prior {
    double inverse_std, off;
};

/* Finds x with min <= x <= max that minimises |residual + sum x_i column_i|^2 + sum (inverse_std_i
 * (x_i + off_i))^2, for n columns of `values` values. std: standard deviations of x, prior
 * included; may be NULL. prior may be NULL. Returns false if the equations are singular. */
bool fit_box(int n, int values, const double *residual, const double *const *column, const struct fit_prior *prior, const double *min,
             const double *max, double *x, double *std);

struct fit_result {
    bool ok;                            /* false: the model at the start cannot make the measured
                                         * motion, or the columns that fit_model() is to return
                                         * cannot be computed */
    double square;                      /* sum of squared white residuals at the end, with the
                                         * penalty of the priors of effects, of penalised base
                                         * variables and of the linear part */
    double std[FIT_VARIABLES];
};

/* Variables that a fit moves linearly, besides its own variables. In a trial they are the variables
 * of the model without the hypothesis. */
struct linear_part {
    int n;
    const double *raw;                  /* raw residuals of the model at x = 0; this model differs
                                         * from the fitted one only in the values of the fit's own
                                         * variables */
    const double *column;               /* [n][values]: Jacobian of the white residuals */
    const double *gram;        /* [n][n]: from fit_gram, plus a ridge that limits x and counts in
                                * the sum of squares */
    const double *min, *max;
    const struct fit_prior *prior;
    double *x;                          /* [n]: changes of the variables from the model at x = 0; on
                                         * entry the start of the solution, then the result */
    double worth;             /* least predicted gain, in squared white residuals, for which another
                               * step is taken */
};
/* Gram matrix of the columns, [n][n]. */
void fit_gram(int n, int values, const double *column, double *gram);

/* Sum of squared white residuals of a model, with the linear part at its optimum. The penalty of
 * the linear part's priors is in the sum, that of the priors of v is not. INFINITY if the model
 * cannot make the measured motion, or if the linear part is not determined. raw, white: set to the
 * model's residuals without the linear part. */
double fit_start(const struct fit_data *d, const struct params *model, int variables, const struct variable *v,
                 const struct linear_part *linear, double *raw, double *white);

/* Factor on `change`, a change of the white residuals, with which the residuals come closest to
 * zero, if the linear part moves too; 0 if undetermined. */
double fit_share(const struct fit_data *d, const double *white, const double *change, const struct linear_part *linear);

/* Fits the variables, starting from `model`, which receives the result. known: columns that stay
 * constant; NULL: all columns are computed. raw: raw residuals at the start, if they are known.
 * sets: largest number of times that the columns of all variables are computed for steps. Without a
 * linear part, columns of the base may serve several steps; those that are computed the last time
 * serve one step. column: [variables][values], set to the columns that are not known, at the result
 * or so near it that they hold there; result.ok is false if they cannot be computed. known, linear,
 * raw and column may be NULL. */
struct fit_result fit_model(const struct fit_data *d, struct params *model, int variables, const struct variable *v,
                            const double *const *known, const struct linear_part *linear, const double *raw, int sets, double *column);

#endif
