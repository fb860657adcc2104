/* The gap report: a complete page that escapes foreign text and explains each verdict; gnuplot
 * figures; the LCM message. */
#include "support.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>

#include "gap_html.h"
#include "gap_messages.h"
#include "gap_rig.h"
#include "gap_text.h"
#include "hexid_gap_2_t.h"
#include "html.h"
#include "hypothesis.h"
#include "plot.h"
#include "replay.h"
#include "residual.h"
#include "units.h"

static struct params params;
static struct recording measured;      /* record of the model itself in three tests */
static struct gap_result named;        /* result: Coulomb friction of leg 4, and passive joint
                                        * friction of each leg */
static struct waves closed_loop, motion;

static void size_of(struct gap_size *s, double size) {
    s->overall = size;
    for (int ch = 0; ch < GAP_CHANNELS; ch++) s->channel[ch] = size * (ch + 1), s->normalised[ch] = size / (ch + 1);
}

static void fill_effect(struct gap_effect *e, const char *name, int pattern) {
    *e = (struct gap_effect){
        .effect = effect_find(name), .pattern = pattern, .share_explained = 0.93, .z = 17.0, .evidence = "jump at <reversal>"};
    assert_true(e->effect >= 0);
    while (e->keys < EFFECT_KEYS && effect_table[e->effect]->keys[e->keys].name) e->keys++;
    for (int key = 0; key < EFFECT_KEYS; key++)
        for (int leg = 0; leg < LEGS; leg++) e->values.value[key][leg] = 50.0 + 10.0 * key + leg, e->std[key][leg] = 1.5;
}

static void fill_result(struct gap_result *r) {
    *r = (struct gap_result){.verdict = GAP_EFFECT_NAMED,
                             .reason = "the model lacks two effects",
                             .effects = 2,
                             .places = 3,
                             .simulated = true,
                             .controller_known = true,
                             .unexplained_fraction = 0.03,
                             .white_after = 1.02,
                             .base_values = 1,
                             .matrices = true,
                             .repaired = true,
                             .base_model = params,
                             .model = params,
                             .fitted = params};
    fill_effect(&r->effect[0], "cylinder_coulomb_friction", 3);
    fill_effect(&r->effect[1], "passive_joint_friction", PATTERN_EACH);
    for (int i = 0; effect_table[i] && i < EFFECTS_MAX; i++)
        r->candidate[r->candidates++] = (struct gap_candidate){
            .effect = i, .pattern = PATTERN_ALL, .gain = 400.0 - 100.0 * i, .share_explained = 1.0 - 0.2 * i};
    for (int i = 0; i < r->places; i++)
        r->where[i] = (struct gap_place){
            .test = i, .leg = i, .harmonic = i, .dof = (enum dof)i, .channel = GAP_FORCE, .feature = "static", .share = 0.1};
    size_of(&r->before, 0.3), size_of(&r->after, 0.11), size_of(&r->noise_floor, 0.1);
    size_of(&r->held_out_before, 0.31), size_of(&r->held_out_after, 0.12);
    r->base[0] = (struct gap_base_value){"hydraulics.supply_pa", -1, 1e7, 1.01e7, 2e4, false};
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) {
            r->measured_mt[i][j] = 10.0 * i + j + 1.0;
            r->before_mt[i][j] = 9.0, r->after_mt[i][j] = 10.0, r->repaired_mt[i][j] = 11.0;
        }
}

static int setup(void **unused) {
    (void)unused;
    struct error error;
    config_default(&params);
    params.tests.duration_s = 2.0;
    if (gap_rig(&params, &params, 3, &measured, &error)) fail_msg("%s", error.text);
    fill_result(&named);
    struct replay runs[2];
    replay_both(&params, &params, &measured, runs);
    if (runs[0].status || runs[1].status) fail_msg("a run of the model failed");
    waves_closed_loop(&closed_loop, &measured, &runs[0].run, &runs[1].run);
    replay_free(runs);
    if (waves_motion(&motion, &named, &measured, &error)) fail_msg("%s", error.text);
    return 0;
}

