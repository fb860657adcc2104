#include "course.h"

#include <math.h>
#include <stdlib.h>

#include "memory.h"

/* A law that is slightly wrong asks for another factor in each test, too, because the tests differ
 * in speed: a Stribeck friction of another exponent for factors that differ by 15 %. */
static const double RATIO = 1.2;  /* least ratio of two tests' factors that is told */
static const double SIGMAS = 6.0; /* least difference, in its standard deviations, that is told */

/* Sums over the rows of a test: products of the change that the effect makes with itself and with
 * the residual. */
struct sums {
    double square, product;
};

/* Factor on the effect that leaves least in a test. */
static double factor(const struct sums *s) { return 1.0 - s->product / s->square; }

static void add_rows(const struct diagnosis *d, const double *change, const double *white, struct sums sum[RECORDING_TESTS]) {
    enum { ROW = sizeof(residual_row) / sizeof(double) };
    for (int i = 0; i < d->held_out.values; i++) {
        const struct residual_test *t = &d->odd.test[i / ROW];
        struct sums *s = &sum[t->of];
        if (!t->spectrum.cycles) continue; /* speeds differ too much from segment to segment */
        s->square += change[i] * change[i], s->product += change[i] * white[i];
    }
}

/* Finds the two steady tests whose factors differ most clearly. noise: standard deviation of a
 * white residual. */
static struct gap_course compare(const struct sums sum[RECORDING_TESTS], const struct recording *recording, double noise) {
    struct gap_course course = {0};
    double clearest = SIGMAS * noise;
    for (int i = 0; i < recording->tests; i++)
        for (int j = 0; j < recording->tests; j++) {
            const struct sums *most = &sum[i], *least = &sum[j];
            if (!(most->square > 0.0) || !(least->square > 0.0) || !(factor(least) > 0.0)) continue;
            double apart = (factor(most) - factor(least)) / sqrt(1.0 / most->square + 1.0 / least->square);
            if (!(apart > clearest) || !(factor(most) > RATIO * factor(least))) continue;
            clearest = apart;
            const struct recording_test *a = &recording->test[i], *b = &recording->test[j];
            course = (struct gap_course){.ratio = factor(most) / factor(least), .most = {a->test, a->dof}, .least = {b->test, b->dof}};
        }
    return course;
}

struct gap_course course_find(const struct diagnosis *d, const struct recording *recording) {
    size_t values = (size_t)d->held_out.values;
    double *white = memory_get(values, sizeof *white), *change = memory_get(values, sizeof *change);
    double noise = sqrt(fmax(d->held_square / d->held_out.evaluated, 1.0));
    struct gap_course found = {0};
    bool moves = fit_residual(&d->held_out, &d->model, white);
    for (int i = 0; i < d->added && moves; i++) {
        int effect = d->addition[i].effect;
        struct sums sum[RECORDING_TESTS] = {{0}};
        if (!effect_table[effect]->leg_friction || !fit_contribution(&d->held_out, &d->model, effect, change)) continue;
        add_rows(d, change, white, sum);
        struct gap_course course = compare(sum, recording, noise);
        course.effect = effect;
        if (course.ratio > found.ratio) found = course;
    }
    free(white);
    free(change);
    return found;
}
