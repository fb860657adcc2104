#include "diagnose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base.h"
#include "memory.h"

static const double RIDGE_SHARE = 1e-4; /* ridge, as a share of each diagonal element of the Gram
                                         * matrix (Levenberg 1944). With it, noise moves a variable
                                         * of the linearised base by at most 50 times the standard
                                         * deviation that the variable has when fitted alone */
enum { FIRST_SETS = 2, BASE_SETS = 6 };

double diagnosis_held_square(const struct diagnosis *d, const struct params *model) {
    double *white = memory_get((size_t)d->held_out.values, sizeof *white), square = INFINITY;
    if (fit_residual(&d->held_out, model, white)) square = fit_square(d->held_out.values, white);
    free(white);
    return square;
}

/* Lists, for each variable of d, the column that `other` has for the same base variable; NULL if it
 * has none. */
static void find_known(const struct diagnosis *d, const struct diagnosis *other, const double *known[FIT_VARIABLES]) {
    for (int i = 0; i < d->variables; i++) {
        const struct variable *v = &d->variable[i];
        known[i] = NULL;
        for (int j = 0; j < other->variables; j++) {
            const struct variable *w = &other->variable[j];
            if (w->base && v->base && w->offset == v->offset && w->leg == v->leg)
                known[i] = other->column + (size_t)j * (size_t)d->fit.values;
        }
    }
}

static void list_hypotheses(struct diagnosis *d) {
    d->hypotheses = hypotheses_list(d->given, &d->model, d->found, d->even.equations, d->hypothesis);
}

/* Fits all variables of the model, and updates columns, squares and hypotheses. from: a diagnosis
 * that was fitted before, or NULL. On a platform, where computing a set of columns takes long, the
 * first steps use the columns of `from`, unless its whiteners were others. Returns false if the
 * model cannot make the measured motion. */
static bool refit(struct diagnosis *d, const struct diagnosis *from) {
    const double *known[FIT_VARIABLES];
    if (from && !from->whitened_anew && params_legs(d->given) > 1) {
        find_known(d, from, known);
        fit_model(&d->fit, &d->model, d->variables, d->variable, known, NULL, NULL, FIRST_SETS, NULL);
    }
    struct fit_result r = fit_model(&d->fit, &d->model, d->variables, d->variable, NULL, NULL, NULL, BASE_SETS, d->column);
    if (!r.ok || !fit_raw(&d->fit, &d->model, d->raw)) return false;
    fit_gram(d->variables, d->fit.values, d->column, d->gram);
    for (int i = 0; i < d->variables; i++) d->gram[i * d->variables + i] *= 1.0 + RIDGE_SHARE;
    memcpy(d->std, r.std, sizeof d->std);
    d->square = r.square;
    d->held_square = diagnosis_held_square(d, &d->model);
    d->whitened_anew = false;
    list_hypotheses(d);
    return true;
}

static void get_tables(struct diagnosis *d) {
    d->column = memory_get((size_t)FIT_VARIABLES * (size_t)d->fit.values, sizeof *d->column);
    d->gram = memory_get((size_t)FIT_VARIABLES * FIT_VARIABLES, sizeof *d->gram);
    d->raw = memory_get((size_t)d->fit.values, sizeof *d->raw);
}

static void free_tables(struct diagnosis *d) {
    free(d->column);
    free(d->gram);
    free(d->raw);
}

/* Returns a copy of the diagnosis as it is, and gives the diagnosis new tables for a change.
 * end_change() then keeps or undoes the change. */
static struct diagnosis *begin_change(struct diagnosis *d) {
    struct diagnosis *before = memory_get(1, sizeof *before);
    *before = *d;
    get_tables(d);
    return before;
}

static bool end_change(struct diagnosis *d, struct diagnosis *before, bool keep) {
    free_tables(keep ? before : d);
    if (!keep) *d = *before, list_hypotheses(d);
    free(before);
    return keep;
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
    d->hypothesis = memory_get(HYPOTHESES_MAX, sizeof *d->hypothesis);
    get_tables(d);
    if (!refit(d, NULL))
        return error_set(error, STATUS_USAGE, "the measured lengths are no motion of the machine in the configuration: check geometry");
    return STATUS_OK;
}

void diagnosis_free(struct diagnosis *d) {
    residual_free(&d->even);
    residual_free(&d->odd);
    fit_data_free(&d->fit);
    fit_data_free(&d->held_out);
    free_tables(d);
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
    struct diagnosis *before = begin_change(d);
    double noise = sqrt(fmin(d->square / d->fit.evaluated, 1.0)); /* observed noise divided by the
                                                                   * assumed noise, rms; at most
                                                                   * 1 */
    for (int i = 0; i < d->variables; i++) {
        struct variable *v = &d->variable[i];
        if (!v->base || v->penalised) continue;
        variable_add_prior(v);
        v->prior_inverse_std *= noise;
    }
    end_change(d, before, refit(d, before));
}

bool diagnosis_add(struct diagnosis *d, const struct hypothesis *h, const struct params *model) {
    if (d->added == GAP_EFFECTS) return false;
    struct diagnosis *before = begin_change(d);
    d->addition[d->added++] = *h;
    d->model = *model;
    d->found[h->effect] = true;
    return end_change(d, before, list_variables(d) && refit(d, before));
}

bool diagnosis_assume(struct diagnosis *d, int effects, const struct hypothesis *h, const struct params *model) {
    struct diagnosis *before = begin_change(d);
    d->model = *model;
    memset(d->found, 0, sizeof d->found);
    d->added = effects;
    for (int i = 0; i < effects; i++) d->addition[i] = h[i], d->found[h[i].effect] = true;
    return end_change(d, before, list_variables(d) && refit(d, before));
}

bool diagnosis_drop(struct diagnosis *d, int addition, double most) {
    int effect = d->addition[addition].effect, variables = d->addition[addition].variables;
    struct diagnosis *before = begin_change(d);
    d->model.effects[effect] = d->given->effects[effect];
    d->found[effect] = false; /* the refit then lists the effect among the hypotheses again */
    memmove(d->addition + addition, d->addition + addition + 1, (size_t)(--d->added - addition) * sizeof *d->addition);
    bool fitted = list_variables(d) && refit(d, before);
    bool little = d->square - before->square < most + DIAGNOSIS_PENALTY * variables && d->held_square - before->held_square < most;
    return end_change(d, before, fitted && little);
}