static int teardown(void **unused) {
    (void)unused;
    waves_free(&closed_loop);
    waves_free(&motion);
    recording_free(&measured);
    return 0;
}

/* --- waves */

static void a_rig_that_is_the_model_shows_no_difference(void **unused) {
    (void)unused;
    assert_int_equal(closed_loop.tests, 3);
    for (int i = 0; i < closed_loop.tests; i++)
        for (int ch = 0; ch < GAP_CHANNELS; ch++)
            for (int leg = 0; leg < LEGS; leg++) {
                const struct wave *w = &closed_loop.test[i].wave[ch][leg];
                assert_true(closed_loop.evaluated[ch] && w->noise > 0.0 && closed_loop.variation[ch] > 0.0);
                /* simulations with the same seed give the same bits */
                assert_true(waves_distance(&closed_loop.test[i], w->measured, w->before) == 0.0);
                assert_true(waves_distance(&closed_loop.test[i], w->measured, w->after) == 0.0);
            }
}

static void motion_leaves_over_what_the_equations_do(void **unused) {
    (void)unused;
    struct residual_data d;
    struct error error;
    residual_row row;
    assert_int_equal(residual_prepare(&d, &measured, CYCLES_ALL, &error), STATUS_OK);
    assert_true(residual_evaluate(&d.test[1], &params, EQUATIONS_ALL, ALL_LEGS, row));
    for (int leg = 0; leg < LEGS; leg++) {
        const struct wave *w = &motion.test[1].wave[GAP_FORCE][leg];
        for (int i = 0; i < RESIDUAL_SIZE; i++)            /* tolerance: rounding of about 1000 N */
            assert_close(w->measured[i] - w->before[i], row[leg][RESIDUAL_FORCE][i], 1e-9);
    }
    assert_false(motion.evaluated[GAP_LENGTH] || motion.evaluated[GAP_VALVE]);
    residual_free(&d);
}

static void a_distance_is_the_rms_over_a_cycle(void **unused) {
    (void)unused;
    /* differences: constant 2, sine 4, cosine 2 */
    double a[SPECTRUM_SIZE] = {3.0, [5] = 4.0}, b[SPECTRUM_SIZE] = {1.0, [6] = -2.0};
    const struct wave_test t = {.omega = 25.0, .from_s = 0.3, .span_s = 2.0 * PI / 25.0};
    assert_close(waves_distance(&t, a, b), sqrt(4.0 + 8.0 + 2.0), 1e-12);
}

/* --- page */

static char *page_of(const struct gap_result *result, const struct waves *waves, const char *file, int expected) {
    struct gap_report report = {.result = result,
                                .measured = &measured,
                                .waves = waves,
                                .motion = &motion,
                                .measured_file = &file,
                                .validate_file = file,
                                .config_file = file,
                                .model_file = file};
    struct error error;
    char *page;
    assert_int_equal(gap_html(&report, &page, &error), expected);
    assert_non_null(page);
    return page;
}

static void assert_says(const char *page, const char *words) {
    if (!strstr(page, words)) fail_msg("the page does not say \"%s\"", words);
}

static bool is_void(const char *name) {
    return !strcmp(name, "img") || !strcmp(name, "meta") || !strcmp(name, "br") || !strcmp(name, "!DOCTYPE");
}

/* Asserts that every tag is closed, in order, that no '<' or '>' stands in text or attributes, and
 * that every attribute's value is quoted. */
static void assert_well_formed(const char *page) {
    char open[64][16];
    int depth = 0;
    for (const char *c = page; *c; c++) {
        char name[16];
        if (*c == '>') fail_msg("a stray '>' near: %.60s", c - 20);
        if (*c != '<') continue;
        bool end = c[1] == '/';
        size_t length = strcspn(c + 1 + end, " >/");
        assert_true(length > 0 && length < sizeof name);
        memcpy(name, c + 1 + end, length);
        name[length] = '\0';
        const char *start = c;
        for (c++; *c && *c != '>'; c++) {
            if (*c == '<') fail_msg("a '<' within a tag: %.60s", start);
            if (*c == '"') c = strchr(c + 1, '"');
            assert_non_null(c);
        }
        assert_true(*c == '>');
        if (end) {
            if (!depth || strcmp(open[--depth], name)) fail_msg("</%s> closes <%s>", name, open[depth]);
        } else if (!is_void(name)) {
            assert_true(depth < 64);
            memcpy(open[depth++], name, sizeof name);
        }
    }
    assert_int_equal(depth, 0);
}

