#include "gap_html.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "gap_pictures.h"
#include "gap_sections.h"
#include "gap_tables.h"
#include "html.h"
#include "hypothesis.h"
#include "page.h"

/* --- first screen */

enum { LONG_HEADLINE = 62 };

static const char *const kickers[GAP_VERDICTS] = {
    [GAP_EFFECT_NAMED] = "Missing in the model",
    [GAP_NO_GAP] = "Nothing is missing in the model",
    [GAP_AMBIGUOUS] = "Missing in the model, and these data cannot tell which",
    [GAP_UNKNOWN_EFFECT] = "Something is missing in the model",
    [GAP_PARTLY_NAMED] = "Missing in the model, beside something that no law makes",
};

/* Number of found effects that are already in the configuration, but with another size: none, some
 * or all. If the result is ambiguous, SOME_GIVEN is used even for all. */
enum given { NONE_GIVEN, SOME_GIVEN, ALL_GIVEN };

static enum given given(const struct gap_result *r) {
    int there = 0;
    for (int i = 0; i < r->effects; i++) there += r->effect[i].given.on;
    return !there ? NONE_GIVEN : there < r->effects || r->ambiguous ? SOME_GIVEN : ALL_GIVEN;
}

static const char *joint(const struct gap_result *r, int place) {
    return !place ? "" : place < r->effects - 1 ? ", " : r->ambiguous ? ", and " : " and ";
}

static void effects_words(FILE *out, const struct gap_result *r) {
    for (int i = 0; i < r->effects; i++) {
        bool doubted = r->ambiguous && i == r->in_doubt;
        fprintf(out, "%s%s", joint(r, i), doubted && r->effects > 1 ? "either " : "");
        section_effect_words(out, r->effect[i].effect, r->effect[i].pattern, params_legs(&r->model));
        for (int j = 0; doubted && j < r->ambiguous; j++) {
            fputs(j && r->ambiguous_together ? " and " : ", or ", out);
            section_effect_words(out, r->ambiguous_with[j], PATTERN_ALL, params_legs(&r->model));
        }
    }
}

/* Writes the verdict's statements in words, for a verdict that names a family of effects. */
static void statements_words(FILE *out, const struct gap_result *r) {
    for (int i = 0; i < r->effects; i++) {
        fputs(joint(r, i), out);
        if (r->statement[i].family) fprintf(out, "%s, whose law is none of those known", effect_families[r->statement[i].which].words);
        else section_effect_words(out, r->effect[i].effect, r->effect[i].pattern, params_legs(&r->model));
    }
}

static void headline_words(FILE *out, const struct gap_result *r) {
    if (r->verdict == GAP_NO_GAP) fputs("what is left between model and measurement is noise", out);
    else if (r->verdict == GAP_UNKNOWN_EFFECT) fputs("an effect that these data do not name", out);
    else if (r->verdict == GAP_PARTLY_NAMED && gap_family_name(r)[0]) statements_words(out, r);
    else effects_words(out, r);
}

static void headline(FILE *out, const struct gap_result *r) {
    char *words = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&words, &size);
    if (!stream) return;
    static const char *const sizes[] = {NULL, "Missing in the model, or of another size than there", "Of another size than in the model"};
    const char *kicker = r->verdict == GAP_EFFECT_NAMED && given(r) ? sizes[given(r)] : kickers[r->verdict];
    if (r->verdict == GAP_PARTLY_NAMED && !r->statements && r->certainty.probability < GAP_SURE)
        kicker = "Missing in the model, but another set of effects explains as much";
    if (r->verdict == GAP_AMBIGUOUS && given(r)) kicker = "Missing in the model, or of another size, and these data cannot tell which";
    headline_words(stream, r);
    if (!fclose(stream))
        fprintf(out, "<p class=\"kicker\">%s</p>\n<h1%s>%c%s</h1>\n", kicker, size > LONG_HEADLINE ? " class=\"long\"" : "",
                toupper((unsigned char)words[0]), words + 1);
    free(words);
}

static void effect_card(FILE *out, const struct gap_effect *e) {
    const struct effect *effect = effect_table[e->effect];
    html_print(out, "<p><code>%s</code></p>\n", effect->name);
    table_parameters(out, e);
    html_print(out, "<p class=\"small\">%s</p>\n", effect->law);
}

static void place_line(FILE *out, const struct gap_place *w, int legs) {
    char words[GAP_WORDS];
    html_print(out, "<li>%s, %s: %.1f %%</li>\n", gap_place_words(w, legs, words), section_feature_words(w->feature), 100.0 * w->share);
}

