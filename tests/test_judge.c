/* From figures to a verdict: which figures refute an effect that fits the equations, and which do
 * not. */
#include "support.h"

#include <math.h>

#include "config.h"
#include "goodness.h"
#include "judge.h"

enum { VALUES = 1800 };
static const struct remainder noise = {.values = VALUES, .noise = 1.2 * VALUES, .before = 5e4, .after = 0.6 * VALUES, .beyond_laws = 0.5};
static const struct remainder much = {.values = VALUES, .noise = 1.2 * VALUES, .before = 5e4, .after = 4e4, .beyond_laws = 20.0};

/* Returns a result with one effect, found in the equations and in closed loop, for a gap ten times
 * the noise. */
static struct gap_result found(const char *name) {
    struct gap_result r = {.effects = 1, .simulated = true, .effect[0] = {.effect = effect_find(name), .z = 200.0}};
    r.noise_floor.overall = r.noise_floor.varying = 0.1, r.held_out_before.overall = r.held_out_before.varying = 1.0;
    r.held_out_after.overall = r.held_out_after.varying = 0.1;
    for (int ch = 0; ch < GAP_CHANNELS; ch++) r.noise_floor.channel[ch] = 1.0, r.held_out_before.channel[ch] = 10.0;
    return r;
}

static void assert_verdict(struct gap_result *r, const struct remainder *m, enum gap_verdict verdict, const char *says) {
    judge(r, m);
    assert_int_equal(r->verdict, verdict);
    if (!strstr(r->reason, says)) fail_msg("\"%s\" does not say \"%s\"", r->reason, says);
}

static void what_explains_the_gap_is_named(void **state) {
    (void)state;
    struct gap_result r = found("valve_lag"), nothing = {0};
    assert_verdict(&r, &noise, GAP_EFFECT_NAMED, "the model lacks valve_lag");
    assert_string_equal(r.next_experiment, "");
    assert_verdict(&nothing, &noise, GAP_NO_GAP, "noise");
}

/* Seals that warm up leave a friction of the right kind, which no test has. */
static void a_friction_that_changes_is_said_to_change(void **state) {
    (void)state;
    struct gap_result r = found("cylinder_coulomb_friction"), grows = r, unknown = r;
    int effect = effect_find("cylinder_coulomb_friction");
    r.course = (struct gap_course){.frictions = 1, .effect = effect, .ratio = 1.44, .most = {0, DOF_X}, .least = {5, DOF_PSI}};
    grows.course = (struct gap_course){.frictions = 2, .effect = effect, .ratio = 30.0, .at_least = true, .most = {5, DOF_PSI}};
    unknown.course = r.course;
    assert_verdict(&r, &noise, GAP_EFFECT_NAMED, "cylinder_coulomb_friction is 1.44 times as large in test 1 (x) as in test 6 (psi)");
    assert_true(strstr(r.reason, "warm up") && strstr(r.next_experiment, "the same tests twice"));
    assert_verdict(&grows, &noise, GAP_EFFECT_NAMED, "dry friction is at least 30 times as large in test 6 (psi)");
    assert_null(strstr(grows.reason, "warm up"));
    judge(&unknown, &much);
    assert_int_equal(unknown.verdict, GAP_UNKNOWN_EFFECT);
    assert_null(strstr(unknown.reason, "times as large"));
}

static void rivals_make_it_ambiguous_and_name_the_experiment(void **state) {
    (void)state;
    struct gap_result r = found("valve_lag");
    r.ambiguous = 1, r.ambiguous_with[0] = effect_find("command_delay");
    assert_verdict(&r, &noise, GAP_AMBIGUOUS, "cannot tell valve_lag from command_delay");
    assert_non_null(strstr(r.next_experiment, "tests.frequency_hz=36"));
    r.effects = 2, r.in_doubt = 1;
    r.effect[1] = r.effect[0], r.effect[0].effect = effect_find("payload_mass");
    assert_verdict(&r, &noise, GAP_AMBIGUOUS, "the model lacks payload_mass; these data cannot tell valve_lag from command_delay");
}

