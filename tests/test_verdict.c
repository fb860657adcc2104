/* The checks of a run: each limit from both sides, NaN, and missing data. */
#include "support.h"

#include "verdict.h"

/* A computed limit is exact to a rounding or two: 1e-15 of 100 %, compared with limits of 1 % and
 * more. */
static const double inside = 1 - 1e-9, outside = 1 + 1e-9;

enum { CYCLES = 10000, SAMPLES = 2500 };

struct run {
    struct params params;
    struct identification id;
    int64_t cycles, overruns;
    enum verdict_status method_c;
};

static double amplitude(const struct params *p, int dof) { return p->tests.amplitude[dof]; }

/* Returns a faultless run: six perfect tests, a plain inertia matrix. */
static struct run *good_run(void) {
    static struct run run;
    struct run *r = &run;
    *r = (struct run){.cycles = CYCLES, .id.tests = DOFS, .id.method_a.evaluated = true};
    config_default(&r->params);
    for (int d = 0; d < DOFS; d++) {
        double size = amplitude(&r->params, d);
        r->id.test[d] = (struct test_result){.test = d,
                                             .dof = (enum dof)d,
                                             .asked_amplitude = size,
                                             .frequency_hz = r->params.tests.hz[d],
                                             .amplitude = size,
                                             .achieved_amplitude = size,
                                             .samples = SAMPLES,
                                             .step_s = r->params.loop.period_s,
                                             .witness.compared = true};
        r->id.method_a.mt[d][d] = d < DOF_PHI ? 272 : 30;
    }
    return r;
}

static struct run_facts facts_of(const struct run *r) {
    return (struct run_facts){.sinusoids = tests_single(&r->params.tests), .cycles = r->cycles, .overruns = r->overruns};
}

static struct verdicts judge_all(const struct run *r) {
    const struct run_facts facts = facts_of(r);
    struct verdicts v = {.run = verdict_of_data(&r->params, &r->id, &facts),
                         .method_a = verdict_of_matrix(&r->params, &r->id, &r->id.method_a, "method A"),
                         .method_c = {.status = r->method_c}};
    verdict_of_run(&v, &r->params, &r->id, &facts);
    return v;
}

static struct verdict judge(const struct run *r) { return judge_all(r).run; }

static void assert_passes(const struct run *r) {
    struct verdict v = judge(r);
    if (v.status != VERDICT_PASS || v.reasons) fail_msg("%s: %s", verdict_names[v.status], v.reasons ? v.reason[0] : "no reason");
}

static void assert_passes_with_a_note(const struct run *r, const char *words) {
    struct verdict v = judge(r);
    assert_passes(r);
    assert_true(v.notes == 1 && strstr(v.note[0], words));
}

/* Asserts that there is exactly one reason, whose text contains `words`. */
static void assert_one_reason(const struct run *r, enum verdict_status status, const char *words) {
    struct verdict v = judge(r);
    if (v.status != status) fail_msg("%s, not %s: %s", verdict_names[v.status], verdict_names[status], words);
    assert_int_equal(v.reasons, 1);
    if (!strstr(v.reason[0], words)) fail_msg("\"%s\" does not say \"%s\"", v.reason[0], words);
}

static void a_good_run_passes_without_a_reason(void **unused) {
    (void)unused;
    assert_passes(good_run());
}

static void amplitude_is_limited_on_both_sides(void **unused) {
    (void)unused;
    for (int d = 0; d < DOFS; d++)
        for (int sign = -1; sign <= 1; sign += 2) {
            struct run *r = good_run();
            struct test_result *t = &r->id.test[d];
            char words[VERDICT_TEXT];
            snprintf(words, sizeof words, "test %s: amplitude", dof_names[d]);
            t->achieved_amplitude = t->amplitude * (1 + sign * inside * r->params.checks.amplitude_pct / 100);
            assert_passes(r);
            t->achieved_amplitude = t->amplitude * (1 + sign * outside * r->params.checks.amplitude_pct / 100);
            assert_one_reason(r, VERDICT_FAIL, words);
            t->achieved_amplitude = (double)NAN;
            assert_one_reason(r, VERDICT_FAIL, words);
        }
}

