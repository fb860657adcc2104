#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check_pictures.h"
#include "check_report.h"
#include "html.h"
#include "page.h"

/* Styles of a sentence. Only one that asks for action has the colour of a warning, as only such a
 * line has a '!' on the terminal. */
static const char fact[] = "", to_do[] = " class=\"notice\"";

static void head_cells(FILE *out, const char *const *names) {
    fputs("<tr>", out);
    for (; *names; names++) fprintf(out, "<th%s>%s</th>", **names == '*' ? "" : " class=\"n\"", *names + (**names == '*'));
    fputs("</tr>\n", out);
}

static void cell(FILE *out, double value, int digits, const char *unit) {
    fputs("<td class=\"n\">", out);
    if (isfinite(value)) html_text(out, "%.*g %s", digits, value, unit);
    else fputs("–", out);
    fputs("</td>", out);
}

static void section_tests(FILE *out, const struct check_report *r) {
    static const char *const names[] = {"*test", "*axis",  "stated", "measured",    "amplitude", "recorded",         "rows",
                                        "rate",  "jitter", "lost",   "longest gap", "flagged",   "without a number", NULL};
    fputs("<h2>Tests</h2>\n<div class=\"wide\"><table class=\"survey\">\n", out);
    head_cells(out, names);
    for (const struct survey *s = r->survey; s < r->survey + r->surveys; s++) {
        fputs("<tr><td><span>", out);
        html_text(out, "%s", s->name);
        fprintf(out, "</span></td><td>%s</td>", s->test.dof == DOF_NONE ? "none" : dof_names[s->test.dof]);
        cell(out, s->stated_hz, 5, "Hz"), cell(out, s->measured_hz, 6, "Hz");
        cell(out, 1e3 * s->amplitude, 4, check_amplitude_unit(s)), cell(out, survey_seconds(s), 5, "s");
        cell(out, s->test.count, 9, ""), cell(out, 1.0 / s->sampling.step_s, 6, "Hz"), cell(out, check_jitter_ms(s), 2, "ms");
        cell(out, (double)s->sampling.lost, 9, ""), cell(out, 1e3 * s->sampling.gap_s, 4, "ms");
        cell(out, s->flagged, 9, ""), cell(out, s->not_a_number, 9, "");
        fputs("</tr>\n", out);
    }
    fputs("</table></div>\n<p class=\"small\">Noise, below: one standard deviation of a sample of the worst channel.</p>\n", out);
}

/* Writes a table cell with the numbers of faulty legs: "1, 2, 5". */
static void legs_cell(FILE *out, unsigned bits) {
    const char *before = "<td class=\"n\"><span class=\"notice\">";
    for (int i = 0; i < LEGS; i++)
        if (bits >> i & 1u) fprintf(out, "%s%d", before, i + 1), before = ", ";
    fputs(bits ? "</span></td>" : "<td class=\"n\">–</td>", out);
}

static void section_channels(FILE *out, const struct survey *s) {
    static const char *const names[] = {"*channel",    "present",       "minimum", "maximum", "noise, rms",
                                        "sensor step", "never changes", "clipped", NULL};
    fputs("<div class=\"wide\"><table class=\"survey\">\n", out);
    head_cells(out, names);
    for (int kind = 0; kind < SURVEY_KINDS; kind++) {
        const struct survey_channel *c = &s->channel[kind];
        double scale = check_units[kind].scale;
        const char *unit = check_unit_of(s, (enum survey_kind)kind);
        if (!c->of) continue;
        fprintf(out, "<tr><td>%s</td><td class=\"n\">%d of %d</td>", check_name_of(s, (enum survey_kind)kind), __builtin_popcount(c->there),
                c->of);
        cell(out, scale * c->low, 6, unit), cell(out, scale * c->high, 6, unit), cell(out, scale * c->noise, 3, unit);
        cell(out, c->step > 0.0 ? scale * c->step : (double)NAN, 3, unit);
        legs_cell(out, c->dead), legs_cell(out, c->clipped);
        fputs("</tr>\n", out);
    }
    fputs("</table></div>\n", out);
}

static void words(FILE *out, const char *style, const char *label, const char *text) {
    if (!*text) return;
    fprintf(out, "<p%s>", style);
    html_text(out, "%s: %s", label, text);
    fputs("</p>\n", out);
}

static void section_test(FILE *out, const struct survey *s, struct error *picture) {
    static const char caption[] =
        "As measured, over the time of the test. Grey ground: at rest; blue: steady motion, found by the position "
        "alone. Where there are more samples than pixels, a curve is the band between their minimum and maximum.";
    char *script = NULL, ramp[CHECK_RAMP_SIZE];
    size_t size = 0;
    FILE *stream = s->test.count && !picture->status ? open_memstream(&script, &size) : NULL;
    if (stream) {
        check_picture(stream, s);
        if (fclose(stream)) error_set(picture, STATUS_IO, "out of memory");
    }
    fputs("<section class=\"panels\"><h2>", out);
    html_text(out, "%s", s->name);
    fputs("</h2>\n", out);
    check_ramp(s, ramp);
    words(out, to_do, "ramp", ramp);
    page_figure(out, script, size, caption, picture);
    section_channels(out, s);
    fputs("</section>\n", out);
    free(script);
}

static void answer(FILE *out, const char *command, const struct error *e) {
    html_text(out, "%s would %s it%s", command, e->status ? "refuse" : "take", e->text[0] ? check_answer_joint(e) : ".");
    html_commands(out, e->text);
}

static void write_all(FILE *out, const struct check_report *r, struct error *picture) {
    char excluded[120];
    page_begin(out, "hexid check");
    fputs("<header><span>hexid check: <code>", out);
    for (int i = 0; i < r->sources; i++) html_text(out, "%s%s", i ? " " : "", r->source[i]);
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
    for (int i = 0; i < r->surveys; i++) section_test(out, &r->survey[i], picture);
    if (picture->status) words(out, to_do, "pictures", picture->text);
    fputs("</body>\n</html>\n", out);
}

int check_html(const struct check_report *r, char **page, struct error *error) {
    struct error picture = {0};
    size_t size = 0;
    *page = NULL;
    FILE *out = open_memstream(page, &size);
    if (out) write_all(out, r, &picture);
    if (!out || fclose(out)) {
        free(*page);
        *page = NULL;
        return error_set(error, STATUS_IO, "out of memory");
    }
    if (picture.status) *error = picture;
    return picture.status;
}
