#include <math.h>

#include "html.h"
#include "page.h"
#include "plot.h"
#include "quality_report.h"
#include "units.h"
#include "words.h"

enum { BODE_WIDTH = 1100, BODE_HEIGHT = 620 };
static const char *const arm_unit[2] = {"mm", "mrad"};

/* Writes a number followed by `after`. A number that is not finite becomes "NaN", which gnuplot
 * leaves out; it does not understand "-nan" or "inf". */
static void bode_number(FILE *script, double value, char after) {
    if (isfinite(value)) fprintf(script, "%.6g%c", value, after);
    else fprintf(script, "NaN%c", after);
}

/* Writes the data of the three axes from `from` on, named $a0 .. $a2 for name 'a', in columns:
 * frequency in Hz, gain in dB, phase in degrees, coherence. */
static void bode_data(FILE *script, const struct quality *q, int from, char name) {
    for (int dof = from; dof < from + 3; dof++) {
        fprintf(script, "$%c%d << EOD\n", name, dof - from);
        for (int i = 0; i < q->plan.tones; i++) {
            bode_number(script, q->tone[dof][i].hz, ' ');
            bode_number(script, 20.0 * log10(cabs(q->tone[dof][i].gain[dof])), ' ');
            bode_number(script, quality_phase_deg(q, dof, i), ' ');
            bode_number(script, q->tone[dof][i].coherence, '\n');
        }
        fputs("EOD\n", script);
    }
}

static void bode_plot(FILE *script, int from, int column, bool before) {
    for (int i = 0; i < 3; i++) {
        fprintf(script, "%s $a%d using 1:%d with linespoints pt 7 ps 0.5 lw 1.6 lc rgb '%s' title '%s'", i ? "," : "plot", i, column,
                plot_colours[i], words_axes[from + i]);
        if (before) fprintf(script, ", $b%d using 1:%d with lines lw 1.2 dt (6,4) lc rgb '%s' title ''", i, column, plot_colours[i]);
    }
    fputc('\n', script);
}

struct bode {
    const struct quality_report *r;
    int from;
};

static void bode(FILE *script, const void *subject) {
    const struct bode *b = subject;
    const struct quality *q = &b->r->quality;
    static const struct {
        double top, bottom;
        const char *label;
        int column;
    } panels[] = {{0.93, 0.63, "gain [dB]", 2}, {0.61, 0.31, "phase [deg]", 3}, {0.29, 0.10, "coherence", 4}};
    plot_begin(script, BODE_WIDTH, BODE_HEIGHT);
    bode_data(script, q, b->from, 'a');
    if (b->r->baseline) bode_data(script, &b->r->before, b->from, 'b');
    plot_panels(script, 0.085, 0.09, 1.1 * q->tone[0][q->plan.tones - 1].hz);
    fputs("set logscale x\nset offsets 0,0,graph 0.08,graph 0.08\nset key at screen 0.98, screen 0.995 right top horizontal\n", script);
    for (int i = 0; i < 3; i++) {
        plot_panel(script, panels[i].top, panels[i].bottom, i == 2 ? "frequency [Hz]" : NULL, panels[i].label);
        if (i) fputs("unset key\n", script);
        if (panels[i].column == 4) fputs("set offsets\nset yrange [*<0.99:1]\n", script);
        bode_plot(script, b->from, panels[i].column, b->r->baseline);
    }
}

static void section_checks(FILE *out, const struct quality_report *r) {
    fputs("<h2>The operator's limits</h2>\n<p class=\"small\">The section <code>qualify</code> of the configuration; without a limit a "
          "quantity is measured and not evaluated. The worst value stands here; angles count as lengths at the upper joints.</p>\n",
          out);
    html_table(out, "facts", "quantity|>worst|>limit|where|status");
    for (const struct quality_check *c = r->check; c < r->check + QUALITY_CHECKS; c++) {
        fputs("<tr>", out);
        html_cells(out, "%s|>%.3g %s|>%.3g %s", c->what, c->value, c->unit, c->limit > 0.0 ? c->limit : (double)NAN, c->unit);
        html_cells(out, isnan(c->hz) ? "%s" : "%s at %.3g Hz", c->dof == DOF_NONE ? "" : words_axes[c->dof], c->hz);
        html_print(out, c->status == VERDICT_FAIL ? "<td class=\"off\">%s</td></tr>\n" : "<td>%s</td></tr>\n", verdict_names[c->status]);
    }
    html_table_end(out);
}

