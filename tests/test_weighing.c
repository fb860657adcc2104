/* A known weight is weighed by the legs. The expected readings follow from statics at neutral,
 * written here with the drawing's angles: each leg carries H / L of its force upwards. */
#include "support.h"

#include "weighing.h"

enum { TESTS = 6, CYCLES = 2000, STEPS = 2000 };
static const double WEIGHT_KG = 80.0, G = 9.80665;

/* The machine, and the errors of its sensors. */
struct scale {
    struct params params;
    double length_m, rise; /* length of each leg at neutral, and H / L */
    double gain[2][LEGS], zero_pa[2][LEGS];
    double joint_m;        /* excess of the reading of leg 1's length */
    double extra_kg[TESTS];/* mass that a test with the weight carries in addition */
    double drift_pa[2][LEGS]; /* change of the zeros in the log with the weight */
    struct rest_found rest[2];
    struct method_c friction;
    int extends[2];        /* number of steps, of STEPS, in which the legs extend, without and with
                            * the weight; in the others they retract */
    double dry_n[2];       /* dry friction of each leg, when it extends and when it retracts */
};

static void scale_init(struct scale *s) {
    const struct geometry_params *g = &s->params.geometry;
    memset(s, 0, sizeof *s);
    config_default(&s->params);
    s->params.model.tolerance.joints_m = s->params.model.tolerance.length_zero_m = 0.0;
    s->params.model.tolerance.pressure_drift_pa = 0.0;
    double turned = PI / 3.0 - g->upper_half_angle_rad - g->lower_half_angle_rad, a = g->upper_radius_m, b = g->lower_radius_m;
    s->length_m = sqrt(a * a + b * b - 2.0 * a * b * cos(turned) + g->height_m * g->height_m);
    s->rise = g->height_m / s->length_m;
}

/* Makes a cycle in which the legs carry a mass. The legs share it unequally, and the pressures on
 * the rod side differ from test to test. */
static struct cycle carrying(const struct scale *s, double mass_kg, int test, bool with, int step, uint64_t *seed) {
    const struct actuator_params *p = &s->params.actuator;
    struct cycle c = {.test = test, .dof = (enum dof)test, .phase = PHASE_EVALUATE};
    for (int k = 0; k < LEGS; k++) {
        double a1 = PI / 4.0 * p->piston_diameter_m[k] * p->piston_diameter_m[k];
        double a2 = a1 - PI / 4.0 * p->rod_diameter_m[k] * p->rod_diameter_m[k];
        double share = (1.0 + 0.3 * (k - 2.5) / 2.5) / LEGS, friction_n = 40.0 * k;
        int extends = s->extends[with], phase = step % STEPS;
        bool out = phase < extends;
        friction_n += extends ? (out ? s->dry_n[0] : -s->dry_n[1]) : 0.0;
        /* a sawtooth of 1 um, too small to change the share of a leg's force that lifts */
        double saw_m = extends ? 1e-6 * (out ? (double)phase / extends : (double)(STEPS - phase) / (STEPS - extends)) : 0.0;
        double p2 = 4e6 + (with ? -2e4 * (k + 1) : 0.0) + 1e5 * test;
        double p1 = (mass_kg * G * share / s->rise + friction_n + a2 * p2) / a1;
        double noise_n = 50.0 * random_unit(seed); /* noise of both chambers that does not change
                                                    * the force */
        p1 += noise_n / a1, p2 += noise_n / a2;
        c.in.p1_pa[k] = (1.0 + s->gain[0][k]) * p1 + s->zero_pa[0][k] + with * s->drift_pa[0][k];
        c.in.p2_pa[k] = (1.0 + s->gain[1][k]) * p2 + s->zero_pa[1][k] + with * s->drift_pa[1][k];
        c.in.length_m[k] = s->length_m + saw_m + (k ? 0.0 : s->joint_m);
    }
    return c;
}