static void unwanted_motion_is_limited_in_every_axis_of_every_test(void **unused) {
    (void)unused;
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < DOFS; i++) {
            struct run *r = good_run();
            char words[VERDICT_TEXT];
            snprintf(words, sizeof words, "test %s: unwanted motion of %s", dof_names[d], dof_names[i]);
            r->id.test[d].unwanted_pct[i] = r->params.checks.unwanted_pct;
            assert_passes(r);
            r->id.test[d].unwanted_pct[i] = nextafter(r->params.checks.unwanted_pct, INFINITY);
            assert_one_reason(r, VERDICT_FAIL, words);
            r->id.test[d].unwanted_pct[i] = (double)NAN;
            assert_one_reason(r, VERDICT_FAIL, words);
        }
}

static void a_leg_off_its_reference_is_limited_on_both_sides(void **unused) {
    (void)unused;
    for (int sign = -1; sign <= 1; sign += 2) {
        struct run *r = good_run();
        struct test_result *t = &r->id.test[2];
        t->off_leg = 3;
        t->off_m = sign * r->params.checks.reference_off_m;
        assert_passes(r);
        t->off_m *= outside;
        assert_one_reason(r, VERDICT_FAIL, sign < 0 ? "test z: leg 4 is -3.0 mm off" : "test z: leg 4 is +3.0 mm off");
        t->off_m = (double)NAN;
        assert_one_reason(r, VERDICT_FAIL, "test z: leg 4");
    }
}

static void excluded_samples_are_limited_in_every_test(void **unused) {
    (void)unused;
    for (int d = 0; d < DOFS; d++) {
        struct run *r = good_run();
        struct test_result *t = &r->id.test[d];
        r->params.checks.excluded_pct = 1;
        /* the share counts all evaluated samples, not only those that are left */
        t->samples = SAMPLES - 25, t->excluded = 25;
        assert_passes(r);
        t->samples = SAMPLES - 26, t->excluded = 26;
        assert_one_reason(r, VERDICT_FAIL, "1.04 % of the samples excluded, limit 1 %");
    }
}

static void overruns_are_limited(void **unused) {
    (void)unused;
    struct run *r = good_run();
    r->params.checks.overruns_pct = 1;
    r->overruns = CYCLES / 100;
    assert_passes(r);
    r->overruns++;
    assert_one_reason(r, VERDICT_FAIL, "1.01 % of the cycles overran, limit 1 %: a core of its own (loop.cpu), or a longer loop.period_s");
}

/* The asymmetry is on either side of the diagonal, with either sign. */
static void asymmetry_is_limited_in_every_pair_of_entries(void **unused) {
    (void)unused;
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) {
            if (i == j) continue;
            struct run *r = good_run();
            double (*mt)[DOFS] = r->id.method_a.mt, sign = i < j ? 1 : -1;
            double limit = sign * r->params.checks.symmetry_pct / 100 * sqrt(mt[i][i] * mt[j][j]);
            mt[i][j] = limit * inside;
            assert_passes(r);
            mt[i][j] = limit * outside;
            assert_one_reason(r, VERDICT_FAIL, "differ by");
            mt[j][i] = mt[i][j]; /* large, but symmetric */
            assert_passes(r);
        }
}

/* Method A judges itself by its symmetry alone; where method C passes, it is the better judge. */
static void a_matrix_far_from_method_c_fails_its_method_and_not_the_run(void **unused) {
    (void)unused;
    for (int passes = 0; passes <= 1; passes++)
        for (int i = 0; i < DOFS; i++) {
            struct run *r = good_run();
            struct method_result *c = &r->id.method_c.matrix;
            *c = r->id.method_a;
            r->method_c = passes ? VERDICT_PASS : VERDICT_FAIL;
            double (*mt)[DOFS] = r->id.method_a.mt, limit = r->params.checks.symmetry_pct / 100;
            mt[i][i] = c->mt[i][i] * (1 + limit * inside);
            assert_int_equal(judge_all(r).method_a.status, VERDICT_PASS);
            mt[i][i] = c->mt[i][i] * (1 + limit * outside);
            assert_int_equal(judge_all(r).method_a.status, passes ? VERDICT_FAIL : VERDICT_PASS);
            assert_int_equal(judge_all(r).run.status, passes ? VERDICT_PASS : VERDICT_FAIL);
            c->mt[i][i] = (double)NAN; /* not determined */
            assert_int_equal(judge_all(r).method_a.status, VERDICT_PASS);
        }
}

