#include "verdict.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "lin.h"
#include "numeric.h"
#include "admit.h"
#include "params.h"

const char *const verdict_names[] = {"pass", "fail", "not_evaluated"};
static const char of_data[] =
    "the run: complete tests, the cycle's length, overruns, excluded samples, readings that live, steady mean forces";
static const char of_matrix[] =
    "amplitudes reached, unwanted motion, symmetry and positive definiteness, agreement with method C where that passes; not the error "
    "against the nominal matrix";
static const char of_run_c[] =
    "method C's result (method_c.verdict) and the run: the cycle's length, overruns, excluded samples, readings that live, steady mean "
    "forces; not the error against the nominal matrix";
static const char of_run_a[] =
    "method A's result (amplitudes reached, unwanted motion, symmetry, positive definiteness) and the run: the cycle's length, overruns, "
    "excluded samples, readings that live, steady mean forces; not the error against the nominal matrix";
static const char of_refuted[] =
    "the run: the cycle's length, overruns, excluded samples, readings that live, steady mean forces; no method's matrix, because the "
    "recording contradicts the configured machine";
static const char of_motion[] =
    "the run: overruns, excluded samples, whether the motion came to its end; not how far the platform was from its reference, and not the "
    "matrix, which method C refused";

void verdict_add(struct verdict *v, enum verdict_status status, const char *format, ...) {
    va_list args;
    if (v->status != VERDICT_FAIL) v->status = status;
    if (v->reasons == VERDICT_REASONS) return;
    va_start(args, format);
    vsnprintf(v->reason[v->reasons++], VERDICT_TEXT, format, args);
    va_end(args);
}

void verdict_note(struct verdict *v, const char *format, ...) {
    va_list args;
    if (v->notes == VERDICT_NOTES) return;
    va_start(args, format);
    vsnprintf(v->note[v->notes], VERDICT_TEXT, format, args);
    va_end(args);
    for (int i = 0; i < v->notes; i++)
        if (!strcmp(v->note[i], v->note[v->notes])) return;
    v->notes++;
}

void verdict_join(struct verdict *v, const struct verdict *other) {
    for (int i = 0; i < other->reasons; i++) verdict_add(v, other->status, "%s", other->reason[i]);
    for (int i = 0; i < other->notes; i++) verdict_note(v, "%s", other->note[i]);
    if (other->status != VERDICT_PASS && v->status != VERDICT_FAIL) v->status = other->status;
}

/* The conditions are written as !(value <= limit), so that NaN fails a check. */
static void check_readings(struct verdict *v, const struct check_params *limit, const struct test_result *t) {
    const struct testimony *w = &t->witness;
    const char *name = dof_names[t->dof];
    double excluded_pct = 100.0 * (double)t->excluded / (double)(t->samples + t->excluded);
    if (t->refused) {
        verdict_add(v, VERDICT_NOT_EVALUATED, "test %s excluded: %s (%lld samples)", name, refusals[t->refused].why, (long long)t->samples);
        return;
    }
    if (!(excluded_pct <= limit->excluded_pct))
        verdict_add(v, VERDICT_FAIL, "test %s: %.2f %% of the samples excluded, limit %g %%", name, excluded_pct, limit->excluded_pct);
    if (!((double)w->still_samples * t->step_s * t->frequency_hz <= 1.0))
        verdict_add(v, VERDICT_FAIL, "test %s: a reading of leg %d stood still for %lld samples: dead sensor or stuck leg", name,
                    w->still_leg + 1, (long long)w->still_samples);
    if (!w->compared)
        verdict_add(
            v, VERDICT_NOT_EVALUATED,
            "test %s: its periods cannot be compared with each other, because fewer than two stretches of a hundred cycles have no gap: "
            "lose fewer rows, or record longer (tests.duration_s)",
            name);
    if (!(w->length_m <= limit->length_wander_m))
        verdict_add(v, VERDICT_FAIL, "test %s: motion of leg %d wandered by %.3f mm between periods, limit %g mm", name, w->length_leg + 1,
                    w->length_m * 1e3, limit->length_wander_m * 1e3);
    if (!(fabs(t->off_m) <= limit->reference_off_m))
        verdict_add(v, VERDICT_FAIL,
                    "test %s: leg %d is %+.1f mm off its reference on average, limit %g mm: the drawing, the zero of a length or the "
                    "reference is another machine's",
                    name, t->off_leg + 1, t->off_m * 1e3, limit->reference_off_m * 1e3);
    if (!(w->force_n <= limit->force_wander_n))
        verdict_add(v, VERDICT_FAIL, "test %s: force of leg %d wandered by %.0f N between periods, limit %g N", name, w->force_leg + 1,
                    w->force_n, limit->force_wander_n);
}

/* Checks the motion of a test against the recorded reference. Without a reference the amplitude is
 * only assumed to be the configured one, and is not judged. */
