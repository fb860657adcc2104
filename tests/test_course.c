/* A friction that is not the same in each test. */
#include "support.h"

#include <stdlib.h>

#include "course.h"
#include "gap_rig.h"

enum { TESTS = 3 };

static struct params params;

static void record(double friction_n, struct recording *out) {
    struct params machine = params;
    struct error error;
    struct effect_values *friction = &machine.effects[effect_find("cylinder_coulomb_friction")];
    friction->on = true;
    for (int k = 0; k < LEGS; k++) friction->value[0][k] = friction->value[1][k] = friction_n;
    if (gap_rig(&params, &machine, TESTS, out, &error)) fail_msg("%s", error.text);
}

static struct gap_course course_of(const struct recording *r) {
    struct diagnosis *d = calloc(1, sizeof *d);
    struct error error;
    const struct hypothesis *h = NULL;
    if (diagnosis_init(d, &params, r, 1, &error)) fail_msg("%s", error.text);
    for (int i = 0; i < d->hypotheses; i++)
        if (d->hypothesis[i].effect == effect_find("cylinder_coulomb_friction") && d->hypothesis[i].pattern == PATTERN_ALL)
            h = &d->hypothesis[i];
    assert_non_null(h);
    struct hypothesis friction = *h;
    struct params model = d->model;
    assert_true(hypothesis_at(&friction, 1.0, &model));
    assert_true(diagnosis_add(d, &friction, &model));
    struct gap_course course = course_find(d, r);
    diagnosis_free(d);
    free(d);
    return course;
}

/* The friction that is found is between both, and each test asks for its own. */
static void the_tests_that_differ_are_found_with_their_ratio(void **state) {
    (void)state;
    slow_case();
    struct recording cold, warm;
    config_default(&params);
    record(150.0, &cold);
    record(100.0, &warm);
    assert_true(course_of(&warm).ratio == 0.0);
    struct recording_test cooled = cold.test[0];
    cold.test[0] = warm.test[0], warm.test[0] = cooled;
    struct gap_course course = course_of(&warm);
    assert_int_equal(course.effect, effect_find("cylinder_coulomb_friction"));
    assert_close(course.ratio, 1.5, 0.15); /* the base takes a part of the difference */
    assert_int_equal(course.most.test, 0);
    assert_int_equal(course.most.dof, DOF_X);
    recording_free(&cold);
    recording_free(&warm);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_tests_that_differ_are_found_with_their_ratio),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