static void missing_card(FILE *out, const struct gap_result *r) {
    static const char *const titles[] = {"What is missing", "What is missing or of another size", "What is of another size"};
    fprintf(out, "<div><h2>%s</h2>\n", titles[given(r)]);
    for (int i = 0; i < r->effects; i++) {
        effect_card(out, &r->effect[i]);
        for (int j = 0; j < r->ambiguous && i == r->in_doubt; j++)
            html_print(out, "<p>%s <code>%s</code></p>\n", j && r->ambiguous_together ? "and" : "or",
                       effect_table[r->ambiguous_with[j]]->name);
    }
    if (r->verdict == GAP_NO_GAP)
        fprintf(out,
                "<p>Nothing that can be told from noise. All %d effects of the catalogue were tried beside the model's own "
                "parameters; none explains what noise does not.</p>\n",
                r->candidates);
    if (r->verdict == GAP_UNKNOWN_EFFECT) {
        fputs(
            "<p>A difference that repeats every cycle, and that no effect of the catalogue explains for certain. It lives here:</p>\n<ol>",
            out);
        for (int i = 0; i < r->places && i < 4; i++) place_line(out, &r->where[i], params_legs(&r->model));
        fputs("</ol>\n", out);
    }
    fputs("</div>\n", out);
}

/* Returns the best candidate for which section_named() is false; NULL if there is none. */
static const struct gap_candidate *runner_up(const struct gap_result *r) {
    for (int i = 0; i < r->candidates; i++)
        if (!section_named(r, r->candidate[i].effect)) return &r->candidate[i];
    return NULL;
}

static void evidence(FILE *out, const struct gap_effect *e, bool first, bool strict) {
    if (first)
        html_print(out,
                   "<p>Explains <b>%.1f&nbsp;%%</b> of the squared gap on cycles it was not fitted to; strength of evidence "
                   "<b>z&nbsp;=&nbsp;%.0f</b>, comparable to standard deviations%s.</p>\n<p class=\"small\">%s</p>\n",
                   100.0 * e->share_explained, e->z, strict ? ": below 6 nothing is named" : "", e->evidence);
    else html_print(out, "<p><code>%s</code>: z&nbsp;=&nbsp;%.0f on what was left after that.</p>\n", effect_table[e->effect]->name, e->z);
}

static void certainty_line(FILE *out, const struct gap_result *r) {
    const struct gap_certainty *c = &r->certainty;
    char words[GAP_WORDS];
    fprintf(out, "<p>Its probability among the sets of effects that were compared: <b>%s</b>.",
            gap_probability_words(c->probability, words));
    if (c->probability < GAP_SURE) {
        fputs(c->others ? " Likelier, or nearly as likely:" : " That of no effect", out);
        for (int i = 0; i < c->others; i++) {
            fputs(i ? " and " : " ", out);
            section_effect_words(out, c->other[i], PATTERN_ALL, params_legs(&r->model));
        }
        fprintf(out, ", %s.", gap_probability_words(c->other_probability, words));
    }
    fputs("</p>\n", out);
}

static void sure_card(FILE *out, const struct gap_result *r) {
    const struct gap_candidate *next = runner_up(r);
    html_print(out, "<div><h2>How sure</h2>\n<p>Verdict <code>%s</code>: %s.</p>\n", gap_verdict_names[r->verdict], r->reason);
    for (int i = 0; i < r->effects; i++) evidence(out, &r->effect[i], i == 0, r->verdict != GAP_PARTLY_NAMED);
    if (!r->effects)
        fprintf(
            out,
            "<p>What is left on held-out data, squared and divided by the variance of its noise: <b>%.2f</b> on average; noise alone stays "
            "near or below 1.</p>\n",
            r->white_after);
    if (isfinite(r->certainty.probability)) certainty_line(out, r);
    if (next) {
        fputs(r->effects ? "<p>Runner-up: " : "<p>Closest effect: ", out);
        section_effect_words(out, next->effect, next->pattern, params_legs(&r->model));
        html_print(out, " (<code>%s</code>): %.1f&nbsp;%%, z&nbsp;=&nbsp;%.0f", effect_table[next->effect]->name,
                   100.0 * fmax(next->share_explained, 0.0), next->z);
        if (r->effects) fprintf(out, "; that falls short by <b>z&nbsp;=&nbsp;%.0f</b>", gap_short(r, next));
        fputs(".</p>\n", out);
    }
    fputs("</div>\n", out);
}

static void size_bar(FILE *out, const char *name, double size, double full, const char *colour) {
    if (!isfinite(size)) return;
    fprintf(out, "<span>%s</span><i style=\"width:%.1f%%;background:%s\"></i><span>%.2f %%</span>\n", name,
            full > 0.0 ? 100.0 * size / full : 0.0, colour, 100.0 * size);
}

static void size_group(FILE *out, const char *name, const struct gap_result *r, double before, double after, double full) {
    html_print(out, "<div class=\"sizes\"><b>%s</b>\n", name);
    size_bar(out, r->effects ? "before" : "model", before, full, "#8a8a8a");
    if (r->effects) size_bar(out, "after", after, full, "var(--accent)");
    size_bar(out, "noise floor", r->noise_floor.overall, full, "#d4d4d4");
    fputs("</div>\n", out);
}

