/* The statements of each effect's file about other effects and the base: each is present once, and
 * hexid and the reader can use it. */
#include "support.h"

#include <stdio.h>

#include "base.h"
#include "experiment.h"
#include "hypothesis.h"
#include "machine.h"

static struct params platform, axis;

static int setup(void **state) {
    (void)state;
    config_default(&platform);
    axis = platform;
    axis.mechanism = MECHANISM_AXIS;
    return 0;
}

static bool in_table(const struct effect *effect) {
    bool found = false;
    for (int i = 0; effect_table[i]; i++) found = found || effect_table[i] == effect;
    return found;
}

static bool in_base(const struct params *model, enum residual_equations evaluated, const char *parameter) {
    struct variable v[FIT_VARIABLES];
    bool found = false;
    for (int i = 0, n = base_variables(model, evaluated, v); i < n; i++) found = found || !strcmp(v[i].name, parameter);
    return found;
}

/* With a force sensor there are no errors of pressures, and the other way round. */
static bool is_parameter(const char *parameter) {
    return in_base(&platform, EQUATIONS_ALL, parameter) || in_base(&axis, EQUATIONS_ALL | EQUATIONS_FORCE_SENSOR, parameter);
}

static void what_an_effect_is_parallel_to_can_be_fitted(void **state) {
    (void)state;
    for (int i = 0; effect_table[i]; i++)
        for (int k = 0; k < EFFECT_TIES && effect_table[i]->parallel_to[k]; k++)
            if (!is_parameter(effect_table[i]->parallel_to[k]))
                fail_msg("%s: parallel_to[%d] is not in the base", effect_table[i]->name, k);
}

/* Springs within the stated tolerance are part of the base; without a tolerance they are an
 * effect. */
static void springs_of_the_tolerance_are_in_the_base(void **state) {
    (void)state;
    struct params model = platform;
    struct variable v[FIT_VARIABLES];
    int without = base_variables(&model, EQUATIONS_ALL, v), effect = effect_find("external_stiffness"), springs = 0;
    for (int i = 0; i < without; i++) assert_int_not_equal(v[i].effect, effect);
    model.model.tolerance.springs_n_per_m = 2e4, model.model.tolerance.springs_nm_per_rad = 4e3;
    model.effects[effect] = (struct effect_values){.on = true, .value = {{5e3, 5e3, 5e3, 5e3, 5e3, 5e3}}};
    for (int i = 0, n = base_variables(&model, EQUATIONS_ALL, v); i < n; i++) {
        if (v[i].effect != effect) continue;
        assert_true(v[i].min == 0.0 && v[i].leg < 0 && v[i].max == (v[i].key ? v[i].key < 3 ? 2e4 : 4e3 : 2.5e4));
        springs++;
    }
    assert_int_equal(springs, DOFS);
}

static void what_an_effect_contains_is_another_one_that_does_not_contain_it(void **state) {
    (void)state;
    for (int i = 0; effect_table[i]; i++) {
        for (int k = 0; k < EFFECT_TIES && effect_table[i]->contains[k]; k++) assert_true(in_table(effect_table[i]->contains[k]));
        for (int j = 0; effect_table[j]; j++) assert_false(hypothesis_contains(i, j) && hypothesis_contains(j, i));
    }
}

static void what_a_law_is_not_exact_by_is_stated(void **state) {
    (void)state;
    for (int i = 0; effect_table[i]; i++)
        if (!(effect_table[i]->law_error > 0.0 && effect_table[i]->law_error <= 0.2)) fail_msg("%s: law_error", effect_table[i]->name);
}

static void what_an_effect_is_told_apart_from_is_there(void **state) {
    (void)state;
    for (int i = 0; effect_table[i]; i++)
        for (int k = 0; k < EFFECT_TIES && effect_table[i]->told_apart[k].record; k++) {
            const struct effect_experiment *e = &effect_table[i]->told_apart[k];
            bool effect = e->from && in_table(e->from) && e->from != effect_table[i] && !e->from_parameter;
            bool parameter = !e->from && e->from_parameter && is_parameter(e->from_parameter);
            if (!effect && !parameter) fail_msg("%s: told_apart[%d] is from nothing there is", effect_table[i]->name, k);
            assert_true(e->record[0] && e->shows && e->shows[0] && (!e->record_axis || e->record_axis[0]));
        }
}

static int stands(const struct effect *in, const struct effect *from) {
    int count = 0;
    for (int k = 0; k < EFFECT_TIES && in->told_apart[k].record; k++) count += in->told_apart[k].from == from;
    return count;
}

static void no_pair_stands_twice(void **state) {
    (void)state;
    for (int i = 0; effect_table[i]; i++)
        for (int j = 0; j < i; j++)
            if (stands(effect_table[i], effect_table[j]) + stands(effect_table[j], effect_table[i]) > 1)
                fail_msg("%s and %s are told apart twice", effect_table[i]->name, effect_table[j]->name);
}

static const char *between(const struct mechanism *mechanism, int i, int j) {
    static char text[GAP_TEXT];
    experiment_between(mechanism, effect_table[i], effect_table[j], text);
    return text;
}