static void a_matrix_that_is_not_positive_definite_fails(void **unused) {
    (void)unused;
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < i; j++) {
            struct run *r = good_run();
            double (*mt)[DOFS] = r->id.method_a.mt, border = sqrt(mt[i][i] * mt[j][j]);
            /* the smallest eigenvalue is +-1e-8, its rounding 1e-13 */
            mt[i][j] = mt[j][i] = border * inside;
            assert_passes(r);
            mt[i][j] = mt[j][i] = border * outside;
            assert_one_reason(r, VERDICT_FAIL, "not positive definite");
        }
    struct run *r = good_run();
    r->id.method_a.mt[DOF_PSI][DOF_PSI] = 0;
    assert_int_equal(judge(r).status, VERDICT_FAIL);
    r->id.method_a.mt[DOF_PSI][DOF_PSI] = -30;
    assert_one_reason(r, VERDICT_FAIL, "not positive definite");
}

static void a_matrix_with_what_is_not_a_number_fails(void **unused) {
    (void)unused;
    for (int k = 0; k < DOFS * DOFS; k++) {
        struct run *r = good_run();
        r->id.method_a.mt[k / DOFS][k % DOFS] = (double)NAN;
        assert_int_equal(judge(r).status, VERDICT_FAIL);
        r->id.method_a.mt[k / DOFS][k % DOFS] = INFINITY;
        assert_int_equal(judge(r).status, VERDICT_FAIL);
    }
}

static void an_incomplete_test_is_not_evaluated(void **unused) {
    (void)unused;
    for (int d = 0; d < DOFS; d++) {
        struct run *r = good_run();
        struct test_result *t = &r->id.test[d];
        char words[VERDICT_TEXT];
        snprintf(words, sizeof words, "test %s excluded: %s (0 samples)", dof_names[d], refusals[REFUSED_INCOMPLETE].why);
        *t = (struct test_result){
            .dof = (enum dof)d, .amplitude = t->amplitude, .achieved_amplitude = (double)NAN, .refused = REFUSED_INCOMPLETE};
        /* these means are over a fraction of a period, and are not judged */
        for (int leg = 0; leg < LEGS; leg++) t->witness.mean_n[leg] = 1e6;
        assert_one_reason(r, VERDICT_NOT_EVALUATED, words);
    }
}

static void missing_tests_are_not_evaluated(void **unused) {
    (void)unused;
    struct run *r = good_run();
    r->id.tests = DOFS - 1;
    assert_one_reason(r, VERDICT_NOT_EVALUATED, "5 of 6 tests done");
    r->id.tests = 0;
    assert_one_reason(r, VERDICT_NOT_EVALUATED, "0 of 6 tests done");
}

static void without_a_matrix_it_is_not_evaluated_and_its_entries_are_not_looked_at(void **unused) {
    (void)unused;
    struct run *r = good_run();
    r->id.method_a = (struct method_result){.mt = {{(double)NAN}}};
    assert_one_reason(r, VERDICT_NOT_EVALUATED, "matrix: needs complete tests of all six axes");
    /* a run of one axis is complete but has no matrix */
    r->id.tests = r->params.tests.count = 1;
    assert_one_reason(r, VERDICT_NOT_EVALUATED, "matrix: needs");
}

static void a_failure_outweighs_what_was_not_evaluated_whichever_comes_first(void **unused) {
    (void)unused;
    struct run *r = good_run();
    r->id.test[0].refused = REFUSED_INCOMPLETE;
    r->overruns = CYCLES;
    struct verdict v = judge(r);
    assert_true(v.status == VERDICT_FAIL && v.reasons == 2);
    r = good_run();
    r->id.test[0].achieved_amplitude = 0;
    r->id.test[5].refused = REFUSED_INCOMPLETE;
    v = judge(r);
    assert_true(v.status == VERDICT_FAIL && v.reasons == 2);
}

static void reasons_beyond_the_last_place_still_count(void **unused) {
    (void)unused;
    struct verdict v = {.status = VERDICT_PASS};
    for (int i = 0; i < VERDICT_REASONS; i++) verdict_add(&v, VERDICT_NOT_EVALUATED, "reason %0*d", VERDICT_TEXT, i);
    assert_int_equal(v.status, VERDICT_NOT_EVALUATED);
    struct verdict before = v;
    verdict_add(&v, VERDICT_FAIL, "one too many");
    assert_int_equal(v.status, VERDICT_FAIL);
    assert_int_equal(v.reasons, VERDICT_REASONS);
    assert_memory_equal(v.reason, before.reason, sizeof v.reason);
    for (int i = 0; i < VERDICT_REASONS; i++) assert_int_equal(strlen(v.reason[i]), VERDICT_TEXT - 1);
}