static void section_bode(struct page *p, const struct quality_report *r) {
    fputs("<h2>Describing functions</h2>\n", p->out);
    for (int from = 0; from < DOFS; from += 3) {
        const struct bode b = {r, from};
        page_figure(p, bode, &b, "Each axis against its own reference, one sine at a time, at the amplitudes below.%s",
                    r->baseline ? " Dashed: the baseline." : "");
    }
    fputs("<details><summary>Every tone</summary>\n", p->out);
    html_table(p->out, "survey", "axis|>Hz|>amplitude|>gain|>phase|>± (std)|>coherence|>harmonics 2, 3|>higher|>noise|>peak");
    for (int dof = 0; dof < DOFS; dof++)
        for (int i = 0; i < r->quality.plan.tones; i++) {
            const struct quality_tone *t = &r->quality.tone[dof][i];
            html_row(p->out, "%s|>%.3g|>%.3g %s|>%.4f|>%.2f°|>%.2g|>%.5f|>%.2f %%|>%.2f %%|>%.2f %%|>%.2f %%", words_axes[dof], t->hz,
                     1e3 * t->amplitude, arm_unit[dof >= DOF_PHI], cabs(t->gain[dof]), quality_phase_deg(&r->quality, dof, i), t->std,
                     t->coherence, 100.0 * t->low, 100.0 * t->high, 100.0 * t->noise, 100.0 * t->peak);
        }
    html_table_end(p->out);
    fputs("<p class=\"small\">± is one standard deviation of the gain, and of the phase in radians. Harmonics, noise and peak: "
          "acceleration up to 20 Hz beside the tone, over the tone's own. A dash: beyond 20 Hz.</p></details>\n",
          p->out);
}

static void section_cross(FILE *out, const struct quality_report *r) {
    const struct quality *q = &r->quality;
    fputs("<h2>Cross-talk</h2>\n<p class=\"small\">Motion of each axis in per cent of the driven axis's reference, the largest over all "
          "tones up to the limits' range and over all; angles as lengths at the upper joints.</p>\n",
          out);
    html_table(out, "values", "driven|>x|>y|>z|>φ|>θ|>ψ|>largest of all tones");
    for (int dof = 0; dof < DOFS; dof++) {
        double low[DOFS] = {0}, all = 0.0;
        for (int i = 0; i < q->plan.tones; i++)
            for (int k = 0; k < DOFS; k++) {
                double share = 100.0 * quality_cross(q, dof, i, k);
                if (q->tone[dof][i].hz <= 1.02 * r->limits.up_to_hz && k != dof) low[k] = quality_worse(low[k], share);
                if (k != dof) all = quality_worse(all, share);
            }
        low[dof] = (double)NAN;
        html_row(out, "%s|>%.2f|>%.2f|>%.2f|>%.2f|>%.2f|>%.2f|>%.2f", words_axes[dof], low[0], low[1], low[2], low[3], low[4], low[5], all);
    }
    html_table_end(out);
}

static void section_axes(FILE *out, const struct quality_report *r) {
    const struct quality *q = &r->quality;
    fputs("<h2>Noise, small motions, and what was reached</h2>\n", out);
    html_table(out, "survey",
               "axis|>noise at rest|>threshold|>hysteresis|>lag|>dead time|>half of a step|>turn-around|>excursion|>rate|>acceleration");
    for (int dof = 0; dof < DOFS; dof++) {
        const struct quality_axis *a = &q->axis[dof];
        const char *unit = dof < DOF_PHI ? "m" : "rad";
        html_row(out, "%s|>%.2f m%s/s²|>%.1f µ%s|>%.1f µ%s|>%.2f ms|>%.2f ms|>%.2f ms|>%.2f m%s/s²|>%.1f m%s|>%.3f %s/s|>%.2f %s/s²",
                 words_axes[dof], 1e3 * quality_rest(q, dof), unit, 1e6 * a->threshold, unit, 1e6 * a->hysteresis, unit, 1e3 * a->lag_s,
                 1e3 * a->dead_s, 1e3 * a->half_s, 1e3 * a->turn_around, unit, 1e3 * a->excursion, unit, a->rate, unit, a->accel, unit);
    }
    html_table_end(out);
    fputs("<h3>Noise at rest, band by band (rms acceleration)</h3>\n", out);
    html_table(out, "values", "axis|>0.2 to 1 Hz|>1 to 5 Hz|>5 to 20 Hz|>20 to 50 Hz");
    for (int dof = 0; dof < DOFS; dof++) {
        const double *b = q->axis[dof].rest;
        const char *unit = dof < DOF_PHI ? "mm/s²" : "mrad/s²";
        html_row(out, "%s|>%.3g %s|>%.3g %s|>%.3g %s|>%.3g %s", words_axes[dof], 1e3 * b[0], unit, 1e3 * b[1], unit, 1e3 * b[2], unit,
                 1e3 * b[3], unit);
    }
    html_table_end(out);
    fputs("<h3>Leg balance: z at 0.5 Hz</h3>\n", out);
    html_table(out, "values", "leg|>gain|>phase");
    for (int k = 0; k < LEGS; k++) html_row(out, "%d|>%.4f|>%.2f°", k + 1, cabs(q->leg[k]), deg_from_rad(carg(q->leg[k])));
    html_table_end(out);
}

