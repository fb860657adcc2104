/* Fits of model parameters to white residuals inside a hard box (Gauss-Newton; a step that does
 * not improve the fit is shortened; the box by active sets). A value at its bound stays there.
 * While names are sought the base has no prior, so that none decides for or against an effect.
 * Ordinary threads; heap. */
#ifndef HEXID_FIT_H
#define HEXID_FIT_H

#include "whiten.h"

enum { FIT_VARIABLES = 160 };

/* One number of the model. All legs alike where leg is -1. */
struct variable {
    const char *name;        /* "hydraulics.bulk_modulus_pa" */
    size_t offset;           /* in struct params; of leg 0 where there are six */
    int leg, legs;           /* leg -1: all; legs 1: no list */
    bool own;                /* moves the residuals of its own leg alone, where
                              * legs are apart (residual.h) */
    int effect, key;         /* switched on with it; -1: none */
    bool base;               /* belongs to the base model: never a finding */
    double min, max;         /* the box */
    double neutral;          /* of an effect: the value without the effect */
    double prior_inverse_std; /* 1 / standard deviation of its prior, which is about the neutral
                              * value and decides where the data do not; 0: none */
    double step;             /* step of the difference quotient */
    enum residual_part parts;/* residuals that depend on it */
};

void variable_set(const struct variable *v, struct params *params, double value);
double variable_get(const struct variable *v, const struct params *params);

/* Data to fit: residuals of all tests with their whiteners. */
struct fit_data {
    const struct residual_data *residual;
    struct whitener *whitener;    /* per test */
    int values;                   /* white values in all */
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

/* Columns of d white / d variable at the model, [variable][values]. raw: the residuals there, not
 * white. known: those that are there already, whose place stays as it is; or NULL. False: a moved
 * model cannot make this motion; then the columns are undefined. */
bool fit_columns(const struct fit_data *d, const struct params *model, const double *raw, int variables, const struct variable *v,
                 const double *const *known, double *column);

/* A variable's prior: 1 / its standard deviation, and how far the variable is from its mean. */
struct fit_prior {
    double inverse_std, off;
};

/* x minimises |r + sum x_i column_i|^2 + sum (pull_i (x_i + off_i))^2 with min <= x <= max. n
 * columns of so many values. prior may be NULL; the deviations have it in. False when singular. */
bool fit_box(int n, int values, const double *residual, const double *const *column, const struct fit_prior *prior, const double *min,
             const double *max, double *x, double *std);

struct fit_result {
    bool ok;
    double square;                      /* at the end: of white residuals, and what values of
                                         * effects cost by their priors; the base costs nothing */
    double std[FIT_VARIABLES];
};

/* Variables that are fitted beside others, but linearly: the rest of the model while a
 * hypothesis is tried. */
struct linear_part {
    int n;
    const double *raw;                  /* residuals of the model without the others, from fit_raw:
                                         * these differ in the others alone */
    const double *column;               /* [n][values] */
    const double *gram;                 /* [n][n], from fit_gram; a ridge on it holds them back,
                                         * and counts */
    const double *min, *max;
    const struct fit_prior *prior;
    double *x;                          /* result, from where the model is */
    double worth;                       /* white squares that a step has to promise to be taken */
};
/* Products of columns with each other, [n][n]. */
void fit_gram(int n, int values, const double *column, double *gram);

/* Sum of white squares at a model with the linear part at its best, the cost of its priors
 * included; infinite where it cannot make this motion. raw, white: its residuals. */
double fit_start(const struct fit_data *d, const struct params *model, int variables, const struct variable *v,
                 const struct linear_part *linear, double *raw, double *white);

/* How much of a change brings white residuals closest to zero, the linear part moved along; 0
 * where nothing tells. */
double fit_share(const struct fit_data *d, const double *white, const double *change, const struct linear_part *linear);

/* Fits the variables from where the model is; the result is in the model. known: columns that hold
 * all the way; NULL: computed at every iteration. raw: the residuals there, where they are known.
 * known, linear and raw may be NULL. */
struct fit_result fit_model(const struct fit_data *d, struct params *model, int variables, const struct variable *v,
                            const double *const *known, const struct linear_part *linear, const double *raw, int iterations);

#endif
