#include "gap_tables.h"

#include <math.h>
#include <string.h>

#include "gap_pictures.h"
#include "gap_sections.h"
#include "html.h"
#include "hypothesis.h"
#include "ident.h"
#include "nominal.h"
#include "numeric.h"

/* --- parameters */

static void parameter_cell(FILE *out, const struct gap_effect *e, int key, int leg, const char *unit) {
    fputs("<td class=\"n\">", out);
    html_quantity(out, e->values.value[key][leg], NUMERIC_95 * gap_deviation(e, key, leg), unit);
    if (e->given.on) {
        fputs(" <span class=\"small\">given ", out);
        if (e->pattern != PATTERN_ALL || gap_given_alike(e, key)) html_quantity(out, e->given.value[key][leg], 0.0, "-");
        else fputs("leg by leg", out);
        fputs("</span>", out);
    }
    fputs(e->bound[key][leg] ? " <span class=\"notice\">at its bound</span></td>" : "</td>", out);
}

static void spread_cell(FILE *out, const double value[LEGS], const char *unit) {
    double least = value[0], most = value[0];
    for (int leg = 1; leg < LEGS; leg++) least = fmin(least, value[leg]), most = fmax(most, value[leg]);
    fputs("<td class=\"n\">", out);
    html_quantity(out, least, 0.0, "-");
    fputs(" to ", out);
    html_quantity(out, most, 0.0, unit);
    fputs("</td>", out);
}

void table_parameters(FILE *out, const struct gap_effect *e) {
    const struct effect_key *key = effect_table[e->effect]->keys;
    fputs("<table class=\"parameters\">", out);
    for (int k = 0; k < e->keys; k++) {
        html_print(out, "<tr><td><code>%s</code></td>", key[k].name);
        if (e->pattern == PATTERN_EACH) spread_cell(out, e->values.value[k], key[k].unit);
        else parameter_cell(out, e, k, e->pattern >= 0 ? e->pattern : 0, key[k].unit);
        fputs("</tr>\n", out);
    }
    fputs("</table>\n", out);
}

static void leg_rows(FILE *out, const struct gap_effect *e) {
    const struct effect_key *key = effect_table[e->effect]->keys;
    for (int k = 0; k < e->keys; k++) {
        html_print(out, "<tr><td><code>%s</code></td><td>%s</td>", key[k].name, key[k].unit);
        for (int leg = 0; leg < LEGS; leg++) parameter_cell(out, e, k, leg, "-");
        fputs("</tr>\n", out);
    }
}

void table_legs(FILE *out, const struct gap_result *r) {
    bool any = false;
    for (int i = 0; i < r->effects; i++) any = any || r->effect[i].pattern == PATTERN_EACH;
    if (!any) return;
    fputs("<section id=\"legs\"><h2>Parameters leg by leg</h2>\n", out);
    html_table(out, NULL, "key|unit|>leg 1|>leg 2|>leg 3|>leg 4|>leg 5|>leg 6");
    for (int i = 0; i < r->effects; i++)
        if (r->effect[i].pattern == PATTERN_EACH) leg_rows(out, &r->effect[i]);
    html_table_end(out);
    fputs("</section>\n", out);
}

/* --- statements */

static void statement_row(FILE *out, const struct gap_result *r, const struct gap_statement *s) {
    fputs("<tr><td>", out);
    if (s->family) html_print(out, "%s", effect_families[s->which].words);
    else section_effect_words(out, s->effect.effect, s->effect.pattern, params_legs(&r->model));
    html_print(out, "<br><code>%s</code></td><td class=\"n\">%.3f</td><td class=\"n\">%.1f %%</td><td>", gap_statement_name(s),
               s->probability, 100.0 * s->share_explained);
    table_parameters(out, &s->effect);
    fputs("</td></tr>\n", out);
}

