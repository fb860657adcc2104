#include "goodness.h"

#include <math.h>
#include <stdlib.h>

#include "memory.h"

static const double NOISE_SQUARE = 0.8;  /* largest mean square of white residuals that counts as
                                          * noise. There are two reasons why it is below 1. A third
                                          * of the assumed variance is an allowance for modelling
                                          * error (BASE_ERROR). Half of the scatter of the cycles is
                                          * true motion, which the equations follow. Measured: 0.4
                                          * to 0.6 */
static const double SCATTER = 6.0;       /* allowance above NOISE_SQUARE, in standard deviations of
                                          * the mean square */
static const double LAW_SIGMAS = 4.0;    /* largest deviation from its law that an effect may show,
                                          * in multiples of the effect's law_error */
static const double FEW_CYCLES = 10.0;   /* allowance in place of the mean square of Student's t
                                          * from two or three cycles, which is infinite */

/* Mean square of the values of one row, which is one residual of one leg. Only evaluated values
 * count, which are those with a noise above 0. */
static double mean_square(const double *part, const double *noise) {
    double sum = 0.0, rows = 0.0;
    for (int a = 0; a < RESIDUAL_SIZE; a++)
        if (noise[a] > 0.0) sum += part[a] * part[a], rows++;
    return rows ? sum / rows : 0.0;
}

/* Square of the possible error of the effects' laws in each held-out value. noise: variances of the
 * values; if not NULL, a leg's friction also adds the mean of each row to all values of that row,
 * because a seal's friction varies along the stroke. */
static double *law_errors(const struct diagnosis *d, const double *noise) {
    size_t values = (size_t)d->held_out.values;
    double *sum = memory_get(values, sizeof *sum), *part = memory_get(values, sizeof *part);
    for (int e = 0; effect_table[e]; e++) {
        double square = pow(effect_table[e]->law_error, 2.0), along = 0.0;
        if (!(d->given->effects[e].on || d->found[e]) || !fit_contribution(&d->held_out, &d->model, e, part)) continue;
        for (size_t i = 0; i < values; i++) {
            if (noise && effect_table[e]->leg_friction && i % RESIDUAL_SIZE == 0) along = mean_square(part + i, noise + i);
            sum[i] += square * (part[i] * part[i] + along);
        }
    }
    free(part);
    return sum;
}

double goodness_law_error(const struct diagnosis *d) {
    double *error = law_errors(d, NULL), sum = 0.0;
    for (int i = 0; i < d->held_out.values; i++) sum += error[i];
    free(error);
    return sum;
}

/* Mean square of noise in units of a standard deviation that was estimated from the scatter of this
 * many cycles (Student's t). 0 cycles: the estimate comes from all samples. */
static double student(int cycles) { return !cycles ? 1.0 : cycles > 3 ? (cycles - 1.0) / (cycles - 3.0) : FEW_CYCLES; }

/* Largest weighted sum of squared white residuals that noise gives. weights: sum over the values of
 * each value's weight times its noise variance. squares: sum of the squares of these products. */
static double noise_at_most(double weights, double squares) { return NOISE_SQUARE * weights + SCATTER * sqrt(2.0 * squares); }

double goodness_noise(const struct diagnosis *d) {
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < d->odd.tests; i++) {
        double one = student(d->odd.test[i].spectrum.cycles);
        sum += one * d->held_out.whitener[i].values, squares += one * one * d->held_out.whitener[i].values;
    }
    return noise_at_most(sum, squares);
}

/* Weighted sum of squared white residuals, divided by the most that noise and laws explain. A
 * weight is (1 + variance of the laws' error, in units of the noise)^-power, or 0 without noise. */
static double weigh(int rows, const double *white, const double *noise, const double *law, double power) {
    double left = 0.0, laws = 0.0, sum = 0.0, squares = 0.0;
    for (int i = 0; i < rows; i++) {
        double doubt = LAW_SIGMAS * LAW_SIGMAS * law[i], weight = noise[i] > 0.0 ? pow(1.0 + doubt, -power) : 0.0;
        left += weight * white[i] * white[i], laws += weight * doubt;
        sum += weight * noise[i], squares += pow(weight * noise[i], 2.0);
    }
    return left / (noise_at_most(sum, squares) + laws);
}

double goodness_weigh(int rows, const double *white, const double *noise, const double *law) {
    return fmax(weigh(rows, white, noise, law, 1.0), weigh(rows, white, noise, law, 2.0));
}

double goodness_beyond_laws(const struct diagnosis *d) {
    enum { ROWS = sizeof(residual_row) / sizeof(double) };
    size_t values = (size_t)d->held_out.values;
    double *white = memory_get(values, sizeof *white), *noise = memory_get(values, sizeof *noise);
    for (int i = 0; i < d->held_out.values; i++) {
        int row = i % ROWS, leg = row / RESIDUAL_SIZE / RESIDUALS, kind = row / RESIDUAL_SIZE % RESIDUALS;
        bool evaluated = d->held_out.whitener[i / ROWS].inverse[leg][row % RESIDUAL_SIZE][kind][kind] > 0.0;
        noise[i] = evaluated ? student(d->odd.test[i / ROWS].spectrum.cycles) : 0.0;
    }
    double *law = law_errors(d, noise);
    bool moves = fit_residual(&d->held_out, &d->model, white);
    double beyond = moves ? goodness_weigh(d->held_out.values, white, noise, law) : (double)INFINITY;
    free(law);
    free(white);
    free(noise);
    return beyond;
}