static void record(const struct scale *s, struct weighing *w, double mass_kg, bool with, int tests) {
    uint64_t seed = 3;
    weighing_init(w, &s->params);
    for (int test = 0; test < tests; test++)
        for (int i = -STEPS; i < CYCLES; i++) {
            struct cycle c = carrying(s, mass_kg + (with ? WEIGHT_KG + s->extra_kg[test] : 0.0), test, with, i + STEPS, &seed);
            if (i < 0) c.phase = PHASE_RAMP_IN;
            weighing_take(w, &c);
        }
}

static struct weighing_found weighed(const struct scale *s) {
    static struct weighing without, with;
    struct weighing_found found;
    struct error error;
    record(s, &without, 290.0, false, TESTS), record(s, &with, 290.0, true, TESTS);
    const struct weighing_log log[] = {{&without, &s->rest[0]}, {&with, &s->rest[1]}};
    if (weighing_find(&log[0], &log[1], &s->params, (struct weight){WEIGHT_KG, 0.0}, &s->friction, &found, &error))
        fail_msg("%s", error.text);
    return found;
}

/* Both logs have the same zeros and dry friction. */
static void a_weight_reads_its_mass_whatever_zeros_and_friction_are(void **unused) {
    (void)unused;
    struct scale s;
    uint64_t seed = 9;
    scale_init(&s);
    for (int k = 0; k < LEGS; k++)
        for (int side = 0; side < 2; side++) s.zero_pa[side][k] = 1e5 * random_unit(&seed);
    struct weighing_found found = weighed(&s);
    assert_int_equal(found.tests, TESTS);
    assert_close(found.reading_kg, WEIGHT_KG, 1e-6);
    assert_close(found.std_kg, 0.0, 1e-6);
}

/* Tolerance: shares are computed from readings, so the gains themselves are in them, 0.01 of
 * 0.01. */
static void its_error_is_that_of_the_gains_by_their_shares(void **unused) {
    (void)unused;
    struct scale s;
    uint64_t seed = 11;
    double expected = 0.0, sum = 0.0;
    scale_init(&s);
    for (int k = 0; k < LEGS; k++)
        for (int side = 0; side < 2; side++) s.gain[side][k] = 0.01 * random_unit(&seed);
    struct weighing_found found = weighed(&s);
    for (int k = 0; k < LEGS; k++)
        for (int side = 0; side < 2; side++) expected += found.share[side][k] * s.gain[side][k], sum += found.share[side][k];
    assert_true(fabs(expected) > 1e-4);
    assert_close(found.reading_kg / WEIGHT_KG - 1.0, expected, 2e-4);
    assert_close(sum, found.reading_kg / WEIGHT_KG, 1e-9);
    weighing_note(&found, &s.params);
    assert_close(s.params.found.weight_error, expected, 2e-4);
}

/* Six readings with a sum of squares of 10 kg^2 about their mean have a variance of 10 / 5 / 6
 * kg^2, times 5 / 3 by Student's distribution. */
static void the_tests_scatter_gives_the_deviation(void **unused) {
    (void)unused;
    struct scale s;
    scale_init(&s);
    s.extra_kg[0] = 2.0, s.extra_kg[1] = -2.0, s.extra_kg[2] = 1.0, s.extra_kg[3] = -1.0;
    struct weighing_found found = weighed(&s);
    assert_close(found.reading_kg, WEIGHT_KG, 1e-6);
    assert_close(found.std_kg, sqrt(10.0 / 5.0 / 6.0 * 5.0 / 3.0), 1e-4);
}

/* A zero error of leg 1 changes the direction of all legs; the deviation includes the square of its
 * effect. */
static void a_zero_of_a_length_is_in_the_deviation(void **unused) {
    (void)unused;
    struct scale s;
    scale_init(&s);
    s.joint_m = 1e-3;
    double off = weighed(&s).reading_kg - WEIGHT_KG;
    s.joint_m = 0.0, s.params.model.tolerance.length_zero_m = 1e-3;
    double std = weighed(&s).std_kg;
    print_message("a zero of 1 mm in one length: %.4f kg; in all: std %.4f kg\n", off, std);
    assert_true(fabs(off) > 1e-3);
    assert_true(std > fabs(off));
    assert_below(std, 6.0 * fabs(off));
}