/* Asserts that `hexid run` accepts the options in backquotes. */
static void assert_runs(const char *text) {
    char options[GAP_TEXT], setting[GAP_TEXT];
    const char *open = strchr(text, '`'), *settings[1] = {setting};
    for (; open; open = strchr(open, '`')) {
        const char *close = strchr(++open, '`');
        struct params params = platform;
        assert_non_null(close);
        snprintf(options, sizeof options, "%.*s", (int)(close - open), open);
        open = close + 1;
        for (char *rest = options, *option; (option = strtok_r(NULL, " ", &rest));) {
            char *value = strtok_r(NULL, " ", &rest);
            struct error error;
            if (!value || (strcmp(option, "--set") != 0 && strcmp(option, "--tests") != 0)) fail_msg("what is %s in %s?", option, text);
            snprintf(setting, sizeof setting, "%s%s", strcmp(option, "--tests") ? "" : "tests.order=", value);
            if (config_override(&params, text, settings, 1, &error)) fail_msg("%s", error.text);
        }
    }
}

static void options_of_an_experiment_are_those_of_a_run(void **state) {
    (void)state;
    for (int i = 0; effect_table[i]; i++)
        for (int j = 0; effect_table[j]; j++)
            if (i != j) assert_runs(between(&mechanism_stewart, i, j));
}

/* Asserts that a text suits one axis: hexid does not drive it, and it has one direction. */
static void assert_of_one_axis(const char *text) {
    static const char *const foreign[] = {"`", "--", "control.", "platform", " x ", " y ", " z ", "phi", "theta", "psi", "payload"};
    for (size_t k = 0; k < sizeof foreign / sizeof *foreign; k++)
        if (strstr(text, foreign[k])) fail_msg("\"%s\" is not for one axis: %s", text, foreign[k]);
}

static void an_experiment_with_one_axis_is_one_that_it_can_make(void **state) {
    (void)state;
    static struct hypothesis h[HYPOTHESES_MAX];
    static const bool none[EFFECTS_MAX];
    char text[GAP_TEXT];
    int count = hypotheses_list(&axis, &axis, none, EQUATIONS_ALL, h);
    assert_true(count > 10);
    for (int i = 0; i < count; i++)
        for (int j = 0; j < i; j++) assert_of_one_axis(between(&mechanism_axis, h[i].effect, h[j].effect));
    for (int i = 0; i < count; i++) {
        experiment_from_parameter(&mechanism_axis, effect_table[h[i].effect], "axis.force_offset_n", text);
        assert_of_one_axis(text);
    }
    assert_of_one_axis(mechanism_axis.words.tone);
    assert_of_one_axis(experiment_unknown());
}

static void an_experiment_is_the_pairs_own_in_any_order_or_the_general_one(void **state) {
    (void)state;
    char other[GAP_TEXT];
    int lag = effect_find("valve_lag"), delay = effect_find("command_delay"), tilt = effect_find("base_tilt");
    assert_string_equal(between(&mechanism_stewart, lag, delay), "`--tests z --set tests.amplitude_m=0.0005 --set tests.frequency_hz=36`: "
                                                                 "a delay's phase grows with frequency, a lag also loses amplitude");
    snprintf(other, sizeof other, "%s", between(&mechanism_stewart, delay, lag));
    assert_string_equal(between(&mechanism_stewart, lag, delay), other);
    assert_non_null(strstr(between(&mechanism_axis, lag, delay), "five times the frequency"));
    assert_non_null(strstr(between(&mechanism_stewart, lag, tilt), "effects scale differently"));
}

static void assert_machine(const struct params *p, const char *effect, const struct variable *v, double value) {
    struct params with = *p;
    struct machine machine;
    struct error error;
    variable_set(v, &with, value);
    machine_init(&machine, &with);
    if (machine_check(&machine, &error)) fail_msg("%s %s = %g, leg %d: %s", effect, v->name, value, v->leg, error.text);
}

/* Every value that an effect may have gives a possible machine, even on the lightest base: a fit
 * gets stuck if a step makes a leg's inertia negative. */
static void what_an_effect_may_be_leaves_a_machine(void **unused) {
    (void)unused;
    static const bool found[EFFECTS_MAX];
    static struct hypothesis h[HYPOTHESES_MAX];
    struct variable base[FIT_VARIABLES];
    struct params lightest = platform;
    int variables = base_variables(&platform, EQUATIONS_ALL, base),
        hypotheses = hypotheses_list(&platform, &platform, found, EQUATIONS_ALL, h);
    for (int i = 0; i < variables; i++)
        if (base[i].effect < 0) variable_set(&base[i], &lightest, base[i].min);
    for (int i = 0; i < hypotheses; i++)
        for (int j = 0; j < h[i].variables; j++) {
            const struct variable *v = &h[i].variable[j];
            assert_true(v->min < v->max && v->min <= v->neutral && v->neutral <= v->max);
            assert_machine(&lightest, effect_table[h[i].effect]->name, v, v->min);
            assert_machine(&lightest, effect_table[h[i].effect]->name, v, v->max);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_an_effect_is_parallel_to_can_be_fitted),
        cmocka_unit_test(springs_of_the_tolerance_are_in_the_base),
        cmocka_unit_test(what_an_effect_contains_is_another_one_that_does_not_contain_it),
        cmocka_unit_test(what_a_law_is_not_exact_by_is_stated),
        cmocka_unit_test(what_an_effect_is_told_apart_from_is_there),
        cmocka_unit_test(what_an_effect_may_be_leaves_a_machine),
        cmocka_unit_test(no_pair_stands_twice),
        cmocka_unit_test(options_of_an_experiment_are_those_of_a_run),
        cmocka_unit_test(an_experiment_with_one_axis_is_one_that_it_can_make),
        cmocka_unit_test(an_experiment_is_the_pairs_own_in_any_order_or_the_general_one),
    };
    return cmocka_run_group_tests(tests, setup, NULL);
}