static void check_motion(struct verdict *v, const struct check_params *limit, const struct test_result *t) {
    const char *name = dof_names[t->dof];
    double short_pct = 100.0 * fabs(t->achieved_amplitude / t->asked_amplitude - 1.0);
    if (t->refused) return;
    if (isnan(t->asked_amplitude)) {
        verdict_note(v, "amplitudes and unwanted motion are not judged: the recording has no reference to compare them with");
        return;
    }
    if (!(short_pct <= limit->amplitude_pct))
        verdict_add(v, VERDICT_FAIL, "test %s: amplitude off by %.1f %%, limit %g %%", name, short_pct, limit->amplitude_pct);
    for (int i = 0; i < DOFS; i++)
        if (!(t->unwanted_pct[i] <= limit->unwanted_pct))
            verdict_add(v, VERDICT_FAIL, "test %s: unwanted motion of %s %.1f %%, limit %g %%", name, dof_names[i], t->unwanted_pct[i],
                        limit->unwanted_pct);
}

/* Checks that each leg's mean force, its load at neutral, is the same in all complete tests.
 * Incomplete tests are left out, because a mean over part of a test is not the load. */
static void check_load(struct verdict *v, const struct check_params *limit, const struct identification *id) {
    for (int leg = 0; leg < LEGS; leg++) {
        double low_n = INFINITY, high_n = -INFINITY;
        for (int i = 0; i < id->tests; i++) {
            if (id->test[i].refused) continue;
            low_n = fmin(low_n, id->test[i].witness.mean_n[leg]);
            high_n = fmax(high_n, id->test[i].witness.mean_n[leg]);
        }
        if (high_n - low_n > limit->force_wander_n)
            verdict_add(v, VERDICT_FAIL, "mean force of leg %d wandered by %.0f N between tests, limit %g N", leg + 1, high_n - low_n,
                        limit->force_wander_n);
    }
}

static void check_matrix(struct verdict *v, const struct check_params *limit, const struct method_result *m, const char *name) {
    double symmetric[DOFS][DOFS], eigenvalue[DOFS];
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) {
            symmetric[i][j] = 0.5 * (m->mt[i][j] + m->mt[j][i]);
            double skew_pct = 100.0 * fabs(m->mt[i][j] - m->mt[j][i]) / sqrt(fabs(m->mt[i][i] * m->mt[j][j]));
            if (i < j && !(skew_pct <= limit->symmetry_pct))
                verdict_add(v, VERDICT_FAIL, "%s: Mt(%d,%d) and Mt(%d,%d) differ by %.1f %%, limit %g %%", name, i + 1, j + 1, j + 1, i + 1,
                            skew_pct, limit->symmetry_pct);
        }
    if (lin_eigenvalues(DOFS, symmetric[0], eigenvalue) || !(eigenvalue[0] > 0.0))
        verdict_add(v, VERDICT_FAIL, "%s: Mt is not positive definite: no inertia matrix", name);
}

struct verdict verdict_of_data(const struct params *params, const struct identification *id, const struct run_facts *facts) {
    struct verdict v = {.status = VERDICT_PASS, .scope = of_data};
    const struct check_params *limit = &params->checks;
    for (int i = 0; i < id->tests; i++) check_readings(&v, limit, &id->test[i]);
    check_load(&v, limit, id);
    if (facts->sinusoids && id->tests < params->tests.count)
        verdict_add(&v, VERDICT_NOT_EVALUATED, "%d of %d tests done", id->tests, params->tests.count);
    if (facts->sinusoids && !(params->loop.period_s <= limit->period_s))
        verdict_add(&v, VERDICT_FAIL,
                    "a cycle of %g ms puts the command's staircase into the matrix, limit %g ms; if only the recording is so slow, give "
                    "the configuration with the controller's own loop.period_s (-c)",
                    params->loop.period_s * 1e3, limit->period_s * 1e3);
    double overruns_pct = facts->cycles > 0 ? 100.0 * (double)facts->overruns / (double)facts->cycles : 0.0;
    if (!(overruns_pct <= limit->overruns_pct))
        verdict_add(&v, VERDICT_FAIL, "%.2f %% of the cycles overran, limit %g %%: a core of its own (loop.cpu), or a longer loop.period_s",
                    overruns_pct, limit->overruns_pct);
    return v;
}

struct verdict verdict_of_matrix(const struct params *params, const struct identification *id, const struct method_result *m,
                                 const char *name) {
    struct verdict v = {.status = VERDICT_PASS, .scope = of_matrix};
    const struct check_params *limit = &params->checks;
    if (id->refuted) {
        verdict_add(&v, VERDICT_NOT_EVALUATED, "%s", id->no_method_c.text);
        return v;
    }
    for (int i = 0; i < id->tests; i++) check_motion(&v, limit, &id->test[i]);
    if (m->evaluated) check_matrix(&v, limit, m, name);
    else verdict_add(&v, VERDICT_NOT_EVALUATED, "matrix: needs complete tests of all six axes");
    return v;
}

