/* Texts of a survey's result, and the figures of its predictions. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "survey_report.h"

/* Prints a survey that found these damping ratios and predicted these deviations. */
static char *printed(double damping, double predicted_pct, bool reached) {
    char *text;
    size_t size;
    struct survey_report *r = calloc(1, sizeof *r);
    FILE *out = open_memstream(&text, &size);
    assert_true(r && out);
    config_default(&r->asked);
    r->wanted_pct = 0.5;
    r->survey.determined = true;
    r->survey.multisine.tones = 1;
    for (int i = 0; i < DOFS; i++)
        r->survey.mode[i].dof = (enum dof)i, r->survey.loop[i] = (struct loop_mode){.hz = 10.0 + i, .damping = 0.3};
    r->survey.loop[2].damping = damping;
    for (int i = 0; i < PROPOSALS; i++) {
        r->proposal[i].tests = r->asked.tests;
        r->proposal[i].predicted.worst_pct = predicted_pct, r->proposal[i].reached = reached;
    }
    survey_report_print(r, out);
    fclose(out);
    free(r);
    return text;
}

static void assert_printed(char *text, const char *words, bool expected) {
    if ((strstr(text, words) != NULL) != expected) fail_msg("\"%s\" is %s in\n%s", words, expected ? "not" : "", text);
    free(text);
}

static void a_deviation_above_the_wanted_one_is_not_the_wanted_one(void **unused) {
    (void)unused;
    assert_printed(printed(0.3, 0.524, true), "NOT the 0.5 % wanted, but within 5 % of it", true);
    assert_printed(printed(0.3, 0.6, false), "NOT the 0.5 % wanted: a longer test would come no nearer", true);
    assert_printed(printed(0.3, 0.5, true), "NOT the", false);
    assert_printed(printed(0.3, 0.48, true), "NOT the", false);
}

static void a_mode_that_rings_is_remarked_with_what_to_look_at(void **unused) {
    (void)unused;
    assert_printed(printed(0.02, 0.5, true), "HARDLY DAMPED: mode 3 of the closed loop, mostly z, at 12 Hz: damping ratio 0.02, below 0.05",
                   true);
    assert_printed(printed(0.02, 0.5, true), "control.kpf", true);
    assert_printed(printed(0.06, 0.5, true), "HARDLY DAMPED", false);
    assert_printed(printed((double)NAN, 0.5, true), "HARDLY DAMPED", false);
}

/* Returns a matrix whose entries all have a deviation of 1 %, except one. */
static struct method_result matrix(int row, int column, double pct) {
    struct method_result m = {.evaluated = true};
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) m.mt[i][j] = i == j ? 4.0 : 0.0, m.mt_std[i][j] = 0.04;
    m.mt_std[row][column] = m.mt_std[column][row] = 0.04 * pct;
    return m;
}

static void predicted_figures_are_of_all_draws(void **unused) {
    (void)unused;
    const struct method_result found[] = {matrix(0, 4, 9.0), matrix(0, 4, 5.0), matrix(2, 2, 7.0)};
    struct excitation e = excitation_of(3, found);
    assert_float_equal(e.worst_pct, 7.0, 1e-12);
    assert_true(e.row == DOF_X && e.column == DOF_THETA); /* in the last draw the worst entry is
                                                           * that of z, so the last draw alone does
                                                           * not decide */
    assert_float_equal(e.axis_pct[DOF_X], 5.0, 1e-12);
    assert_float_equal(e.axis_pct[DOF_THETA], 5.0, 1e-12);
    assert_float_equal(e.axis_pct[DOF_Z], 3.0, 1e-12);
    assert_float_equal(e.axis_pct[DOF_PSI], 1.0, 1e-12);
}

static void proposed_tests_are_options_of_hexid_run(void **unused) {
    (void)unused;
    char text[600];
    struct proposal p = {
        .tests = {
            .multisine = true, .hz = {1.5, 2, 2.5, 3, 3.5, 4}, .amplitude = {0.01, 0.02, 0.03, 0.04, 0.05, 0.06}, .duration_s = 12.3}};
    proposal_options(&p, text, sizeof text);
    assert_string_equal(text,
                        "--tests x,y,z,phi,theta,psi --set tests.multisine=true --set tests.frequency_hz=1.5,2,2.5,3,3.5,4 "
                        "--set tests.amplitude_m=0.01,0.02,0.03 --set tests.amplitude_rad=0.04,0.05,0.06 --set tests.duration_s=12.3");
    assert_printed(printed(0.3, 0.5, true), "hexid run --tests x,y,z,phi,theta,psi --set tests.multisine=false", true);
}

static void never(void *context, double share) {
    (void)context;
    fail_msg("a prediction was begun at %g", share);
}

static void what_a_survey_does_not_determine_is_no_proposal(void **unused) {
    (void)unused;
    struct loop_survey *s = calloc(1, sizeof *s);
    struct proposal_watch watch = {.share = never};
    struct params params;
    struct proposal p;
    struct error error;
    config_default(&params);
    for (int kind = 0; kind < PROPOSALS; kind++) {
        s->determined = false;
        assert_int_equal(propose((enum proposal_kind)kind, s, &params, 1.0, &watch, &p, &error), STATUS_OK);
        assert_true(p.none.status && !p.reached && strstr(p.none.text, "is not determined"));
        s->determined = true;
        for (int i = 0; i < DOFS; i++) s->mode[i].hz = 2.9, s->loop[i].hz = 10.0;
        assert_int_equal(propose((enum proposal_kind)kind, s, &params, 1.0, &watch, &p, &error), STATUS_OK);
        assert_true(p.none.status && strstr(p.none.text, "above the survey's lowest tone, 1 Hz"));
    }
    free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_deviation_above_the_wanted_one_is_not_the_wanted_one),
        cmocka_unit_test(a_mode_that_rings_is_remarked_with_what_to_look_at),
        cmocka_unit_test(predicted_figures_are_of_all_draws),
        cmocka_unit_test(proposed_tests_are_options_of_hexid_run),
        cmocka_unit_test(what_a_survey_does_not_determine_is_no_proposal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