static void assert_no_bad_number(const char *page) {
    for (const char *c = page; (c = strstr(c, "nan")); c++)
        if (!isalpha((unsigned char)c[-1]) && !isalpha((unsigned char)c[3])) fail_msg("not a number in the page: %.40s", c - 20);
    for (const char *c = page; (c = strstr(c, "inf")); c++)
        if (!isalpha((unsigned char)c[-1]) && !isalpha((unsigned char)c[3])) fail_msg("an infinite number in the page: %.40s", c - 20);
}

static int count(const char *page, const char *what) {
    int n = 0;
    for (const char *c = page; (c = strstr(c, what)); c++) n++;
    return n;
}

static void the_page_names_effects_numbers_and_pictures(void **unused) {
    (void)unused;
    char *page = page_of(&named, &closed_loop, "run.lcm", STATUS_OK);
    assert_well_formed(page);
    assert_no_bad_number(page);
    assert_says(page, "Missing in the model");
    assert_says(page, "<h1 class=\"long\">Dry (Coulomb) friction in the cylinders (leg 4 only) and friction in the universal joints "
                      "(each leg its own)</h1>");
    assert_says(page, "53.0 ± 6.0 N");      /* leg 4 of force_extend_n: a deviation of 1.5 N, and 5
                                             * % for the law's error */
    assert_says(page, "55 ± 16");        /* leg 6 of coulomb_nm */
    assert_int_equal(count(page, "± is a 95 % interval"), 1);
    assert_says(page, "97 %");              /* share of the gap that is explained */
    assert_says(page, "<code>hydraulics.supply_pa</code>");
    assert_says(page, "<th>mx</th><td>kg</td><td class=\"n\">1.000</td><td class=\"n\">9.000</td><td class=\"n\">+800.00 %</td>");
    assert_says(page, "friction taken off");
    assert_int_equal(count(page, "<img "), 9); /* pictures of six waveforms and three loops */
    assert_int_equal(count(page, "<table class=\"map\">"), 1);
    assert_int_equal(count(page, "<script"), 0);
    assert_int_equal(count(page, "http"), 0);
    free(page);
}

/* A verdict is in part because something is left, or because other effects explain as much. */
static void the_page_says_why_it_names_only_a_part(void **unused) {
    (void)unused;
    slow_case();
    struct gap_result r = named;
    r.verdict = GAP_PARTLY_NAMED;
    for (int sure = 0; sure < 2; sure++) {
        r.certainty.probability = sure ? 0.99 : 0.6;
        char *page = page_of(&r, &closed_loop, "run.lcm", STATUS_OK);
        assert_says(page, sure ? "beside something that no law makes" : "but another set of effects explains as much");
        free(page);
    }
}

static void names_of_files_are_text(void **unused) {
    (void)unused;
    slow_case();
    const char evil[] = "a\"><script>alert('x')</script>&amp;\x01.lcm";
    struct gap_result r = named;
    snprintf(r.reason, sizeof r.reason, "</title><script>");
    snprintf(r.next_experiment, sizeof r.next_experiment, "<b onclick=\"x\">");
    snprintf(r.effect[0].evidence, sizeof r.effect[0].evidence, "1 < 2 & 3 > 2");
    char *page = page_of(&r, &closed_loop, evil, STATUS_OK);
    assert_well_formed(page);
    assert_int_equal(count(page, "<script"), 0);
    assert_int_equal(count(page, "onclick=\""), 0);
    assert_says(page, "a&quot;&gt;&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&amp;amp; .lcm");
    assert_says(page, "1 &lt; 2 &amp; 3 &gt; 2");
    free(page);
}