/* True if a complete test has as many cycles as method C needs. */
static bool any_long_enough(const struct identification *id) {
    for (int i = 0; i < id->tests; i++) {
        const struct test_result *t = &id->test[i];
        double cycles = (double)(t->samples + t->excluded) * t->step_s * t->frequency_hz;
        if (!t->refused && cycles > RECORDING_CYCLES - 0.1) return true;
    }
    return false;
}

static bool all_determined(const struct method_result *m) {
    for (int i = 0; i < DOFS * DOFS; i++)
        if (isnan(m->mt[i / DOFS][i % DOFS])) return false;
    return true;
}

/* Judges whether the machine was the same in all groups of parts of a long motion. Friction that
 * changes as seals warm up is only noted. A matrix that changes fails the run, because the matrix
 * of a machine is constant. */
static void check_over_time(const struct agreement *a, struct verdict *v) {
    bool used[AGREEMENT_LOGS][AGREEMENT_VALUES] = {{0}}, matrix = false;
    struct agreement_place worst = {0}, place;
    char name[EQUATIONS_NAME], text[VERDICT_TEXT];
    if (!a->evaluated || a->agree) return;
    for (bool first = true; !matrix && agreement_worst(a, used, &place); first = false) {
        matrix = place.value < UNKNOWN_VISCOUS && a->apart[place.log][place.value];
        if (first || matrix) worst = place;
    }
    equations_name(worst.value, name);
    snprintf(text, sizeof text, "the machine changed on the way: %s of group %d of %d is %+.1f standard deviations from the others", name,
             worst.log + 1, a->logs, a->deviation[worst.log][worst.value]);
    if (matrix) verdict_add(v, VERDICT_FAIL, "%s", text);
    else verdict_note(v, "%s", text);
}

/* Fails a method whose matrix is far from that of method C, which passed and knows dry friction and
 * the sensors' errors. The reason names the entry that is furthest off. */
static void check_against_c(struct verdict *v, const struct check_params *limit, const struct method_result *m,
                            const struct method_result *c) {
    double worst_pct = 0.0;
    int row = 0, col = 0;
    if (!m->evaluated) return;
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) {
            double off = fabs(m->mt[i][j] - c->mt[i][j]) - NUMERIC_95 * c->mt_std[i][j];
            double off_pct = 100.0 * off / sqrt(c->mt[i][i] * c->mt[j][j]);
            /* An entry that method C did not determine is NaN, and compares false. */
            if (off_pct > worst_pct) worst_pct = off_pct, row = i, col = j;
        }
    if (worst_pct > limit->symmetry_pct)
        verdict_add(v, VERDICT_FAIL,
                    "Mt(%d,%d) is %.1f %% off method C's, limit %g %%: dry friction or errors of sensors, which only method C has in its "
                    "equations",
                    row + 1, col + 1, worst_pct, limit->symmetry_pct);
}

void verdict_of_run(struct verdicts *v, const struct params *params, const struct identification *id, const struct run_facts *facts) {
    const struct method_result *c = &id->method_c.matrix;
    bool by_c = c->evaluated, refused = !by_c && id->no_method_c.status, due = any_long_enough(id) || !facts->sinusoids;
    v->run.scope = by_c ? of_run_c : id->refuted ? of_refuted : facts->sinusoids ? of_run_a : of_motion;
    if (by_c && v->method_c.status == VERDICT_PASS) {
        check_against_c(&v->method_a, &params->checks, &id->method_a, c);
        check_against_c(&v->modified_a, &params->checks, &id->modified_a, c);
        check_against_c(&v->method_b, &params->checks, &id->method_b, c);
    }
    if (by_c) {
        verdict_join(&v->run, &v->method_c);
        check_over_time(&id->over_time, &v->run);
        if (facts->sinusoids && !id->method_a.evaluated && !all_determined(c))
            verdict_add(&v->run, VERDICT_NOT_EVALUATED, "matrix: needs complete tests of all six axes");
    } else if (id->refuted) {
        verdict_add(&v->run, VERDICT_NOT_EVALUATED, "%s", id->no_method_c.text);
    } else {
        if (refused && !due) verdict_note(&v->run, "method C: %s", id->no_method_c.text);
        if (refused && due) verdict_add(&v->run, VERDICT_NOT_EVALUATED, "method C: %s", id->no_method_c.text);
        if (facts->sinusoids) verdict_join(&v->run, &v->method_a);
    }
}

void verdict_print(const struct verdict *v, FILE *out) {
    fprintf(out, "verdict   %s\n", verdict_names[v->status]);
    for (int i = 0; i < v->reasons; i++) fprintf(out, "          %s\n", v->reason[i]);
    for (int i = 0; i < v->notes; i++) fprintf(out, "          (%s)\n", v->note[i]);
}