static void shrink_card(FILE *out, const struct gap_report *report) {
    const struct gap_result *r = report->result;
    double full = fmax(fmax(r->before.overall, r->held_out_before.overall), r->noise_floor.overall);
    fprintf(out, "<div><h2>%s</h2>\n", r->effects ? "How much of the gap is gone" : "How large the gap is");
    if (r->effects && isfinite(r->unexplained_fraction))
        fprintf(out, "<p class=\"big\">%.0f %%</p><p class=\"small\">of the squared gap above the noise floor, on data held out</p>\n",
                100.0 * (1.0 - r->unexplained_fraction));
    else
        fprintf(out, "<p class=\"big\">%.2f ×</p><p class=\"small\">the noise floor, on data held out; nothing was added</p>\n",
                r->held_out_before.overall / r->noise_floor.overall);
    size_group(out, report->validate_file ? "data held out: the other log" : "data held out: every other cycle or piece", r,
               r->held_out_before.overall, r->held_out_after.overall, full);
    size_group(out, "data used: the others", r, r->before.overall, r->after.overall, full);
    fputs("<p class=\"small\">rms difference, % of the measured variation, over all channels</p></div>\n", out);
}

static void notices(FILE *out, const struct gap_result *r) {
    if (r->controller_differs)
        fprintf(out,
                "<p class=\"notice\"><b>Another controller.</b> %.0f %% of the recorded commands' variation is not what the "
                "configured controller gives for the recorded lengths and pressures. No effect of the machine explains that: set "
                "<code>control</code> in the configuration to the rig's. The figures here are of the equations under the measured "
                "motion, which need no controller.</p>\n",
                100.0 * r->controller_difference);
    else if (r->sampled_s > 0.0)
        fprintf(out,
                "<p class=\"notice\"><b>Another rate.</b> The log has a sample each %.3g&nbsp;ms, the controller's cycle "
                "(<code>loop.period_s</code>) is %.3g&nbsp;ms: what it commanded between is not known, nor is whether it is the "
                "configured one.</p>\n",
                1e3 * r->sampled_s, 1e3 * r->model.loop.period_s);
    else if (!r->controller_known)
        fputs("<p class=\"notice\">The log has no reference of a steady test: whether its commands are the configured controller's is not "
              "evaluated.</p>\n",
              out);
}

static void next_steps(FILE *out, const struct gap_report *report) {
    const struct gap_result *r = report->result;
    if (r->next_experiment[0]) {
        fputs("<p class=\"next\"><b>Next experiment:</b> ", out);
        html_commands(out, r->next_experiment);
        fputs(".</p>\n", out);
    }
    if (!r->effects) return;
    bool driven = !params_mechanism(&r->model)->refuses.run;
    fputs("<p class=\"next\"><b>Use it:</b> <code>", out);
    html_print(out, driven ? "hexid run -c %s" : "hexid gap -c %s --measured ...", report->model_file);
    fprintf(out, "</code>, the configuration given with %s effect%s%s.</p>\n", r->effects > 1 ? "these" : "this", r->effects > 1 ? "s" : "",
            r->ambiguous ? " (the first of those that cannot be told apart)" : "");
}

static void first_screen(FILE *out, const struct gap_report *report) {
    const struct gap_result *r = report->result;
    for (int i = 0; i < report->measured->runs; i++) html_print(out, "%s%s", i ? " and " : "", report->measured_file[i]);
    html_print(out, "</code> against <code>%s</code></span><span>", report->config_file);
    int tests = 0, segments = 0;
    for (int i = 0; i < report->measured->tests; i++)
        if (report->measured->test[i].segment_s > 0.0) segments++;
        else tests++;
    if (tests) fprintf(out, "%d test%s, ", tests, tests == 1 ? "" : "s");
    if (segments) fprintf(out, "%d piece%s of any motion, ", segments, segments == 1 ? "" : "s");
    fprintf(out, "%s</span></header>\n", r->simulated ? "simulated in closed loop" : "equations under the measured motion");
    headline(out, r);
    notices(out, r);
    fputs("<div class=\"cards\">\n", out);
    missing_card(out, r);
    sure_card(out, r);
    shrink_card(out, report);
    fputs("</div>\n", out);
    next_steps(out, report);
    fputs("<p class=\"small\">± is a 95 % interval: 1.96 standard deviations to either side.</p>\n", out);
}

/* --- page */

static void write_page(struct page *p, const void *subject) {
    const struct gap_report *report = subject;
    page_begin(p, "gap", report->result->reason);
    first_screen(p->out, report);
    table_legs(p->out, report->result);
    section_map(p->out, report);
    section_waveforms(p, report);
    section_loops(p, report);
    table_statements(p->out, report->result);
    table_hypotheses(p->out, report->result);
    table_numbers(p->out, report);
    table_base(p->out, report->result);
    table_matrix(p->out, report->result);
}

int gap_html(const struct gap_report *report, char **page, struct error *error) { return page_make(write_page, report, page, error); }
