#include "verdict.h"

#include <math.h>
#include <stdarg.h>

#include "lin.h"
#include "params.h"

const char *const verdict_names[] = {"pass", "fail", "not_evaluated"};
static const char of_sinusoids[] =
    "amplitudes reached, unwanted motion, overruns, excluded samples, readings that live, steady mean forces, "
    "symmetry and positive definiteness of method A; not the error against the nominal matrix";
static const char of_a_motion[] =
    "overruns, excluded samples, whether the motion came to its end; not how far the platform was from its reference, "
    "and not the matrix";

void verdict_add(struct verdict *v, enum verdict_status status, const char *format, ...) {
    va_list args;
    if (v->status != VERDICT_FAIL) v->status = status;
    if (v->reasons == VERDICT_REASONS) return;
    va_start(args, format);
    vsnprintf(v->reason[v->reasons++], VERDICT_TEXT, format, args);
    va_end(args);
}

/* Conditions are negated, so that NaN fails a check. */
static void check_test(struct verdict *v, const struct params *params, const struct test_result *t) {
    const struct check_params *limit = &params->checks;
    const struct testimony *w = &t->witness;
    const char *name = dof_names[t->dof];
    double short_pct = 100.0 * fabs(t->achieved_amplitude / t->amplitude - 1.0);
    double excluded_pct = 100.0 * (double)t->excluded / (double)(t->samples + t->excluded);
    if (!t->complete) {
        verdict_add(v, VERDICT_NOT_EVALUATED, "test %s: not complete (%lld samples)", name, (long long)t->samples);
        return;
    }
    if (!(short_pct <= limit->amplitude_pct))
        verdict_add(v, VERDICT_FAIL, "test %s: amplitude off by %.1f %%, limit %g %%", name, short_pct, limit->amplitude_pct);
    for (int i = 0; i < DOFS; i++)
        if (!(t->unwanted_pct[i] <= limit->unwanted_pct))
            verdict_add(v, VERDICT_FAIL, "test %s: unwanted motion of %s %.1f %%, limit %g %%", name, dof_names[i], t->unwanted_pct[i],
                        limit->unwanted_pct);
    if (!(excluded_pct <= limit->excluded_pct))
        verdict_add(v, VERDICT_FAIL, "test %s: %.2f %% of the samples excluded, limit %g %%", name, excluded_pct, limit->excluded_pct);
    if (!((double)w->still_samples * params->loop.period_s * t->frequency_hz <= 1.0))
        verdict_add(v, VERDICT_FAIL, "test %s: a reading of leg %d stood still for %lld samples: dead sensor or stuck leg", name,
                    w->still_leg + 1, (long long)w->still_samples);
    if (!(w->length_m <= limit->length_wander_m))
        verdict_add(v, VERDICT_FAIL, "test %s: motion of leg %d wandered by %.3f mm between periods, limit %g mm", name, w->length_leg + 1,
                    w->length_m * 1e3, limit->length_wander_m * 1e3);
    if (!(w->force_n <= limit->force_wander_n))
        verdict_add(v, VERDICT_FAIL, "test %s: force of leg %d wandered by %.0f N between periods, limit %g N", name, w->force_leg + 1,
                    w->force_n, limit->force_wander_n);
}

/* Checks that each leg's mean force, its load at neutral, is the same in all complete tests. The
 * mean over part of a test is no load. */
static void check_load(struct verdict *v, const struct check_params *limit, const struct identification *id) {
    for (int leg = 0; leg < LEGS; leg++) {
        double low_n = INFINITY, high_n = -INFINITY;
        for (int i = 0; i < id->tests; i++) {
            if (!id->test[i].complete) continue;
            low_n = fmin(low_n, id->test[i].witness.mean_n[leg]);
            high_n = fmax(high_n, id->test[i].witness.mean_n[leg]);
        }
        if (high_n - low_n > limit->force_wander_n)
            verdict_add(v, VERDICT_FAIL, "mean force of leg %d wandered by %.0f N between tests, limit %g N", leg + 1, high_n - low_n,
                        limit->force_wander_n);
    }
}

static void check_matrix(struct verdict *v, const struct check_params *limit, const struct method_result *a) {
    double symmetric[DOFS][DOFS], eigenvalue[DOFS];
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) {
            symmetric[i][j] = 0.5 * (a->mt[i][j] + a->mt[j][i]);
            double skew_pct = 100.0 * fabs(a->mt[i][j] - a->mt[j][i]) / sqrt(fabs(a->mt[i][i] * a->mt[j][j]));
            if (i < j && !(skew_pct <= limit->symmetry_pct))
                verdict_add(v, VERDICT_FAIL, "method A: Mt(%d,%d) and Mt(%d,%d) differ by %.1f %%, limit %g %%", i + 1, j + 1, j + 1, i + 1,
                            skew_pct, limit->symmetry_pct);
        }
    if (lin_eigenvalues(DOFS, symmetric[0], eigenvalue) || !(eigenvalue[0] > 0.0))
        verdict_add(v, VERDICT_FAIL, "method A: Mt is not positive definite: no inertia matrix");
}

struct verdict ident_verdict(const struct params *params, const struct identification *id, bool sinusoids, int64_t cycles,
                             int64_t overruns) {
    struct verdict v = {.status = VERDICT_PASS, .scope = sinusoids ? of_sinusoids : of_a_motion};
    const struct check_params *limit = &params->checks;
    for (int i = 0; i < id->tests; i++) check_test(&v, params, &id->test[i]);
    check_load(&v, limit, id);
    if (sinusoids && id->tests < params->tests.count)
        verdict_add(&v, VERDICT_NOT_EVALUATED, "%d of %d tests done", id->tests, params->tests.count);
    double overruns_pct = cycles > 0 ? 100.0 * (double)overruns / (double)cycles : 0.0;
    if (!(overruns_pct <= limit->overruns_pct))
        verdict_add(&v, VERDICT_FAIL, "%.2f %% of the cycles overran, limit %g %%: a core of its own (loop.cpu), or a longer loop.period_s",
                    overruns_pct, limit->overruns_pct);
    if (sinusoids && !(params->loop.period_s <= limit->period_s))
        verdict_add(&v, VERDICT_FAIL,
                    "a cycle of %g ms puts the command's staircase into the matrix, limit %g ms; if only the recording is so slow, give "
                    "the configuration with the controller's own loop.period_s (-c)",
                    params->loop.period_s * 1e3, limit->period_s * 1e3);
    if (id->method_a.evaluated) check_matrix(&v, limit, &id->method_a);
    else if (sinusoids) verdict_add(&v, VERDICT_NOT_EVALUATED, "matrix: needs complete tests of all six axes");
    return v;
}

void verdict_print(const struct verdict *v, FILE *out) {
    fprintf(out, "verdict   %s\n", verdict_names[v->status]);
    for (int i = 0; i < v->reasons; i++) fprintf(out, "          %s\n", v->reason[i]);
}