static void at_one_frequency_a_part_that_moves_by_itself_looks_like_a_mass_or_a_spring(void **state) {
    (void)state;
    static const char *const says = "a part that moves by itself";
    struct gap_result mass = found("payload_mass"), spring = found("external_stiffness"), lag = found("valve_lag");
    struct gap_result *one[] = {&mass, &spring, &lag};
    for (int i = 0; i < 3; i++) {
        config_default(&one[i]->model);
        judge(one[i], &noise);
        assert_null(strstr(one[i]->reason, says));
        one[i]->one_hz = 4.0;
        judge(one[i], &noise);
        assert_int_equal(one[i]->verdict, GAP_EFFECT_NAMED);
        assert_int_equal(strstr(one[i]->reason, says) != NULL, i < 2);
        assert_int_equal(strstr(one[i]->next_experiment, "tests.frequency_hz=2") != NULL, i < 2);
    }
    mass.ambiguous = 1, mass.ambiguous_with[0] = effect_find("external_stiffness");
    assert_verdict(&mass, &noise, GAP_AMBIGUOUS, says);
    assert_verdict(&mass, &much, GAP_UNKNOWN_EFFECT, "remainder");
    assert_null(strstr(mass.reason, "at one frequency"));
    mass.ambiguous = 0, mass.effects = 2, mass.effect[1] = spring.effect[0];
    assert_verdict(&mass, &noise, GAP_UNKNOWN_EFFECT, "payload_mass and external_stiffness explain the gap, but at one frequency");
    assert_non_null(strstr(mass.next_experiment, "tests.frequency_hz=2"));
    assert_false(judge_partly(&mass));
    mass.effect[0].given.on = true; /* of another size, and as alike as before */
    assert_verdict(&mass, &noise, GAP_UNKNOWN_EFFECT, "at one frequency");
    mass.effect[0].given.on = false, mass.one_hz = 0.0;
    assert_verdict(&mass, &noise, GAP_EFFECT_NAMED, "payload_mass and external_stiffness");
}

static void a_constant_that_looks_the_same_is_to_be_checked_first(void **state) {
    (void)state;
    static const struct {
        const char *effect, *says;
        enum mechanism_kind mechanism;
    } cases[] = {{"payload_mass", "; first check axis.mass_kg in the configuration", MECHANISM_AXIS},
                 {"payload_mass", "; first check payload.mass_kg in the configuration", MECHANISM_STEWART},
                 {"cylinder_viscous_friction", "; first check hydraulics.viscous_n_s_per_m in the configuration", MECHANISM_AXIS}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct gap_result r = found(cases[i].effect);
        config_default(&r.model);
        r.model.mechanism = cases[i].mechanism;
        assert_verdict(&r, &noise, GAP_EFFECT_NAMED, cases[i].says);
    }
    struct gap_result friction = found("cylinder_coulomb_friction"), resized = found("payload_mass");
    config_default(&friction.model);
    config_default(&resized.model);
    friction.model.mechanism = MECHANISM_AXIS, resized.effect[0].given.on = true;
    for (int i = 0; i < 2; i++) {
        struct gap_result *r = i ? &resized : &friction;
        judge(r, &noise);
        assert_null(strstr(r->reason, "check"));
    }
}

/* The remainder is measured in units of the noise and of the possible error of the laws in the
 * model. */
static void what_a_law_leaves_is_no_remainder(void **state) {
    (void)state;
    struct gap_result friction = found("cylinder_coulomb_friction");
    struct remainder left = {.values = VALUES, .noise = 1.2 * VALUES, .before = 1e5, .after = VALUES + 3500.0, .beyond_laws = 0.9};
    assert_verdict(&friction, &left, GAP_EFFECT_NAMED, "cylinder_coulomb_friction");
    left.beyond_laws = 1.1;
    assert_verdict(&friction, &left, GAP_UNKNOWN_EFFECT, "remainder");
}

/* Weighs residuals. Half of them have mean square a, the other half b; in the latter a law may be
 * off by `law` standard deviations of noise. */
static double weighed(double a, double b, double law) {
    static double white[VALUES], one[VALUES], error[VALUES];
    for (int i = 0; i < VALUES; i++) {
        bool first = i < VALUES / 2;
        white[i] = sqrt(first ? a : b), one[i] = 1.0, error[i] = first ? 0.0 : law * law;
    }
    return goodness_weigh(VALUES, white, one, error);
}

