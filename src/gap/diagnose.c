#include "diagnose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base.h"
#include "memory.h"

static const double RIDGE_SHARE = 1e-4; /* ridge, as a share of each diagonal element of the Gram
                                         * matrix (Levenberg 1944), so that noise moves a variable
                                         * of the linearised base by at most 50 times the standard
                                         * deviation that it has when fitted alone */
enum { BASE_ITERATIONS = 6 };

double diagnosis_held_square(const struct diagnosis *d, const struct params *model) {
    double *white = memory_get((size_t)d->held_out.values, sizeof *white), square = INFINITY;
    if (fit_residual(&d->held_out, model, white)) square = fit_square(d->held_out.values, white);
    free(white);
    return square;
}

/* Fits all variables of the model, and updates columns, squares and hypotheses. Returns false if
 * the model cannot make the measured motion. */
static bool refit(struct diagnosis *d, int iterations) {
    struct fit_result r = fit_model(&d->fit, &d->model, d->variables, d->variable, NULL, NULL, NULL, iterations);
    bool fitted = r.ok && fit_raw(&d->fit, &d->model, d->raw) &&
                  fit_columns(&d->fit, &d->model, d->raw, d->variables, d->variable, NULL, d->column);
    if (!fitted) return false;
    fit_gram(d->variables, d->fit.values, d->column, d->gram);
    for (int i = 0; i < d->variables; i++) d->gram[i * d->variables + i] *= 1.0 + RIDGE_SHARE;
    memcpy(d->std, r.std, sizeof d->std);
    d->square = r.square;
    d->held_square = diagnosis_held_square(d, &d->model);
    d->hypotheses = hypotheses_list(d->given, &d->model, d->found, d->even.equations, d->hypothesis);
    return true;
}

int diagnosis_init(struct diagnosis *d, const struct params *given, const struct recording *recording, int threads, struct error *error) {
    *d = (struct diagnosis){.given = given, .model = *given};
    int status = residual_prepare(&d->even, recording, CYCLES_EVEN, error);
    if (!status) status = residual_prepare(&d->odd, recording, CYCLES_ODD, error);
    if (!status) status = residual_tabulate(&d->even, error);
    if (!status) status = residual_tabulate(&d->odd, error);
    if (status) return status;
    fit_data_init(&d->fit, &d->even, given, threads);
    fit_data_init(&d->held_out, &d->odd, given, threads);
    d->variables = base_variables(given, d->even.equations, d->variable);
    d->column = memory_get((size_t)FIT_VARIABLES * (size_t)d->fit.values, sizeof *d->column);
    d->gram = memory_get((size_t)FIT_VARIABLES * FIT_VARIABLES, sizeof *d->gram);
    d->raw = memory_get((size_t)d->fit.values, sizeof *d->raw);
    d->hypothesis = memory_get(HYPOTHESES_MAX, sizeof *d->hypothesis);
    if (!refit(d, BASE_ITERATIONS))
        return error_set(error, STATUS_USAGE, "the measured lengths are no motion of the machine in the configuration: check geometry");
    return STATUS_OK;
}

void diagnosis_free(struct diagnosis *d) {
    residual_free(&d->even);
    residual_free(&d->odd);
    fit_data_free(&d->fit);
    fit_data_free(&d->held_out);
    free(d->column);
    free(d->gram);
    free(d->raw);
    free(d->hypothesis);
}

/* Lists the base variables that are not parallel to an added effect, then the variables of the
 * added effects. Returns false if they are too many. */
static bool list_variables(struct diagnosis *d) {
    struct variable base[FIT_VARIABLES];
    int count = base_variables(d->given, d->even.equations, base);
    d->variables = 0;
    for (int i = 0; i < count; i++) {
        enum parallel how = PARALLEL_NOT;
        for (int j = 0; j < d->added; j++) {
            enum parallel one = hypothesis_parallel(&d->addition[j], &base[i]);
            how = one > how ? one : how;
        }
        if (how == PARALLEL_DRAWN) variable_add_prior(&base[i]);
        if (how != PARALLEL_SAME) d->variable[d->variables++] = base[i];
    }
    for (int j = 0; j < d->added; j++) {
        const struct hypothesis *h = &d->addition[j];
        if (d->variables + h->variables > FIT_VARIABLES) return false;
        memcpy(d->variable + d->variables, h->variable, (size_t)h->variables * sizeof *d->variable);
        d->variables += h->variables;
    }
    return true;
}

void diagnosis_estimate(struct diagnosis *d) {
    double noise = sqrt(fmin(d->square / d->fit.evaluated, 1.0)); /* observed noise divided by the
                                                                   * assumed noise, rms; at most
                                                                   * 1 */
    for (int i = 0; i < d->variables; i++) {
        struct variable *v = &d->variable[i];
        if (!v->base || v->penalised) continue;
        variable_add_prior(v);
        v->prior_inverse_std *= noise;
    }
    refit(d, BASE_ITERATIONS);
}

/* Restores a model that was fitted before, with its standard deviations. */
static void restore(struct diagnosis *d, const struct params *model, const double std[FIT_VARIABLES]) {
    d->model = *model;
    list_variables(d);
    refit(d, 0);
    memcpy(d->std, std, sizeof d->std);
}

bool diagnosis_add(struct diagnosis *d, const struct hypothesis *h, const struct params *model) {
    struct params before = d->model;
    double std[FIT_VARIABLES];
    int effect = h->effect;
    memcpy(std, d->std, sizeof std);
    if (d->added == GAP_EFFECTS) return false;
    d->addition[d->added++] = *h;
    d->model = *model;
    d->found[effect] = true;
    if (list_variables(d) && refit(d, BASE_ITERATIONS)) return true;
    d->added--;
    d->found[effect] = false;
    restore(d, &before, std);
    return false;
}

bool diagnosis_assume(struct diagnosis *d, int effects, const struct hypothesis *h, const struct params *model) {
    d->model = *model;
    memset(d->found, 0, sizeof d->found);
    d->added = effects;
    for (int i = 0; i < effects; i++) d->addition[i] = h[i], d->found[h[i].effect] = true;
    return list_variables(d) && refit(d, BASE_ITERATIONS);
}

bool diagnosis_drop(struct diagnosis *d, int addition, double most) {
    int effect = d->addition[addition].effect;
    struct hypothesis dropped = d->addition[addition];
    struct params before = d->model;
    double square = d->square, held = d->held_square, std[FIT_VARIABLES];
    memcpy(std, d->std, sizeof std);
    d->model.effects[effect] = d->given->effects[effect];
    d->found[effect] = false; /* the refit then lists the effect among the hypotheses again */
    memmove(d->addition + addition, d->addition + addition + 1, (size_t)(--d->added - addition) * sizeof *d->addition);
    bool fitted = list_variables(d) && refit(d, BASE_ITERATIONS);
    if (fitted && d->square - square < most + DIAGNOSIS_PENALTY * dropped.variables && d->held_square - held < most) return true;
    d->found[effect] = true;
    memmove(d->addition + addition + 1, d->addition + addition, (size_t)(d->added++ - addition) * sizeof *d->addition);
    d->addition[addition] = dropped;
    restore(d, &before, std);
    return false;
}