/* Method A's checks judge method A only: a run that has a result of method C has the verdict of
 * method C. */
static void the_run_has_the_verdict_of_method_c_where_that_has_a_result(void **unused) {
    (void)unused;
    struct run *r = good_run();
    const struct run_facts facts = facts_of(r);
    r->id.method_a.mt[0][0] = -1;
    struct verdicts v = judge_all(r);
    assert_true(v.run.status == VERDICT_FAIL && v.method_a.status == VERDICT_FAIL && strstr(v.run.scope, "method A"));
    r->id.method_c.matrix.evaluated = true;
    v = judge_all(r);
    assert_true(v.run.status == VERDICT_PASS && v.method_a.status == VERDICT_FAIL && strstr(v.run.scope, "method C"));
    v.run = verdict_of_data(&r->params, &r->id, &facts);
    verdict_add(&v.method_c, VERDICT_FAIL, "impossible");
    verdict_of_run(&v, &r->params, &r->id, &facts);
    assert_true(v.run.status == VERDICT_FAIL && v.run.reasons == 1 && !strcmp(v.run.reason[0], "impossible"));
    /* checks of the data apply to both methods */
    r->overruns = CYCLES;
    assert_int_equal(judge(r).status, VERDICT_FAIL);
}

/* All six tests are good for method A, but method C contradicts the machine, so the run does not
 * pass. */
static void a_run_that_method_c_refused_is_not_evaluated_and_says_why(void **unused) {
    (void)unused;
    struct run *r = good_run();
    error_set(&r->id.no_method_c, STATUS_USAGE, "another machine");
    assert_one_reason(r, VERDICT_NOT_EVALUATED, "method C: another machine");
    assert_int_equal(judge_all(r).method_a.status, VERDICT_PASS);
    /* method C needs six cycles, which are 750 samples at 4 Hz and 2 ms */
    for (int d = 0; d < DOFS; d++) r->id.test[d].samples = 700;
    assert_passes_with_a_note(r, "another machine");
    /* without a complete test method C has nothing to evaluate */
    r->id.tests = 0, r->id.method_a.evaluated = false;
    struct verdict v = judge(r);
    for (int i = 0; i < v.reasons; i++) assert_null(strstr(v.reason[i], "another machine"));
    /* any other motion has no method A */
    r->params.tests.multisine = true;
    assert_one_reason(r, VERDICT_NOT_EVALUATED, "method C: another machine");
}

/* With another geometry than the machine's every method's matrix is wrong, however well its checks
 * look. */
static void where_the_machine_is_refuted_no_method_is_evaluated(void **unused) {
    (void)unused;
    struct run *r = good_run();
    r->id.refuted = true;
    r->id.test[2].achieved_amplitude = 0.0; /* by the wrong geometry */
    error_set(&r->id.no_method_c, STATUS_USAGE, "legs 1 and 2 exchanged");
    assert_one_reason(r, VERDICT_NOT_EVALUATED, "legs 1 and 2 exchanged");
    struct verdicts v = judge_all(r);
    assert_int_equal(v.method_a.status, VERDICT_NOT_EVALUATED);
    assert_string_equal(v.method_a.reason[0], "legs 1 and 2 exchanged");
    assert_non_null(strstr(v.run.scope, "no method's matrix"));
    r->overruns = CYCLES;
    assert_int_equal(judge(r).status, VERDICT_FAIL);
}

static void entries_that_method_c_leaves_open_in_tests_of_few_axes_are_not_evaluated(void **unused) {
    (void)unused;
    struct run *r = good_run();
    r->id.tests = r->params.tests.count = 3;
    r->id.method_a.evaluated = false, r->id.method_c.matrix.evaluated = true;
    assert_passes(r);
    r->id.method_c.matrix.mt[4][5] = (double)NAN;
    assert_one_reason(r, VERDICT_NOT_EVALUATED, "matrix: needs complete tests of all six axes");
}