static void a_law_excuses_what_is_left_where_it_acts_and_nowhere_else(void **state) {
    (void)state;
    assert_in_range(1000.0 * weighed(0.5, 0.5, 0.0), 400, 600); /* noise as measured */
    assert_true(weighed(1.2, 1.2, 0.0) > 1.0);
    assert_true(weighed(0.5, 100.0, 0.0) > 1.0);
    assert_true(weighed(0.5, 100.0, 3.0) < 1.0);  /* the residual, 10, is less than four times the
                                                   * law's error */
    assert_true(weighed(0.5, 2000.0, 3.0) > 1.0); /* more than that */
    assert_true(weighed(1.5, 0.5, 3.0) > 1.0);    /* the law does not excuse rows where it does not
                                                   * act */
    static const double white[] = {2.0, 0.0}, one[] = {1.0, 0.0}, law[] = {0.0, 0.0};
    /* a value without noise is not evaluated */
    assert_true(goodness_weigh(2, white, one, law) == goodness_weigh(1, white, one, law));
}

static void one_axis_gets_experiments_that_it_can_make(void **state) {
    (void)state;
    struct gap_result r = found("valve_lag"), tone = {0}, offset = found("cylinder_coulomb_friction");
    r.model.mechanism = tone.model.mechanism = offset.model.mechanism = MECHANISM_AXIS;
    r.ambiguous = 1, r.ambiguous_with[0] = effect_find("command_delay");
    assert_verdict(&r, &noise, GAP_AMBIGUOUS, "cannot tell valve_lag from command_delay");
    assert_null(strstr(r.next_experiment, "--"));
    tone.tone = (struct gap_tone){.hz = 5.6, .rms = 1.0, .channel = GAP_FORCE};
    assert_verdict(&tone, &noise, GAP_UNKNOWN_EFFECT, "a tone at 5.6 Hz");
    assert_null(strstr(tone.next_experiment, "platform"));
    offset.effect[0].values.value[0][0] = 120.0, offset.effect[0].values.value[1][0] = 40.0;
    assert_verdict(&offset, &noise, GAP_AMBIGUOUS, "a constant force");
    assert_non_null(strstr(offset.next_experiment, "let go of the load"));
    offset.model.mechanism = MECHANISM_STEWART; /* a platform's weight and geometry distinguish a
                                                 * constant force from friction */
    assert_verdict(&offset, &noise, GAP_EFFECT_NAMED, "cylinder_coulomb_friction");
}

static void dry_friction_of_one_direction_is_perhaps_a_constant_force(void **state) {
    (void)state;
    static const char *const dry[] = {"cylinder_coulomb_friction", "cylinder_dahl_friction"};
    for (size_t i = 0; i < sizeof dry / sizeof *dry; i++) {
        struct gap_result r = found(dry[i]);
        config_default(&r.model);
        r.model.mechanism = MECHANISM_AXIS;
        r.effect[0].values.value[0][0] = 303.0, r.effect[0].values.value[1][0] = 12.0, r.effect[0].std[0][0] = r.effect[0].std[1][0] = 10.0;
        assert_verdict(&r, &noise, GAP_AMBIGUOUS, "friction of 158 N beside a constant force of 146 N");
        assert_non_null(strstr(r.reason, dry[i]));
        assert_non_null(strstr(r.next_experiment, "an offset stays"));
        r.effect[0].values.value[1][0] = 300.0;
        assert_verdict(&r, &noise, GAP_EFFECT_NAMED, dry[i]);
    }
}

