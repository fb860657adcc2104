/* The model under diagnosis: effects that are added and dropped. */
#include "support.h"

#include <stdlib.h>

#include "diagnose.h"
#include "fit.h"
#include "gap_rig.h"
#include "numeric.h"

enum { TESTS = 2 }; /* along x and y */

static const struct hypothesis *find(const struct diagnosis *d, const char *effect) {
    for (int i = 0; i < d->hypotheses; i++)
        if (d->hypothesis[i].effect == effect_find(effect) && d->hypothesis[i].pattern == PATTERN_ALL) return &d->hypothesis[i];
    fail_msg("%s is no hypothesis", effect);
    return NULL;
}

/* Asserts that a refused change has left everything as it was. */
static void assert_same(const struct diagnosis *a, const struct diagnosis *b) {
    size_t values = (size_t)a->fit.values, n = (size_t)a->variables;
    assert_int_equal(a->variables, b->variables);
    assert_int_equal(a->hypotheses, b->hypotheses);
    assert_int_equal(a->added, b->added);
    assert_true(a->square == b->square && a->held_square == b->held_square);
    assert_memory_equal(&a->model, &b->model, sizeof a->model);
    assert_memory_equal(a->found, b->found, sizeof a->found);
    assert_memory_equal(a->variable, b->variable, n * sizeof *a->variable);
    assert_memory_equal(a->std, b->std, n * sizeof *a->std);
    assert_memory_equal(a->column, b->column, n * values * sizeof *a->column);
    assert_memory_equal(a->gram, b->gram, n * n * sizeof *a->gram);
    assert_memory_equal(a->raw, b->raw, values * sizeof *a->raw);
    for (int i = 0; i < a->hypotheses; i++) {
        assert_int_equal(a->hypothesis[i].effect, b->hypothesis[i].effect);
        assert_int_equal(a->hypothesis[i].pattern, b->hypothesis[i].pattern);
    }
}

static void *copy(const void *from, size_t size) {
    void *to = malloc(size);
    assert_non_null(to);
    return memcpy(to, from, size);
}

/* Copies the diagnosis with its tables; free_copy() frees it. */
static struct diagnosis *copy_of(const struct diagnosis *d) {
    struct diagnosis *c = copy(d, sizeof *d);
    size_t values = (size_t)d->fit.values, n = (size_t)d->variables;
    c->column = copy(d->column, n * values * sizeof *d->column);
    c->gram = copy(d->gram, n * n * sizeof *d->gram);
    c->raw = copy(d->raw, values * sizeof *d->raw);
    c->hypothesis = copy(d->hypothesis, (size_t)d->hypotheses * sizeof *d->hypothesis);
    return c;
}

static void free_copy(struct diagnosis *c) {
    free(c->column);
    free(c->gram);
    free(c->raw);
    free(c->hypothesis);
    free(c);
}

/* Asserts that the columns, which a fit may have kept from a model nearby, are those of the model,
 * and that no better values are near. */
static void assert_fitted(const struct diagnosis *d) {
    size_t values = (size_t)d->fit.values;
    double *column = calloc((size_t)d->variables * values, sizeof *column);
    assert_true(fit_columns(&d->fit, &d->model, d->raw, d->variables, d->variable, NULL, column));
    for (int i = 0; i < d->variables; i++) {
        double off = 0.0, size = 0.0;
        for (size_t a = (size_t)i * values; a < (size_t)(i + 1) * values; a++)
            off += square(column[a] - d->column[a]), size += square(column[a]);
        /* A column whose error is a tenth of the noise, within the value's uncertainty, decides
         * nothing. A spring along an axis that no test moves has only the force that the zeros of
         * the lengths give it, and its column changes with them. */
        bool unmoved = d->variable[i].effect == effect_find("external_stiffness") && d->variable[i].key >= TESTS;
        bool matters = off * square(d->std[i]) > square(0.1) && !unmoved;
        if (matters && !(off < square(0.1) * size))
            fail_msg("%s of leg %d: column is off by %g", d->variable[i].name, d->variable[i].leg + 1, sqrt(off / size));
    }
    struct params model = d->model;
    struct fit_result r = fit_model(&d->fit, &model, d->variables, d->variable, NULL, NULL, NULL, 3, NULL);
    assert_true(r.ok && r.square > (1.0 - 2e-3) * d->square);
    free(column);
}

static void an_effect_that_is_needed_stays(void **state) {
    (void)state;
    slow_case();
    struct params params, machine;
    struct recording r;
    struct error error;
    struct diagnosis *d = calloc(1, sizeof *d);
    config_default(&params);
    machine = params;
    struct effect_values *spring = &machine.effects[effect_find("external_stiffness")];
    spring->on = true, spring->value[0][0] = 1e5, spring->value[1][0] = 1e5;
    if (gap_rig(&params, &machine, TESTS, &r, &error)) fail_msg("%s", error.text);
    assert_int_equal(diagnosis_init(d, &params, &r, 1, &error), STATUS_OK);

    struct diagnosis *without = copy_of(d);
    assert_fitted(d);
    struct hypothesis h = *find(d, "external_stiffness");
    assert_true(diagnosis_add(d, &h, &machine));
    assert_fitted(d);
    assert_below(d->square, 0.1 * without->square);
    assert_int_equal(d->variables, without->variables + h.variables);

    struct diagnosis *with = copy_of(d);
    assert_false(diagnosis_drop(d, 0, 10.0));
    assert_same(d, with);
    struct params impossible = d->model;
    impossible.payload.mass_kg = -1.0;
    assert_false(diagnosis_assume(d, 0, NULL, &impossible));
    assert_same(d, with);

    assert_true(diagnosis_drop(d, 0, HUGE_VAL));
    assert_fitted(d);
    assert_close(d->square, without->square, 1e-2 * without->square);
    assert_int_equal(d->hypotheses, without->hypotheses);
    free_copy(with);
    free_copy(without);
    diagnosis_free(d);
    free(d);
    recording_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_effect_that_is_needed_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
