/* The model under diagnosis: effects that are added and dropped. */
#include "support.h"

#include <stdlib.h>

#include "diagnose.h"
#include "gap_rig.h"

enum { TESTS = 2 };

static const struct hypothesis *find(const struct diagnosis *d, const char *effect) {
    for (int i = 0; i < d->hypotheses; i++)
        if (d->hypothesis[i].effect == effect_find(effect) && d->hypothesis[i].pattern == PATTERN_ALL) return &d->hypothesis[i];
    fail_msg("%s is no hypothesis", effect);
    return NULL;
}

/* What a refused change must leave alone. */
struct kept {
    double square, held_square, column, gram;
    int variables, hypotheses, added;
};

static struct kept look(const struct diagnosis *d) {
    struct kept k = {
        .square = d->square, .held_square = d->held_square, .variables = d->variables, .hypotheses = d->hypotheses, .added = d->added};
    for (int i = 0; i < d->variables * d->fit.values; i++) k.column += fabs(d->column[i]);
    for (int i = 0; i < d->variables * d->variables; i++) k.gram += fabs(d->gram[i]);
    return k;
}

static void assert_same(struct kept a, struct kept b) {
    assert_true(a.square == b.square && a.held_square == b.held_square && a.column == b.column && a.gram == b.gram);
    assert_true(a.variables == b.variables && a.hypotheses == b.hypotheses && a.added == b.added);
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

    struct kept without = look(d);
    struct hypothesis h = *find(d, "external_stiffness");
    assert_true(diagnosis_add(d, &h, &machine));
    struct kept with = look(d);
    assert_below(with.square, 0.1 * without.square);
    assert_int_equal(with.variables, without.variables + h.variables);

    assert_false(diagnosis_drop(d, 0, 10.0));
    assert_same(look(d), with);
    assert_true(diagnosis_drop(d, 0, HUGE_VAL));
    assert_close(d->square, without.square, 1e-2 * without.square);
    assert_int_equal(d->hypotheses, without.hypotheses);
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