static void every_verdict_has_its_first_screen(void **unused) {
    (void)unused;
    slow_case();
    struct gap_result r = named;
    char *page;

    r.ambiguous = 1, r.ambiguous_with[0] = effect_find("cylinder_stribeck_friction"), r.effects = 1, r.verdict = GAP_AMBIGUOUS;
    snprintf(r.next_experiment, sizeof r.next_experiment, "repeat z at 0.2 Hz");
    page = page_of(&r, &closed_loop, "run.lcm", STATUS_OK);
    assert_well_formed(page);
    assert_says(page, "these data cannot tell which");
    assert_says(page, "or <code>cylinder_stribeck_friction</code>");
    assert_says(page, "<b>Next experiment:</b> repeat z at 0.2 Hz.");
    free(page);

    r.effects = 2; /* the most certain effect is ambiguous, the other is not */
    page = page_of(&r, &closed_loop, "run.lcm", STATUS_OK);
    assert_says(page, "ither dry (Coulomb) friction in the cylinders (leg 4 only), or ");
    assert_says(page, ", and friction in the universal joints");
    free(page);

    r.ambiguous = r.effects = 0, r.verdict = GAP_UNKNOWN_EFFECT;
    snprintf(r.reason, sizeof r.reason, "a remark of the verdict");
    page = page_of(&r, &closed_loop, "run.lcm", STATUS_OK);
    assert_well_formed(page);
    assert_says(page, "An effect that these data do not name");
    assert_says(page, "force of leg 3, harmonic 2");
    assert_says(page, "<code>unknown_effect</code>: a remark of the verdict.</p>");
    assert_int_equal(count(page, "Use it"), 0);
    free(page);

    r.verdict = GAP_NO_GAP, r.next_experiment[0] = '\0', r.places = 0;
    page = page_of(&r, &closed_loop, "run.lcm", STATUS_OK);
    assert_well_formed(page);
    assert_no_bad_number(page);
    assert_says(page, "What is left between model and measurement is noise");
    assert_int_equal(count(page, "Next experiment"), 0);
    free(page);
}

static void what_ranks_above_the_named_one_says_why(void **unused) {
    (void)unused;
    slow_case();
    static const char *const first[] = {"cylinder_stribeck_friction", "command_delay", "base_tilt", "cylinder_coulomb_friction"};
    struct gap_result r = named;
    r.effects = 1, r.candidates = 4;
    for (int i = 0; i < r.candidates; i++)
        r.candidate[i] = (struct gap_candidate){
            .effect = effect_find(first[i]), .pattern = PATTERN_ALL, .gain = 400.0 - i, .unseen = i == 1};
    assert_true(hypothesis_contains(r.candidate[0].effect, r.effect[0].effect));
    char *page = page_of(&r, &closed_loop, "run.lcm", STATUS_OK);
    assert_well_formed(page);
    assert_int_equal(count(page, "the simpler one is named</td>"), 1);
    assert_int_equal(count(page, "these data do not show it</td>"), 1);
    assert_int_equal(count(page, "<td>not named: beside the named one it explains nothing worth naming</td>"), 1);
    assert_int_equal(count(page, "<tr class=\"found\"><td class=\"n\">4</td>"), 1);
    free(page);

    /* the named effect is also the best single one */
    r.candidate[0].effect = effect_find("cylinder_coulomb_friction");
    r.candidate[3].effect = effect_find("cylinder_stribeck_friction");
    page = page_of(&r, &closed_loop, "run.lcm", STATUS_OK);
    assert_int_equal(count(page, "<td>not named"), 0);
    assert_int_equal(count(page, "<td>contains the named one as a limiting case</td>"), 1);
    free(page);
}

static void what_was_not_evaluated_is_said(void **unused) {
    (void)unused;
    slow_case();
    struct gap_result r = named;
    r.simulated = r.matrices = false, r.controller_differs = true, r.controller_difference = 0.4;
    struct gap_size *sizes[] = {&r.before, &r.after, &r.noise_floor, &r.held_out_before, &r.held_out_after};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) sizes[i]->channel[GAP_LENGTH] = sizes[i]->normalised[GAP_LENGTH] = NAN;
    char *page = page_of(&r, &motion, "run.lcm", STATUS_OK);
    assert_well_formed(page);
    assert_no_bad_number(page);
    assert_says(page, "<b>Another controller.</b> 40 %");
    assert_says(page, "not evaluated");
    assert_int_equal(count(page, "id=\"matrix\""), 0);
    assert_int_equal(count(page, "<img "), 8); /* no valve loop */
    free(page);
}