static void what_remains_refutes_it(void **state) {
    (void)state;
    struct gap_result in_equations = found("valve_lag"), in_simulation = found("valve_lag"), no_run = found("geometry_error");
    assert_verdict(&in_equations, &much, GAP_UNKNOWN_EFFECT, "remainder");
    /* the gap is small, and so is the improvement */
    in_simulation.held_out_before.varying = 0.107, in_simulation.held_out_after.varying = 0.105;
    assert_verdict(&in_simulation, &noise, GAP_EFFECT_NAMED, "valve_lag");
    /* a remainder that does not vary is reported */
    in_simulation.held_out_after.overall = 9.0, in_simulation.unexplained_fraction = 0.9;
    assert_verdict(&in_simulation, &noise, GAP_EFFECT_NAMED, "what simulation leaves is constant");
    in_simulation.held_out_after.varying = 0.2; /* there was no gap before: the effect made it */
    assert_verdict(&in_simulation, &noise, GAP_UNKNOWN_EFFECT, "leaves 100 %");
    in_simulation.held_out_before.varying = 0.124, in_simulation.held_out_after.varying = 0.115;
    assert_verdict(&in_simulation, &noise, GAP_UNKNOWN_EFFECT, "leaves 60 %");
    /* it contradicts nothing */
    snprintf(no_run.replay_fault, sizeof no_run.replay_fault, "the simulated run ended in a fault (stroke)");
    assert_verdict(&no_run, &noise, GAP_EFFECT_NAMED,
                   "geometry_error; not shown by simulation: the simulated run ended in a fault (stroke)");
}

static void what_is_left_far_above_the_noise_refutes_it_in_motion_too(void **state) {
    (void)state;
    struct gap_result r = found("valve_flow_gain"), nothing = {0};
    /* a small gap: the difference is within noise */
    r.simulated = false, r.held_out_before.overall = 0.12, r.held_out_after.overall = 0.119;
    assert_verdict(&r, &noise, GAP_EFFECT_NAMED, "valve_flow_gain");
    /* a large gap: the remainder is within the model's own error */
    r.held_out_before.overall = 2.0, r.held_out_after.overall = 0.21;
    assert_verdict(&r, &noise, GAP_EFFECT_NAMED, "valve_flow_gain");
    r.held_out_before.overall = 0.4;
    assert_verdict(&r, &noise, GAP_UNKNOWN_EFFECT, "2.1 times the noise");
    nothing.simulated = nothing.validated = true;
    nothing.noise_floor.overall = 0.1, nothing.held_out_before.overall = nothing.held_out_after.overall = 0.19;
    assert_verdict(&nothing, &noise, GAP_NO_GAP, "noise");
    nothing.held_out_before.overall = nothing.held_out_after.overall = 0.21;
    assert_verdict(&nothing, &noise, GAP_UNKNOWN_EFFECT, "--validate is 2.1 times the noise");
}

static void what_is_given_is_of_another_size(void **state) {
    (void)state;
    struct gap_result r = found("valve_lag");
    struct remainder left = {.values = VALUES, .noise = 1.2 * VALUES, .before = 5e3, .after = VALUES + 5e3, .beyond_laws = 3.0};
    r.effect[0].given.on = true;
    assert_verdict(&r, &noise, GAP_EFFECT_NAMED, "the model has valve_lag of another size");
    r.effects = 3;
    r.effect[1] = (struct gap_effect){.effect = effect_find("base_tilt"), .z = 9.0};
    r.effect[2] = (struct gap_effect){.effect = effect_find("payload_mass"), .z = 8.0};
    assert_verdict(&r, &noise, GAP_EFFECT_NAMED, "the model lacks base_tilt and payload_mass and has valve_lag of another size");
    assert_verdict(&r, &left, GAP_UNKNOWN_EFFECT, "remainder");
    left.beyond_laws = 0.9; /* possible error of the given laws */
    assert_verdict(&r, &left, GAP_EFFECT_NAMED, "valve_lag");
    r.effects = 0;
    assert_verdict(&r, &left, GAP_NO_GAP, "no more than the effects in the configuration leave");
}

/* A single effect that explains nearly all of a gap is present; two effects together can imitate
 * another one as well. */
static void a_trace_beside_one_effect_is_said_and_refutes_nothing(void **state) {
    (void)state;
    struct gap_result one = found("valve_dead_band"), two = one;
    struct remainder left = {.values = VALUES, .noise = 1.2 * VALUES, .before = 1e6, .after = 1.2 * VALUES + 4e3, .beyond_laws = 3.0};
    assert_verdict(&one, &left, GAP_EFFECT_NAMED, "lacks valve_dead_band; 0.4 % of the gap's square is left");
    two.effects = 2, two.effect[1] = (struct gap_effect){.effect = effect_find("base_tilt"), .z = 150.0};
    assert_verdict(&two, &left, GAP_UNKNOWN_EFFECT, "remainder");
    left.after = 1.2 * VALUES + 6e3;
    assert_verdict(&one, &left, GAP_UNKNOWN_EFFECT, "remainder");
}

