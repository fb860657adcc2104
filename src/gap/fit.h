/* Fits model parameters to white residuals inside a box, by Gauss-Newton with steps shortened
 * until they improve the fit and an active set for the box. A value at its bound stays there.
 * During the search the base has no prior, so that no prior decides for or against an effect.
 * Ordinary threads; heap. */
#ifndef HEXID_FIT_H
#define HEXID_FIT_H

#include "whiten.h"

enum { FIT_VARIABLES = 160 };

/* One number of the model; leg -1: the same for all legs. */
struct variable {
    const char *name;        /* "hydraulics.bulk_modulus_pa" */
    size_t offset;           /* offset in struct params; of leg 0 if there are six */
    int leg, legs;           /* leg -1: all; legs 1: a single number, not a list */
    bool own;                /* affects only its own leg's residuals, in parts whose legs are
                              * independent (residual.h) */
    int effect, key;         /* switches this effect on; -1: none */
    bool base;               /* belongs to the base model: never a finding */
    double min, max;         /* the box */
    double neutral;          /* value of an effect's parameter without the effect */
    double prior_inverse_std; /* 1 / standard deviation of its prior about the neutral value,
                               * which decides if the data do not; 0: none */
    double step;             /* step of the difference quotient */
    enum residual_part parts;/* residuals that depend on it */
};

void variable_set(const struct variable *v, struct params *params, double value);
double variable_get(const struct variable *v, const struct params *params);

/* Data to fit: residuals of all tests, with their whiteners. */
struct fit_data {
    const struct residual_data *residual;
    struct whitener *whitener;    /* per test */
    int values;                   /* number of white values */
    int evaluated;                /* evaluated values; the others are zero */
    int threads;                  /* threads that evaluate tests or columns */
};

void fit_data_init(struct fit_data *d, const struct residual_data *residual, const struct params *model, int threads);
void fit_data_free(struct fit_data *d);

/* White residuals (d->values of them), or raw ones. False: the model cannot make this motion. */
bool fit_residual(const struct fit_data *d, const struct params *model, double *white);
bool fit_raw(const struct fit_data *d, const struct params *model, double *raw);
double fit_square(int n, const double *white); /* sum of squares */

/* White contribution of one effect of the model. False: the model is impossible without it, or
 * there is no memory. */
bool fit_part(const struct fit_data *d, const struct params *model, int effect, double *white);

/* Jacobian d white / d variable at the model, [variable][values]. raw: raw residuals there.
 * known: columns already computed, which are left alone; may be NULL. False: a moved model
 * cannot make this motion; the columns are then undefined. */
bool fit_columns(const struct fit_data *d, const struct params *model, const double *raw, int variables, const struct variable *v,
                 const double *const *known, double *column);

/* A variable's prior: 1 / its standard deviation, and the variable's distance from its mean. */
struct fit_prior {
    double inverse_std, off;
};

/* x minimises |r + sum x_i column_i|^2 + sum (pull_i (x_i + off_i))^2 with min <= x <= max, for
 * n columns of this many values. prior may be NULL; the deviations include it. False: singular. */
bool fit_box(int n, int values, const double *residual, const double *const *column, const struct fit_prior *prior, const double *min,
             const double *max, double *x, double *std);

struct fit_result {
    bool ok;
    double square;                      /* final sum of white squares, with the penalty of the
                                         * effects' priors; the base has no penalty */
    double std[FIT_VARIABLES];
};

/* Variables fitted linearly beside others: the rest of the model during a trial. */
struct linear_part {
    int n;
    const double *raw;                  /* residuals of the model without the others, from
                                         * fit_raw; differ by the others alone */
    const double *column;               /* [n][values] */
    const double *gram;        /* [n][n], from fit_gram; its ridge limits x and counts in the sum */
    const double *min, *max;
    const struct fit_prior *prior;
    double *x;                          /* result, relative to the model */
    double worth;             /* least predicted gain for which a step is taken, in white squares */
};
/* Gram matrix of the columns, [n][n]. */
void fit_gram(int n, int values, const double *column, double *gram);

/* Sum of white squares at a model with the linear part optimal, including the penalty of its
 * priors; infinite if the model cannot make this motion. raw, white: its residuals. */
double fit_start(const struct fit_data *d, const struct params *model, int variables, const struct variable *v,
                 const struct linear_part *linear, double *raw, double *white);

/* Factor of a change that, together with the linear part, brings white residuals closest to
 * zero; 0 if undetermined. */
double fit_share(const struct fit_data *d, const double *white, const double *change, const struct linear_part *linear);

/* Fits the variables starting from the model, which receives the result. known: constant
 * columns; NULL: computed in every iteration. raw: residuals at the start, if known. known,
 * linear and raw may be NULL. */
struct fit_result fit_model(const struct fit_data *d, struct params *model, int variables, const struct variable *v,
                            const double *const *known, const struct linear_part *linear, const double *raw, int iterations);

#endif