static void without_gnuplot_the_page_is_whole_but_for_pictures(void **unused) {
    (void)unused;
    char *path = strdup(getenv("PATH"));
    setenv("PATH", "/nowhere", 1);
    char *page = page_of(&named, &closed_loop, "run.lcm", STATUS_IO);
    setenv("PATH", path, 1);
    free(path);
    assert_well_formed(page);
    assert_int_equal(count(page, "<img "), 0);
    assert_int_equal(count(page, "picture not drawn"), 9);
    assert_says(page, "apt-get install gnuplot-nox");
    assert_says(page, "53.0 ± 6.0 N");
    free(page);
}

/* --- segments */

static void gnuplot_draws_or_says_why_not(void **unused) {
    (void)unused;
    const char good[] = "set terminal svg\nplot sin(x)\n", bad[] = "set terminal svg\nplot 'no such file'\n";
    struct error error;
    size_t size;
    char *svg;
    assert_int_equal(plot_draw(good, strlen(good), &svg, &size, &error), STATUS_OK);
    assert_true(size == strlen(svg) && strstr(svg, "<svg") && strstr(svg, "</svg>"));
    free(svg);
    assert_int_equal(plot_draw(bad, strlen(bad), &svg, &size, &error), STATUS_IO);
    assert_null(svg);
    assert_non_null(strstr(error.text, "no such file"));
}

static void assert_quantity(double value, double std, const char *unit, const char *expected) {
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    html_quantity(out, value, std, unit);
    fclose(out);
    assert_string_equal(text, expected);
    free(text);
}

static void quantities_have_two_digits_of_uncertainty(void **unused) {
    (void)unused;
    assert_quantity(48.956, 1.342, "N", "49.0 ± 1.3 N");
    assert_quantity(1523.4, 123.0, "N", "1523 ± 123 N");
    assert_quantity(9.58337e8, 3.5e6, "Pa", "(958.3 ± 3.5)·10<sup>6</sup> Pa");
    assert_quantity(-3.1e-11, 0.0, "-", "-31·10<sup>-12</sup>");
    assert_quantity(0.0, 0.25, "m<", "0.00 ± 0.25 m&lt;");
    assert_quantity(2.5, NAN, "s", "2.5 s");
    assert_quantity(NAN, 1.0, "s", "not known");
}

static void the_summary_fits_a_terminal(void **unused) {
    (void)unused;
    struct gap_result r = named;
    char *text;
    size_t size;
    r.ambiguous = 2;
    r.ambiguous_with[0] = effect_find("payload_rotational_inertia"), r.ambiguous_with[1] = effect_find("external_stiffness");
    memset(r.reason, 'x', sizeof r.reason - 1);
    for (size_t i = 7; i < sizeof r.reason - 1; i += 8) r.reason[i] = ' ';
    memcpy(r.next_experiment, r.reason, sizeof r.reason);
    for (int leg = 0; leg < LEGS; leg++) r.effect[1].values.value[0][leg] = -1.23456e-5, r.effect[1].std[0][leg] = 1.2e-11;
    /* a value without a deviation is printed alone */
    r.effect[0].bound[1][3] = true, r.effect[0].std[1][3] = r.effect[0].values.value[1][3] = 0.0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    gap_text_print(out, &r);
    fclose(out);
    int words = 0;
    assert_non_null(strstr(text, "force_retract_n          0 (at bound) N\n"));
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
        if (strlen(line) > 80) fail_msg("%zu columns: %s", strlen(line), line);
        words += count(line, "xxxxxxx");
    }
    assert_int_equal(words, 2 * (GAP_TEXT / 8)); /* no word is lost at a line break */
    free(text);
}