static void section_baseline(FILE *out, const struct quality_report *r) {
    html_print(out,
               "<h2>Against the baseline</h2>\n<p><code>%s</code>: over all tones the describing functions differ by %.3g times what "
               "the noise of both explains (rms; about 1: nothing has changed).</p>\n",
               r->baseline, quality_change_of_noise(&r->quality, &r->before));
    fputs("<details><summary>Every tone</summary>\n", out);
    html_table(out, "survey", "axis|>Hz|>gain|>phase|>acceleration|>of noise");
    for (int dof = 0; dof < DOFS; dof++)
        for (int i = 0; i < r->quality.plan.tones; i++) {
            struct quality_change c = quality_change(&r->quality, &r->before, dof, i);
            html_row(out, "%s|>%.3g|>%+.2f %%|>%+.2f°|>%.2g m/s²|>%.1f", words_axes[dof], r->quality.tone[dof][i].hz, c.gain_pct,
                     c.phase_deg, c.mps2, c.of_noise);
        }
    html_table_end(out);
    fputs("</details>\n", out);
    html_table(out, "survey", "axis|>threshold|>hysteresis|>dead time|>turn-around");
    for (int dof = 0; dof < DOFS; dof++) {
        const struct quality_axis *a = &r->quality.axis[dof], *b = &r->before.axis[dof];
        const char *unit = dof < DOF_PHI ? "m" : "rad";
        html_row(out, "%s|>%+.1f µ%s|>%+.1f µ%s|>%+.2f ms|>%+.2f m%s/s²", words_axes[dof], 1e6 * (a->threshold - b->threshold), unit,
                 1e6 * (a->hysteresis - b->hysteresis), unit, 1e3 * (a->dead_s - b->dead_s), 1e3 * (a->turn_around - b->turn_around), unit);
    }
    html_table_end(out);
}

static const char *headline(enum verdict_status v) {
    return v == VERDICT_PASS   ? "Measured as within the operator's limits"
           : v == VERDICT_FAIL ? "Measured as outside the operator's limits"
                               : "Measured; not evaluated against all limits";
}

static void write_page(struct page *p, const void *subject) {
    const struct quality_report *r = subject;
    page_begin(p, "qualify", NULL);
    html_print(p->out, "%s</code></span><span>hexid %s</span></header>\n", r->log, r->version);
    html_print(p->out, "<p class=\"kicker\">Quality of the motion system</p>\n<h1>%s</h1>\n", headline(quality_verdict(r->check)));
    html_print(p->out,
               "<p class=\"lead\">Quantities as AGARD-AR-144 and 14 CFR 60 appendix A (3.a to 3.d) describe them, of the pose by the leg "
               "lengths against the reference. Control law: %s. %d of %d samples missing. A measurement, not a qualification by an "
               "authority.</p>\n",
               r->law, r->quality.missing, r->quality.plan.cycles);
    section_checks(p->out, r);
    section_bode(p, r);
    section_cross(p->out, r);
    section_axes(p->out, r);
    if (r->baseline) section_baseline(p->out, r);
}

int quality_html(const struct quality_report *r, char **page, struct error *error) { return page_make(write_page, r, page, error); }