/* A tone is negligible below half of its channel's gap above the noise, sqrt(10^2 - 1^2). */
static void a_tone_refutes_what_is_no_larger_than_it(void **state) {
    (void)state;
    struct gap_result weak = found("load_dependent_friction"), strong = weak, known = weak, alone = weak;
    weak.tone = (struct gap_tone){.hz = 5.6, .rms = 4.5, .channel = GAP_LENGTH};
    assert_verdict(&weak, &noise, GAP_EFFECT_NAMED, "lacks load_dependent_friction; besides, a tone at 5.6 Hz");
    strong.tone = (struct gap_tone){.hz = 5.6, .rms = 5.5, .channel = GAP_LENGTH};
    assert_verdict(&strong, &noise, GAP_UNKNOWN_EFFECT, "a tone at 5.6 Hz");
    /* the model with the effect oscillates as well */
    known.tone = strong.tone, known.tone_simulated = true;
    assert_verdict(&known, &noise, GAP_EFFECT_NAMED, "load_dependent_friction");
    alone.tone = weak.tone, alone.effects = 0;
    assert_verdict(&alone, &noise, GAP_UNKNOWN_EFFECT, "a tone at 5.6 Hz");
}

static void what_others_explain_as_well_is_named_in_part(void **state) {
    (void)state;
    struct gap_result sure = found("valve_lag"), unsure = sure, needless = sure, nothing = {0}, unknown = sure;
    struct gap_certainty other = {0.3, 0.7, 2, {effect_find("command_delay"), effect_find("base_tilt")}}, none = {1e-9, 0.99995, 0, {0}};
    unsure.moved_hz = 4.01, unsure.stated_hz = 4.0;
    judge(&sure, &noise), judge(&unsure, &noise), judge(&needless, &noise), judge(&nothing, &noise), judge(&unknown, &noise);
    judge_certainty(&sure, &noise, &(struct gap_certainty){.probability = 0.96});
    judge_certainty(&unknown, &noise, &(struct gap_certainty){.probability = (double)NAN});
    judge_certainty(&unsure, &noise, &other), judge_certainty(&needless, &noise, &none), judge_certainty(&nothing, &noise, &other);
    assert_true(sure.verdict == GAP_EFFECT_NAMED && unknown.verdict == GAP_EFFECT_NAMED);
    assert_true(sure.certainty.probability == 0.96 && isnan(unknown.certainty.probability) && unsure.certainty.probability == 0.3);
    assert_true(unsure.verdict == GAP_PARTLY_NAMED && needless.verdict == GAP_PARTLY_NAMED && nothing.verdict == GAP_NO_GAP);
    assert_non_null(strstr(unsure.reason, "lacks valve_lag"));
    assert_non_null(strstr(unsure.reason, "; the probability of this verdict is 0.3, that of command_delay and base_tilt alone 0.7"));
    assert_non_null(strstr(needless.reason, "; the probability of this verdict is below 0.001, that of no effect above 0.999"));
    assert_non_null(strstr(nothing.reason, "noise; the probability of this verdict is 0.3, that of command_delay and base_tilt alone 0.7"));
}

/* With statements a family may stand in place of an effect. */
static void what_leaves_a_remainder_is_named_in_part(void **state) {
    (void)state;
    struct gap_result r = found("valve_lag");
    r.effects = 2, r.effect[1] = (struct gap_effect){.effect = effect_find("payload_mass")};
    r.unexplained_fraction = 0.2;
    assert_true(judge_partly(&r));
    assert_int_equal(r.verdict, GAP_PARTLY_NAMED);
    assert_non_null(strstr(r.reason, "the model lacks valve_lag and payload_mass; that explains 80 %"));
    r.statements = 1, r.statement[0] = (struct gap_statement){.family = true, .which = EFFECT_LOAD};
    assert_true(judge_partly(&r));
    assert_non_null(strstr(r.reason, effect_families[EFFECT_LOAD].words));
    assert_non_null(strstr(r.reason, "payload_mass"));
}

