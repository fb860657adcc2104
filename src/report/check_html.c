#include <math.h>
#include <string.h>

#include "check_pictures.h"
#include "check_report.h"
#include "html.h"
#include "page.h"

/* Formats of a sentence. to_do is for a sentence that asks for action: here such a sentence has the
 * colour of a warning, on the terminal a "!". */
static const char fact[] = "<p>%s: %s</p>\n", to_do[] = "<p class=\"notice\">%s: %s</p>\n";

static void words(FILE *out, const char *style, const char *label, const char *text) {
    if (*text) html_print(out, style, label, text);
}

static void section_tests(FILE *out, const struct check_report *r) {
    fputs("<h2>Tests</h2>\n", out);
    html_table(out, "survey",
               "test|axis|>stated|>measured|>amplitude|>recorded|>rows|>rate|>jitter|>lost|>longest gap|>flagged|>without a number");
    for (const struct survey *s = r->survey; s < r->survey + r->surveys; s++)
        html_row(out, "<span>%s</span>|%s|>%.5g Hz|>%.6g Hz|>%.4g %s|>%.5g s|>%d|>%.6g Hz|>%.2g ms|>%.9g|>%.4g ms|>%d|>%d", s->name,
                 s->test.dof == DOF_NONE ? "none" : dof_names[s->test.dof], s->stated_hz, s->measured_hz, 1e3 * s->amplitude,
                 check_amplitude_unit(s), survey_seconds(s), s->test.count, 1.0 / s->sampling.step_s, check_jitter_ms(s),
                 (double)s->sampling.lost, 1e3 * s->sampling.gap_s, s->flagged, s->not_a_number);
    html_table_end(out);
    fputs("<p class=\"small\">Noise, below: one standard deviation of a sample of the worst channel.</p>\n", out);
}

/* Writes a table cell with the numbers of faulty legs, "1, 2, 5", or a dash. */
static void legs_cell(FILE *out, unsigned bits) {
    const char *before = "<td class=\"n\"><span class=\"notice\">";
    for (int i = 0; i < LEGS; i++)
        if (bits >> i & 1u) fprintf(out, "%s%d", before, i + 1), before = ", ";
    fputs(bits ? "</span></td>" : "<td class=\"n\">–</td>", out);
}

static void channel_row(FILE *out, const struct survey *s, enum survey_kind kind) {
    const struct survey_channel *c = &s->channel[kind];
    const char *unit = check_unit_of(s, kind);
    double scale = check_units[kind].scale, step = c->step > 0.0 ? scale * c->step : (double)NAN;
    fputs("<tr>", out);
    html_cells(out, "%s|>%d of %d|>%.6g %s|>%.6g %s|>%.3g %s|>%.3g %s", check_name_of(s, kind), __builtin_popcount(c->there), c->of,
               scale * c->low, unit, scale * c->high, unit, scale * c->noise, unit, step, unit);
    legs_cell(out, c->dead), legs_cell(out, c->clipped);
    fputs("</tr>\n", out);
}

static void section_test(struct page *p, const struct survey *s) {
    char ramp[CHECK_RAMP_SIZE];
    html_print(p->out, "<section class=\"panels\"><h2>%s</h2>\n", s->name);
    check_ramp(s, ramp);
    words(p->out, to_do, "ramp", ramp);
    page_figure(p, check_picture, s,
                "As measured, over the time of the test. Grey ground: at rest; blue: steady motion, found by the position "
                "alone. Where there are more samples than pixels, a curve is the band between their minimum and maximum.");
    html_table(p->out, "survey", "channel|>present|>minimum|>maximum|>noise, rms|>sensor step|>never changes|>clipped");
    for (int kind = 0; kind < SURVEY_KINDS; kind++)
        if (s->channel[kind].of) channel_row(p->out, s, (enum survey_kind)kind);
    html_table_end(p->out);
    fputs("</section>\n", p->out);
}

static void answer(FILE *out, const char *command, const struct error *e) {
    html_print(out, "%s would %s it%s", command, e->status ? "refuse" : "take", e->text[0] ? check_answer_joint(e) : ".");
    html_commands(out, e->text);
}

static void write_page(struct page *p, const void *subject) {
    const struct check_report *r = subject;
    FILE *out = p->out;
    char excluded[120];
    page_begin(p, "check", NULL);
    for (int i = 0; i < r->sources; i++) html_print(out, "%s%s", i ? " " : "", r->source[i]);
    fprintf(out, "</code></span><span>%d test%s</span></header>\n", r->surveys, r->surveys == 1 ? "" : "s");
    fputs("<p class=\"kicker\">What was recorded</p>\n<h1 class=\"long\">", out);
    answer(out, "hexid gap", &r->gap);
    fputs("</h1>\n<p class=\"lead\">", out);
    answer(out, "hexid identify", &r->identify);
    fputs("</p>\n", out);
    words(out, fact, "t = 0, found by the motion, at t_s =", r->zero);
    snprintf(excluded, sizeof excluded, "hexid gap excludes, because %s", refusals[REFUSED_EMPTY].why);
    words(out, to_do, excluded, r->left_out);
    words(out, fact, "areas of the pressures", r->areas);
    words(out, fact, "as in the default configuration", r->defaults);
    words(out, to_do, "another unit?", r->doubtful), words(out, fact, "missing columns", r->missing);
    words(out, fact, "not understood and left out", r->ignored);
    section_tests(out, r);
    for (int i = 0; i < r->surveys; i++) section_test(p, &r->survey[i]);
}

int check_html(const struct check_report *r, char **page, struct error *error) { return page_make(write_page, r, page, error); }