/* No amplitude was requested, so a note states that nothing was judged by it. */
static void an_amplitude_without_a_reference_is_not_judged(void **unused) {
    (void)unused;
    struct run *r = good_run();
    for (int d = 0; d < DOFS; d++)
        r->id.test[d].asked_amplitude = (double)NAN, r->id.test[d].achieved_amplitude = 0, r->id.test[d].unwanted_pct[2] = 99;
    assert_passes(r);
    struct verdict v = judge(r);
    assert_int_equal(v.notes, 1);
    assert_non_null(strstr(v.note[0], "no reference"));
    r->id.test[4].asked_amplitude = r->id.test[4].amplitude;
    assert_int_equal(judge(r).status, VERDICT_FAIL);
    /* The reference is the requested amplitude, whatever the configuration (-c) has. */
    r = good_run();
    for (int d = 0; d < DOFS; d++) r->id.test[d].amplitude *= 3;
    assert_passes(r);
}

static void print_gives_status_and_reasons(void **unused) {
    (void)unused;
    struct verdict v = {.status = VERDICT_PASS};
    char text[400] = {0};
    verdict_add(&v, VERDICT_NOT_EVALUATED, "first %d", 1);
    verdict_add(&v, VERDICT_FAIL, "second");
    verdict_note(&v, "a note");
    FILE *out = fmemopen(text, sizeof text, "w");
    assert_non_null(out);
    verdict_print(&v, out);
    fclose(out);
    assert_string_equal(text, "verdict   fail\n          first 1\n          second\n          (a note)\n");
}

/* The friction of one group of parts is off; then an entry of the matrix is off too, by less. */
static void a_machine_that_changes_on_the_way_is_noted_and_a_matrix_that_does_fails(void **unused) {
    (void)unused;
    struct run *r = good_run();
    struct agreement *a = &r->id.over_time;
    r->id.method_c.matrix.evaluated = true;
    *a = (struct agreement){.logs = 4, .evaluated = true, .agree = true};
    assert_passes(r);
    a->agree = false;
    a->deviation[2][UNKNOWN_DRY] = -9.0, a->apart[2][UNKNOWN_DRY] = true;
    assert_passes_with_a_note(r, "dry leg 1 extending of group 3 of 4 is -9.0 standard deviations");
    a->deviation[1][0] = 6.0, a->apart[1][0] = true;
    assert_one_reason(r, VERDICT_FAIL, "Mt11 of group 2 of 4 is +6.0 standard deviations");
}

static void a_test_whose_periods_were_not_compared_does_not_pass(void **unused) {
    (void)unused;
    struct run *r = good_run();
    r->id.test[DOF_Z].witness.compared = false;
    const struct verdict v = judge(r);
    assert_int_equal(v.status, VERDICT_NOT_EVALUATED);
    assert_non_null(strstr(v.reason[0], "test z: its periods cannot be compared"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_test_whose_periods_were_not_compared_does_not_pass),
        cmocka_unit_test(a_good_run_passes_without_a_reason),
        cmocka_unit_test(amplitude_is_limited_on_both_sides),
        cmocka_unit_test(unwanted_motion_is_limited_in_every_axis_of_every_test),
        cmocka_unit_test(a_leg_off_its_reference_is_limited_on_both_sides),
        cmocka_unit_test(excluded_samples_are_limited_in_every_test),
        cmocka_unit_test(overruns_are_limited),
        cmocka_unit_test(asymmetry_is_limited_in_every_pair_of_entries),
        cmocka_unit_test(a_matrix_far_from_method_c_fails_its_method_and_not_the_run),
        cmocka_unit_test(a_matrix_that_is_not_positive_definite_fails),
        cmocka_unit_test(a_matrix_with_what_is_not_a_number_fails),
        cmocka_unit_test(an_incomplete_test_is_not_evaluated),
        cmocka_unit_test(missing_tests_are_not_evaluated),
        cmocka_unit_test(without_a_matrix_it_is_not_evaluated_and_its_entries_are_not_looked_at),
        cmocka_unit_test(a_failure_outweighs_what_was_not_evaluated_whichever_comes_first),
        cmocka_unit_test(the_run_has_the_verdict_of_method_c_where_that_has_a_result),
        cmocka_unit_test(a_run_that_method_c_refused_is_not_evaluated_and_says_why),
        cmocka_unit_test(where_the_machine_is_refuted_no_method_is_evaluated),
        cmocka_unit_test(entries_that_method_c_leaves_open_in_tests_of_few_axes_are_not_evaluated),
        cmocka_unit_test(an_amplitude_without_a_reference_is_not_judged),
        cmocka_unit_test(reasons_beyond_the_last_place_still_count),
        cmocka_unit_test(a_machine_that_changes_on_the_way_is_noted_and_a_matrix_that_does_fails),
        cmocka_unit_test(print_gives_status_and_reasons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