static void an_effect_that_another_replaces_is_ambiguous(void **state) {
    (void)state;
    struct gap_result r = found("external_stiffness"), sure = r;
    struct gap_certainty other = {0.02, 0.97, 2, {effect_find("valve_lag"), effect_find("payload_mass")}};
    r.effects = 2, r.effect[1] = (struct gap_effect){.effect = effect_find("valve_lag"), .z = 30.0};
    judge(&r, &noise), judge(&sure, &noise);
    judge_certainty(&r, &noise, &other), judge_certainty(&sure, &noise, &other);
    assert_true(r.verdict == GAP_AMBIGUOUS && r.in_doubt == 0 && r.ambiguous == 1 && r.ambiguous_with[0] == effect_find("payload_mass"));
    assert_non_null(strstr(r.reason, "lacks valve_lag; these data cannot tell external_stiffness from payload_mass"));
    assert_null(strstr(r.reason, "probability"));
    assert_string_not_equal(r.next_experiment, "");
    assert_close(r.certainty.probability, 0.99, 1e-12);
    assert_int_equal(sure.verdict, GAP_PARTLY_NAMED); /* two in place of one, not both alike */
}

static void an_effect_that_two_together_look_like_is_ambiguous(void **state) {
    (void)state;
    struct gap_result r = found("external_stiffness");
    struct gap_certainty other = {0.6, 0.39, 2, {effect_find("payload_mass"), effect_find("payload_rotational_inertia")}};
    judge(&r, &noise);
    judge_certainty(&r, &noise, &other);
    assert_true(r.verdict == GAP_AMBIGUOUS && r.ambiguous == 2 && r.ambiguous_together);
    assert_non_null(strstr(r.reason, "cannot tell external_stiffness from payload_mass and payload_rotational_inertia"));
    assert_non_null(strstr(r.next_experiment, "tests.frequency_hz"));
}

static void three_that_are_needed_are_none_of_them(void **state) {
    (void)state;
    struct gap_result r = found("valve_lag");
    r.effects = 3;
    r.effect[1] = (struct gap_effect){.effect = effect_find("base_tilt"), .z = 150.0};
    r.effect[2] = (struct gap_effect){.effect = effect_find("payload_mass"), .z = 100.0};
    assert_verdict(&r, &noise, GAP_UNKNOWN_EFFECT, "takes 3");
    r.effect[2].z = 10.0; /* the third effect explains too little to be needed */
    assert_verdict(&r, &noise, GAP_EFFECT_NAMED, "valve_lag, base_tilt and payload_mass");
    /* the search ended at its limit, so the last effects count although they weigh little */
    r.effects = GAP_EFFECTS;
    for (int k = 1; k < GAP_EFFECTS; k++) r.effect[k].z = 7.0;
    assert_verdict(&r, &noise, GAP_UNKNOWN_EFFECT, "it takes 4 to imitate it");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_explains_the_gap_is_named),
        cmocka_unit_test(a_friction_that_changes_is_said_to_change),
        cmocka_unit_test(rivals_make_it_ambiguous_and_name_the_experiment),
        cmocka_unit_test(at_one_frequency_a_part_that_moves_by_itself_looks_like_a_mass_or_a_spring),
        cmocka_unit_test(a_constant_that_looks_the_same_is_to_be_checked_first),
        cmocka_unit_test(what_a_law_leaves_is_no_remainder),
        cmocka_unit_test(a_law_excuses_what_is_left_where_it_acts_and_nowhere_else),
        cmocka_unit_test(one_axis_gets_experiments_that_it_can_make),
        cmocka_unit_test(dry_friction_of_one_direction_is_perhaps_a_constant_force),
        cmocka_unit_test(what_remains_refutes_it),
        cmocka_unit_test(what_is_left_far_above_the_noise_refutes_it_in_motion_too),
        cmocka_unit_test(what_is_given_is_of_another_size),
        cmocka_unit_test(a_trace_beside_one_effect_is_said_and_refutes_nothing),
        cmocka_unit_test(a_tone_refutes_what_is_no_larger_than_it),
        cmocka_unit_test(what_others_explain_as_well_is_named_in_part),
        cmocka_unit_test(what_leaves_a_remainder_is_named_in_part),
        cmocka_unit_test(an_effect_that_another_replaces_is_ambiguous),
        cmocka_unit_test(an_effect_that_two_together_look_like_is_ambiguous),
        cmocka_unit_test(three_that_are_needed_are_none_of_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