void table_statements(FILE *out, const struct gap_result *r) {
    if (!r->statements) return;
    fputs("<section id=\"statements\"><h2>What is probable beside a remainder</h2>\n"
          "<p>No law is exact on a real machine. Sets of up to four effects were compared under a remainder that none of them makes, "
          "whose size the data determine. The probability is that of all sets in which the statement is true; the share is that of the "
          "effect alone, on data held out; values are those of the likeliest set that has the effect.</p>\n",
          out);
    html_table(out, NULL, "statement|>probability|>share explained|values");
    for (int i = 0; i < r->statements; i++) statement_row(out, r, &r->statement[i]);
    html_table_end(out);
    fputs("</section>\n", out);
}

/* --- hypotheses */

static bool is_named(const struct gap_result *r, int effect) {
    for (int i = 0; i < r->effects; i++)
        if (r->effect[i].effect == effect) return true;
    return false;
}

/* Returns the index of the best candidate that is named; 0 if none is. */
static int first_named(const struct gap_result *r) {
    for (int i = 0; i < r->candidates; i++)
        if (is_named(r, r->candidate[i].effect)) return i;
    return 0;
}

/* Returns the outcome of a candidate in words, or "". For a candidate that ranks before all named
 * effects, the words are the reason why that candidate is not named. */
static const char *fate(const struct gap_result *r, int place) {
    int effect = r->candidate[place].effect;
    if (is_named(r, effect)) return "named";
    for (int i = 0; i < r->ambiguous; i++)
        if (r->ambiguous_with[i] == effect) return "cannot be told apart";
    bool ahead = place < first_named(r);
    for (int i = 0; i < r->effects; i++)
        if (hypothesis_contains(effect, r->effect[i].effect))
            return ahead ? "contains the named one as a limiting case and explains no more: the simpler one is named"
                         : "contains the named one as a limiting case";
    if (!ahead) return "";
    if (r->candidate[place].unseen)
        return "not named: its values are at a bound, or it acts only where a leg may stick, so that these data do not show it";
    return r->effects > 1 ? "not named: beside the named ones together it explains nothing worth naming"
                          : "not named: beside the named one it explains nothing worth naming";
}

static void hypothesis_row(FILE *out, const struct gap_result *r, int place) {
    const struct gap_candidate *c = &r->candidate[place];
    const char *end = fate(r, place);
    double share = fmin(fmax(c->share_explained, 0.0), 1.0);
    fprintf(out, "<tr%s><td class=\"n\">%d</td><td>", strcmp(end, "named") ? "" : " class=\"found\"", place + 1);
    section_effect_words(out, c->effect, c->pattern, params_legs(&r->model));
    html_print(out, "<br><code>%s</code></td><td class=\"bar\"><i style=\"width:%.1f%%\"></i></td>", effect_table[c->effect]->name,
               100.0 * share);
    html_cells(out, ">%.1f %%|>%.1f|%s", 100.0 * share, c->z, end);
    fputs("</tr>\n", out);
}

/* Lists candidates without any gain, by name only. */
static void list_rest(FILE *out, const struct gap_result *r) {
    int rest = 0;
    for (int i = 0; i < r->candidates; i++)
        if (r->candidate[i].gain <= 0.0)
            html_print(out, rest++ ? ", <code>%s</code>" : "<p class=\"small\">No gain at all: <code>%s</code>",
                       effect_table[r->candidate[i].effect]->name);
    if (rest) fputs(".</p>\n", out);
}

static bool any_gain(const struct gap_result *r) {
    for (int i = 0; i < r->candidates; i++)
        if (r->candidate[i].gain > 0.0) return true;
    return false;
}

