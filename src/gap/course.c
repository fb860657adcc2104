#include "course.h"

#include <math.h>
#include <stdlib.h>

#include "memory.h"

/* The factor on the friction, factor(), differs between tests even if the friction is constant,
 * because the error of a slightly wrong law depends on the test's speed. A Stribeck friction with a
 * wrong exponent gives factors that differ by 15 %. */
static const double RATIO = 1.2;  /* least ratio of two tests' factors that is reported */
static const double SIGMAS = 6.0; /* least difference of two factors that is reported, in standard
                                   * deviations of the difference */

/* Sums over the rows of a test. square: squared changes of the residuals by the friction. white:
 * squared residuals. product: products of change and residual. values: number of values. */
struct sums {
    double square, product, white, values;
};

/* Factor on the friction with which a test's sum of squared residuals is least. */
static double factor(const struct sums *s) { return 1.0 - s->product / s->square; }

static double factor_std(const struct sums *s) { return sqrt(fmax(s->white / s->values, 1.0) / s->square); }

static void add_rows(const struct diagnosis *d, const double *change, const double *white, struct sums sum[RECORDING_TESTS]) {
    enum { ROW = sizeof(residual_row) / sizeof(double) };
    for (int i = 0; i < d->held_out.values; i++) {
        const struct residual_test *t = &d->odd.test[i / ROW];
        struct sums *s = &sum[t->of];
        /* Segments, which are no steady sinusoids, are left out, because their speeds differ too
         * much. */
        if (!t->spectrum.cycles || !(change[i] != 0.0)) continue;
        s->square += change[i] * change[i], s->product += change[i] * white[i];
        s->white += white[i] * white[i], s->values++;
    }
}

/* Finds the two steady tests whose factors have the largest ratio, among pairs that clearly differ.
 * If the smaller factor is less than its standard deviation, the standard deviation takes its
 * place, and the reported ratio is a lower bound. */
static struct gap_course compare(const struct sums sum[RECORDING_TESTS], const struct recording *recording) {
    struct gap_course course = {0};
    for (int i = 0; i < recording->tests; i++)
        for (int j = 0; j < recording->tests; j++) {
            if (!(sum[i].square > 0.0) || !(sum[j].square > 0.0)) continue;
            double most = factor(&sum[i]), least = fmax(factor(&sum[j]), factor_std(&sum[j]));
            double apart = (most - factor(&sum[j])) / hypot(factor_std(&sum[i]), factor_std(&sum[j]));
            if (!(apart > SIGMAS) || !(most > fmax(RATIO, course.ratio) * least)) continue;
            const struct recording_test *a = &recording->test[i], *b = &recording->test[j];
            course = (struct gap_course){
                .ratio = most / least, .at_least = least > factor(&sum[j]), .most = {a->test, a->dof}, .least = {b->test, b->dof}};
        }
    return course;
}

/* True for a dry friction of the legs, whose strength cannot be negative. The strength of viscous
 * friction can, because it is a difference from the configured viscous friction. */
static bool is_dry(const struct effect *e) { return e->leg_friction && e->keys[0].min >= 0.0; }

struct gap_course course_find(const struct diagnosis *d, const struct recording *recording) {
    size_t values = (size_t)d->held_out.values;
    double *white = memory_get(values, sizeof *white), *one = memory_get(values, sizeof *one), *all = memory_get(values, sizeof *all);
    struct sums sum[RECORDING_TESTS] = {{0}};
    int frictions = 0, effect = 0;
    for (int i = 0; i < d->added; i++) {
        if (!is_dry(effect_table[d->addition[i].effect]) || !fit_contribution(&d->held_out, &d->model, d->addition[i].effect, one))
            continue;
        for (size_t a = 0; a < values; a++) all[a] += one[a];
        frictions++, effect = d->addition[i].effect;
    }
    if (frictions && fit_residual(&d->held_out, &d->model, white)) add_rows(d, all, white, sum);
    struct gap_course course = compare(sum, recording);
    course.frictions = frictions, course.effect = effect;
    free(white);
    free(one);
    free(all);
    return course;
}