/* Gives both logs a rest, with zeros that have drifted before the second one. std_pa: deviation of
 * the zeros at rest. */
static void rest_before(struct scale *s, double std_pa) {
    s->rest[0].samples = s->rest[1].samples = 100;
    for (int k = 0; k < LEGS; k++)
        for (int side = 0; side < 2; side++) {
            s->rest[1].zero_pa[side][k] = s->drift_pa[side][k];
            s->rest[0].zero_std_pa[side][k] = s->rest[1].zero_std_pa[side][k] = std_pa;
        }
}

/* 2 kPa on the rodless side of leg 3 are 2e3 A1 H / L / g. Without rests they stay in the reading,
 * within its deviation. Exact rests take all of them off, and rests that are as uncertain as the
 * drift take half. */
static void zeros_that_drift_are_taken_off_as_far_as_rests_show_them(void **unused) {
    (void)unused;
    struct scale s;
    scale_init(&s);
    const double tolerance_pa = 2e3, bore = s.params.actuator.piston_diameter_m[2], rod = s.params.actuator.rod_diameter_m[2];
    const double a1 = PI / 4.0 * bore * bore, a2 = a1 - PI / 4.0 * rod * rod, kg = tolerance_pa * s.rise / G;
    s.params.model.tolerance.pressure_drift_pa = tolerance_pa;
    s.drift_pa[0][2] = 2e3;
    struct weighing_found unrested = weighed(&s);
    assert_close(unrested.reading_kg, WEIGHT_KG + kg * a1, 1e-6);
    assert_close(unrested.std_kg, kg * sqrt(LEGS * (a1 * a1 + a2 * a2)), 1e-6);
    rest_before(&s, 1e-3);
    struct weighing_found exact = weighed(&s);
    assert_close(exact.reading_kg, WEIGHT_KG, 1e-6);
    assert_close(exact.drift_kg, kg * a1, 1e-6);
    assert_below(exact.std_kg, 1e-5);
    rest_before(&s, tolerance_pa / sqrt(2.0));
    struct weighing_found half = weighed(&s);
    assert_close(half.reading_kg, WEIGHT_KG + 0.5 * kg * a1, 1e-6);
    assert_close(half.std_kg, unrested.std_kg / sqrt(2.0), 1e-6);
}

/* Legs that extend for 1100 of 2000 steps instead of 900 have a fifth of their dry friction more in
 * the mean. Only the mean of both directions counts. Near a reversal the direction over ten steps
 * is wrong, which makes 1 %. */
static void dry_friction_of_legs_that_extend_for_longer_is_taken_off(void **unused) {
    (void)unused;
    struct scale s;
    scale_init(&s);
    s.extends[0] = 900, s.extends[1] = 1100, s.dry_n[0] = 30.0, s.dry_n[1] = 50.0;
    double kg = LEGS * s.rise * 0.2 * 40.0 / G;
    assert_close(weighed(&s).reading_kg, WEIGHT_KG + kg, 1e-3); /* no friction is given, so none is
                                                                 * taken off */
    for (int k = 0; k < LEGS; k++) s.friction.dry[k][0] = 30.0, s.friction.dry[k][1] = 50.0;
    struct weighing_found found = weighed(&s);
    print_message("dry friction adds %.3f kg, %.3f kg are taken off\n", kg, found.friction_kg);
    assert_close(found.friction_kg, kg, 0.02 * kg);
    assert_close(found.reading_kg, WEIGHT_KG, 0.02 * kg);
    assert_close(found.std_kg, 0.2 * kg, 0.01 * kg);
}