void table_hypotheses(FILE *out, const struct gap_result *r) {
    fprintf(out,
            "<section id=\"hypotheses\"><h2>Hypotheses, each alone, best first</h2>\n"
            "<p>Each of %d effects of the catalogue, alone, beside the model's own parameters; where one is better alone than those named, "
            "the reason stands beside it. The share is that of the squared gap on cycles that were not fitted to; z, the square root of "
            "twice the gain in log-likelihood on all cycles, is the strength of evidence, comparable to a number of standard deviations. "
            "Below z = 6 nothing is named. Ordered by the gain less a penalty for each parameter.</p>\n",
            r->candidates);
    if (any_gain(r)) {
        fputs("<div class=\"wide\"><table class=\"ranking\"><tr><th class=\"n\">#</th><th>effect</th>"
              "<th colspan=\"2\">share explained</th><th class=\"n\">z</th><th></th></tr>\n",
              out);
        for (int i = 0; i < r->candidates; i++)
            if (r->candidate[i].gain > 0.0) hypothesis_row(out, r, i);
        html_table_end(out);
    }
    list_rest(out, r);
    fputs("</section>\n", out);
}

/* --- numbers */

/* Writes a row of the table of differences. scale: factor from a value to `unit`. */
static void size_row(FILE *out, const char *name, const char *unit, double scale, int decimals, const double value[5]) {
    fputs("<tr>", out);
    html_cells(out, "*%s|%s", name, unit);
    for (int i = 0; i < 5; i++) html_cells(out, ">%.*f", decimals, scale * value[i]);
    fputs("</tr>\n", out);
}

static void size_table(FILE *out, const struct gap_report *report, bool normalised) {
    const struct gap_result *r = report->result;
    const struct gap_size *const sizes[5] = {&r->before, &r->after, &r->held_out_before, &r->held_out_after, &r->noise_floor};
    static const int decimals[GAP_CHANNELS] = {[GAP_LENGTH] = 1, [GAP_FORCE] = 1, [GAP_P1] = 2, [GAP_P2] = 2, [GAP_VALVE] = 4};
    double value[5];
    fputs("<div class=\"wide\">"
          "<table><tr><th rowspan=\"2\">channel</th><th rowspan=\"2\">unit</th><th colspan=\"2\">data used</th><th colspan=\"2\">data "
          "held out</th><th rowspan=\"2\" class=\"n\">noise floor</th></tr>\n",
          out);
    html_head(out, ">before|>after|>before|>after");
    for (int ch = 0; ch < GAP_CHANNELS; ch++) {
        const struct picture_unit *u = &picture_units[ch];
        const char *words = section_channel_words(report->waves->legs, (enum gap_channel)ch);
        for (int i = 0; i < 5; i++) value[i] = normalised ? sizes[i]->normalised[ch] : sizes[i]->channel[ch];
        if (normalised) size_row(out, words, "%", 100.0, 2, value);
        else size_row(out, words, u->difference_unit, u->difference_scale, decimals[ch], value);
    }
    for (int i = 0; i < 5; i++) value[i] = sizes[i]->overall;
    if (normalised) size_row(out, "overall", "%", 100.0, 2, value);
    html_table_end(out);
}

void table_numbers(FILE *out, const struct gap_report *report) {
    fputs("<section id=\"numbers\"><h2>The gap by channel</h2>\n<p>Rms difference of samples: that of the mean cycles and the noise of "
          "the samples about them together, so that a perfect model ends at the noise floor. All with the model's own parameters "
          "fitted. Data used: the even cycles or pieces. Data held out: ",
          out);
    if (report->validate_file) html_print(out, "the log %s.", report->validate_file);
    else fputs("the odd ones, which no fit has seen.", out);
    if (!report->result->simulated)
        fputs(" Not simulated in closed loop: the equations under the measured motion, which take length and valve command as given.", out);
    fputs("</p>\n<div class=\"two\"><div><h3>SI units</h3>\n", out);
    size_table(out, report, false);
    fputs("<p class=\"small\">valve: % of full opening</p></div><div><h3>Normalised by the measured variation</h3>\n", out);
    size_table(out, report, true);
    fputs("<p class=\"small\">overall: root mean square over the channels</p></div></div></section>\n", out);
}