static void the_message_keeps_every_number(void **unused) {
    (void)unused;
    static unsigned char buffer[16384];
    hexid_gap_2_t m;
    struct gap_result r = named;
    r.ambiguous = 1, r.ambiguous_with[0] = effect_find("external_stiffness");
    r.statements = 1, r.certainty.probability = 0.97;
    r.statement[0] = (struct gap_statement){.family = true, .which = EFFECT_LOAD, .probability = 0.98, .share_explained = 0.9};
    int size = gap_encode(&r, 99, buffer, sizeof buffer);
    assert_int_equal(hexid_gap_2_t_decode(buffer, 0, size, &m), size);
    assert_true(m.time_ns == 99 && m.effect_count == 2 && m.ambiguous_count == 1 && m.simulated == 1);
    assert_string_equal(m.verdict, "effect_named");
    assert_string_equal(m.effects[0], "cylinder_coulomb_friction");
    assert_string_equal(m.ambiguous_with[0], "external_stiffness");
    assert_int_equal(m.parameter_count, 2 + 2 * LEGS); /* one leg of the first effect has two
                                                        * values, six legs of the second have two
                                                        * each */
    assert_string_equal(m.parameters[1], "cylinder_coulomb_friction.force_retract_n");
    assert_string_equal(m.parameter_units[1], "N");
    assert_true(m.parameter_legs[1] == 4 && m.values_si[1] == 63.0 && m.values_std_si[1] == hypot(1.5, 0.05 * 63.0));
    assert_true(m.parameter_legs[7] == 6 && m.values_si[7] == 55.0);
    assert_true(m.share_explained[0] == 0.93 && m.z[1] == 17.0 && m.unexplained_fraction == 0.03);
    assert_true(m.before_ratio == 0.3 && m.after_ratio == 0.11 && m.noise_floor_ratio == 0.1 && m.held_out_before_ratio == 0.31 &&
                m.held_out_after_ratio == 0.12);
    assert_true(m.held_out_before_length_m == 0.31 * 1 && m.held_out_before_force_n == 0.31 * 2 && m.held_out_before_p1_pa == 0.31 * 3 &&
                m.held_out_before_p2_pa == 0.31 * 4 && m.held_out_before_valve == 0.31 * 5);
    assert_true(m.held_out_after_length_m == 0.12 * 1 && m.held_out_after_force_n == 0.12 * 2 && m.held_out_after_p1_pa == 0.12 * 3 &&
                m.held_out_after_p2_pa == 0.12 * 4 && m.held_out_after_valve == 0.12 * 5);
    assert_true(m.noise_floor_length_m == 0.1 * 1 && m.noise_floor_force_n == 0.1 * 2 && m.noise_floor_p1_pa == 0.1 * 3 &&
                m.noise_floor_p2_pa == 0.1 * 4 && m.noise_floor_valve == 0.1 * 5);
    assert_true(m.statement_count == 1 && m.statement_probability[0] == 0.98 && m.statement_share[0] == 0.9 && m.certainty == 0.97);
    assert_string_equal(m.statements[0], "position_load");
    assert_string_equal(m.statement_levels[0], "family");
    assert_string_equal(m.family, "position_load");
    hexid_gap_2_t_decode_cleanup(&m);
    for (int capacity = 0; capacity < size; capacity++) assert_int_equal(gap_encode(&r, 99, buffer, capacity), -1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rig_that_is_the_model_shows_no_difference),
        cmocka_unit_test(motion_leaves_over_what_the_equations_do),
        cmocka_unit_test(a_distance_is_the_rms_over_a_cycle),
        cmocka_unit_test(the_page_names_effects_numbers_and_pictures),
        cmocka_unit_test(the_page_says_why_it_names_only_a_part),
        cmocka_unit_test(names_of_files_are_text),
        cmocka_unit_test(every_verdict_has_its_first_screen),
        cmocka_unit_test(what_ranks_above_the_named_one_says_why),
        cmocka_unit_test(what_was_not_evaluated_is_said),
        cmocka_unit_test(without_gnuplot_the_page_is_whole_but_for_pictures),
        cmocka_unit_test(gnuplot_draws_or_says_why_not),
        cmocka_unit_test(quantities_have_two_digits_of_uncertainty),
        cmocka_unit_test(the_summary_fits_a_terminal),
        cmocka_unit_test(the_message_keeps_every_number),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