static void logs_in_the_wrong_order_and_few_tests_are_refused(void **unused) {
    (void)unused;
    static struct weighing without, with, short_one;
    struct weighing_found found;
    struct error error;
    struct scale s;
    scale_init(&s);
    record(&s, &without, 290.0, false, TESTS), record(&s, &with, 290.0, true, TESTS);
    record(&s, &short_one, 290.0, true, WEIGHING_LEAST - 1);
    const struct weighing_log log[] = {{&without, s.rest}, {&with, s.rest}, {&short_one, s.rest}};
    assert_int_equal(weighing_find(&log[1], &log[0], &s.params, (struct weight){WEIGHT_KG, 0.0}, &s.friction, &found, &error),
                     STATUS_USAGE);
    assert_non_null(strstr(error.text, "without the weight"));
    assert_int_equal(weighing_find(&log[0], &log[2], &s.params, (struct weight){WEIGHT_KG, 0.0}, &s.friction, &found, &error),
                     STATUS_USAGE);
    assert_non_null(strstr(error.text, "3 tests"));
    assert_int_equal(weighing_find(&log[0], &log[1], &s.params, (struct weight){2.0 * WEIGHT_KG, 0.0}, &s.friction, &found, &error),
                     STATUS_USAGE);
    /* a test that was stopped early in the second log does not count as common to both */
    with.test[0].samples /= 2, with.test[1].samples /= 2, with.test[2].samples /= 2;
    assert_int_equal(weighing_find(&log[0], &log[1], &s.params, (struct weight){WEIGHT_KG, 0.0}, &s.friction, &found, &error),
                     STATUS_USAGE);
    assert_non_null(strstr(error.text, "3 tests"));
}

/* 20 kPa of pressure that remained in one chamber are no drift of zeros within 1 kPa, and a weight
 * of 1 kg is less than what that drift hides. */
static void rests_under_pressure_and_weights_too_light_are_refused(void **unused) {
    (void)unused;
    static struct weighing without, with;
    struct weighing_found found;
    struct error error;
    struct scale s;
    scale_init(&s);
    record(&s, &without, 290.0, false, TESTS), record(&s, &with, 290.0, true, TESTS);
    const struct weighing_log log[] = {{&without, &s.rest[0]}, {&with, &s.rest[1]}};
    s.params.model.tolerance.pressure_drift_pa = 1e3;
    assert_int_equal(weighing_find(&log[0], &log[1], &s.params, (struct weight){1.0, 0.0}, &s.friction, &found, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "more weight"));
    s.drift_pa[1][4] = 20e3;
    rest_before(&s, 10.0);
    assert_int_equal(weighing_find(&log[0], &log[1], &s.params, (struct weight){WEIGHT_KG, 0.0}, &s.friction, &found, &error),
                     STATUS_USAGE);
    assert_non_null(strstr(error.text, "P2 of leg 5"));
}

/* Samples with a flag, and readings that are no numbers, do not count; a test that begins again
 * replaces the first. */
static void a_repeated_test_replaces_the_first(void **unused) {
    (void)unused;
    static struct weighing w;
    struct scale s;
    uint64_t seed = 1;
    scale_init(&s);
    record(&s, &w, 290.0, false, 1);
    struct cycle c = carrying(&s, 290.0, 0, false, 0, &seed), flagged = c, none = c;
    flagged.in.flags = SAMPLE_STALE, none.in.p1_pa[3] = (double)NAN;
    weighing_take(&w, &flagged), weighing_take(&w, &none);
    assert_int_equal(w.test[0].samples, CYCLES);
    struct cycle settling = c;
    settling.phase = PHASE_SETTLE;
    weighing_take(&w, &settling), weighing_take(&w, &c);
    assert_int_equal(w.tests, 1);
    assert_int_equal(w.test[0].samples, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_weight_reads_its_mass_whatever_zeros_and_friction_are),
                                       cmocka_unit_test(its_error_is_that_of_the_gains_by_their_shares),
                                       cmocka_unit_test(the_tests_scatter_gives_the_deviation),
                                       cmocka_unit_test(a_zero_of_a_length_is_in_the_deviation),
                                       cmocka_unit_test(zeros_that_drift_are_taken_off_as_far_as_rests_show_them),
                                       cmocka_unit_test(dry_friction_of_legs_that_extend_for_longer_is_taken_off),
                                       cmocka_unit_test(logs_in_the_wrong_order_and_few_tests_are_refused),
                                       cmocka_unit_test(rests_under_pressure_and_weights_too_light_are_refused),
                                       cmocka_unit_test(a_repeated_test_replaces_the_first)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