/* --- parameters of the base model */

static void base_row(FILE *out, const struct gap_base_value *b) {
    html_print(out, "<tr><td><code>%s</code>", b->name);
    if (b->leg >= 0) fprintf(out, " leg %d", b->leg + 1);
    fputs("</td><td class=\"n\">", out);
    html_quantity(out, b->given, 0.0, "-");
    fputs("</td><td class=\"n\">", out);
    html_quantity(out, b->value, b->bound ? 0.0 : NUMERIC_95 * b->std, "-");
    fputs("</td>", out);
    html_cells(out, ">%+.2f %%|%s", b->given != 0.0 ? 100.0 * (b->value / b->given - 1.0) : (double)NAN,
               b->bound           ? "at its bound"
               : isfinite(b->std) ? ""
                                  : "held beside the effect");
    fputs("</tr>\n", out);
}

void table_base(FILE *out, const struct gap_result *r) {
    fputs("<section id=\"base\"><h2>The model's own parameters, fitted</h2>\n"
          "<p>No configuration is exact: these are fitted first, within what <code>model.tolerance</code> and the usual uncertainty of "
          "what it does not state allow. None of them is a finding; <code>model.yaml</code> keeps the values given.</p>\n",
          out);
    html_table(out, NULL, "key|>given|>fitted|>change|");
    for (int i = 0; i < r->base_values; i++) base_row(out, &r->base[i]);
    html_table_end(out);
    fputs("</section>\n", out);
}

/* --- inertia matrix */

/* Writes a reference and two matrices, entry by entry, with their differences from the
 * reference. */
static void matrix_table(FILE *out, const char *const names[3], const double (*reference)[DOFS], const double (*first)[DOFS],
                         const double (*second)[DOFS]) {
    html_table(out, NULL, "entry|unit|>%s|>%s|>off by|>%s|>off by", names[0], names[1], names[2]);
    for (const struct ident_entry *e = ident_entries; e < ident_entries + IDENT_ENTRIES; e++) {
        double whole = ident_scale(reference, e), is = reference[e->row][e->col], a = first[e->row][e->col], b = second[e->row][e->col];
        html_row(out, "*%s|%s|>%.3f|>%.3f|>%+.2f %%|>%.3f|>%+.2f %%", e->name, e->unit, is, a, 100.0 * (a - is) / whole, b,
                 100.0 * (b - is) / whole);
    }
    html_table_end(out);
}

static void repaired_table(FILE *out, const struct gap_result *r) {
    static const char *const names[3] = {"configuration", "measured", "friction taken off"};
    static const double neutral[DOFS] = {0};
    struct kinematics k;
    struct error error;
    double nominal[DOFS][DOFS];
    if (kinematics_init(&k, &r->model, &error)) return;
    nominal_matrix(&r->model, &k, neutral, nominal);
    fputs("<h3>Without the friction found</h3>\n"
          "<p>Dry friction spoils the identification. What it does to the matrix of the model, run with it and without, is taken off the "
          "measured one. Beside the matrix that the configuration implies:</p>\n",
          out);
    matrix_table(out, names, (const double (*)[DOFS])nominal, r->measured_mt, r->repaired_mt);
}

void table_matrix(FILE *out, const struct gap_result *r) {
    static const char *const names[3] = {"measured", "model before", "model after"};
    if (!r->matrices) return;
    fputs("<section id=\"matrix\"><h2>Identified inertia matrix</h2>\n"
          "<p>Method A of Tian 2015 on the measured log, and on the logs that the model before and after gives when it is driven as the "
          "rig was. What the missing effect does to the identification, the model must do too. Off by: in % of the first value, of a "
          "coupling (Mt15 ...) in % of √(Mii Mjj).</p>\n",
          out);
    matrix_table(out, names, r->measured_mt, r->before_mt, r->after_mt);
    if (r->repaired) repaired_table(out, r);
    fputs("</section>\n", out);
}
