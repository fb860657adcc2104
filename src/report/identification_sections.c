#include "identification_sections.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "html.h"
#include "identification_pictures.h"
#include "identification_tables.h"
#include "numeric.h"
#include "params.h"

enum { QUANTITY = 60 };

/* Begins a section. number: "Log 2: " if there are several logs, otherwise "". */
static void title(FILE *out, const char *number, const char *words) { html_print(out, "<section><h2>%s%s</h2>\n", number, words); }

/* --- matrices */

/* Writes the systematic errors that the data show (method_c_found()). */
static void systematic_errors(FILE *out, const struct method_c *c) {
    int found = 0;
    for (int i = 0; i < SYSTEMATICS; i++) found += method_c_found(&c->systematic[i]);
    if (!found) {
        fputs("<p>The data show no systematic error: zero is inside the interval of each.</p>\n", out);
        return;
    }
    fputs("<p>Systematic errors that the data show, because zero is outside of their interval.</p>\n", out);
    html_table(out, NULL, "error|>found|>±|>tolerance, standard deviation|key");
    for (int i = 0; i < SYSTEMATICS; i++) {
        const struct systematic_found *e = &c->systematic[i];
        const struct systematic_words *words = &systematic_families[systematic_family(i)];
        char name[SYSTEMATIC_NAME];
        if (!method_c_found(e)) continue;
        systematic_name(i, name);
        html_row(out, "%s|>%+.3g %s|>%.2g %s|>%.2g %s|model.tolerance.%s", name, words->scale * e->value, words->unit,
                 NUMERIC_95 * words->scale * e->std, words->unit, words->scale * e->prior, words->unit, words->key);
    }
    html_table_end(out);
}

/* Writes that the gain common to all pressure (or force) sensors is known from its prior alone;
 * nothing if a known weight was read or no gain has a prior. */
static void common_gain(FILE *out, const struct common_gain *gain) {
    if (!gain->sensors) return;
    fprintf(out,
            "<p class=\"notice\">A gain that all %s have in common shows in no motion: masses, inertias and friction are as exact as it, "
            "± %.2g %% by model.tolerance.pressure_gain (the mean of %d, ± %.2g %% each). A known weight finds it "
            "(hexid identify --weight).</p>\n",
            gain->pressures ? "pressures" : "force sensors", 100.0 * NUMERIC_95 * gain->std, gain->sensors,
            100.0 * NUMERIC_95 * gain->tolerance);
}

/* Writes the systematic errors, and the share of each cause in the variance of the diagonal. */
static void systematic(FILE *out, const struct identification *id) {
    const struct method_c *c = &id->method_c;
    fputs("<h3>Sensors and drawing</h3>\n", out);
    systematic_errors(out, c);
    common_gain(out, &id->common_gain);
    fputs("<p>Where the width of the intervals comes from: shares of the variance.</p>\n", out);
    html_table(out, NULL, "cause|>mx|>my|>mz|>Ixx|>Iyy|>Izz");
    for (int k = 0; k < CAUSES; k++) {
        const double (*share)[DOFS] = c->share[k];
        html_row(out, "%s|>%.0f %%|>%.0f %%|>%.0f %%|>%.0f %%|>%.0f %%|>%.0f %%", method_c_cause(k), 100.0 * share[0][0],
                 100.0 * share[1][1], 100.0 * share[2][2], 100.0 * share[3][3], 100.0 * share[4][4], 100.0 * share[5][5]);
    }
    html_table_end(out);
}

static void section_matrices(FILE *out, const struct identification_log *l, const char *number) {
    const struct method_c *c = &l->id->method_c;
    bool unknown = false;
    title(out, number, "All entries of the matrix");
    html_print(out,
               "<p>Mt at the neutral pose, about the payload's mass centre; rows and columns x y z φ θ ψ; masses in kg, couplings in kg m, "
               "inertias in kg m². Below each entry its interval%s.</p>\n",
               l->id->method_a.evaluated ? ": of A, modified A and B the sensors' noise alone; of C also the errors of sensors and drawing"
                                         : "");
    table_matrices(out, l->id);
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) unknown = unknown || (c->matrix.evaluated && !isfinite(c->matrix.mt[i][j]));
    if (unknown)
        fputs("<p>– : not determined by this motion. The entry's standard deviation is above a fifth of √(Mii Mjj): the motion "
              "does not excite it, or not apart from others.</p>\n",
              out);
    if (l->sinusoids && !l->id->method_a.evaluated)
        html_print(out, "<p class=\"notice\">Methods A and B: not evaluated: %s.</p>\n",
                   l->id->refuted ? "the recording contradicts the configured machine" : "they need complete tests of all six axes");
    if (!l->sinusoids) fputs("<p>Methods A and B need sinusoids of one axis after another; this motion is none for them.</p>\n", out);
    if (!c->matrix.evaluated && l->id->no_method_c.status)
        html_print(out, "<p class=\"notice\">Method C: not evaluated: %s</p>\n", l->id->no_method_c.text);
    if (c->matrix.evaluated) systematic(out, l->id);
    fputs("</section>\n", out);
}

/* --- tests */

static int worst_axis(const struct test_result *t) {
    int worst = 0;
    for (int i = 1; i < DOFS; i++)
        if (t->unwanted_pct[i] > t->unwanted_pct[worst]) worst = i;
    return worst;
}

static void test_row(FILE *out, const struct test_result *t) {
    int worst = worst_axis(t);
    double asked = t->asked_amplitude > 0.0 ? t->asked_amplitude : t->amplitude;
    fprintf(out, "<tr><td>%s%s</td>", dof_names[t->dof], t->refused ? " <span class=\"notice\">excluded</span>" : "");
    html_cells(out, ">%.4g Hz|>%.3f of %.3f %s|>%+.1f %%|>%.1f°|>%.1f %% of %s|>%" PRId64 "|>%" PRId64 "|>%.4f|>%.1f", t->frequency_hz,
               1e3 * t->achieved_amplitude, 1e3 * asked, t->dof < DOF_PHI ? "mm" : "mrad", 100.0 * (t->achieved_amplitude / asked - 1.0),
               t->phase_deg, t->unwanted_pct[worst], dof_names[worst], t->samples, t->excluded, 1e3 * t->witness.length_m,
               t->witness.force_n);
    fputs("</tr>\n", out);
}

static void test_table(FILE *out, const struct identification_log *l) {
    const struct check_params *limit = &l->params->checks;
    html_table(out, NULL, "test|>frequency|>amplitude|>off|>phase|>unwanted|>samples|>excluded|>length wanders, mm|>force wanders, N");
    for (int i = 0; i < l->id->tests; i++) test_row(out, &l->id->test[i]);
    html_head(out, "limit|||>%g %%||>%g %%||>%g %%|>%g|>%g", limit->amplitude_pct, limit->unwanted_pct, limit->excluded_pct,
              1e3 * limit->length_wander_m, limit->force_wander_n);
    html_table_end(out);
    fputs("<p class=\"small\">Amplitude and phase are of the fundamental of the measured motion, the amplitude against that of the "
          "recorded reference (without one the configured amplitude, and then it is not judged), the phase against its sine. Unwanted: "
          "the largest motion of another axis, against the amplitude of its own test. Wanders: how far the fundamental of "
          "a leg's length, and mean or fundamental of its force, are apart between periods, worst leg.</p>\n",
          out);
}

static void motion_words(FILE *out, const struct identification_motion *m) {
    html_print(out, "<p>%s: %lld of %lld samples excluded%s.", m->name, (long long)m->excluded, (long long)(m->samples + m->excluded),
               m->complete ? "" : "; it did not come to its end");
    if (m->samples && isfinite(m->off_m) && isfinite(m->off_rad))
        html_print(out, " Farthest from the reference: %.3f mm, %.3f mrad.", 1e3 * m->off_m, 1e3 * m->off_rad);
    fputs("</p>\n", out);
}

static void test_figure(struct page *p, const struct identification_log *l, int test) {
    const struct recording_test *t = &l->recording->test[test];
    if (!recording_begins(l->recording, test) || t->first < 0 || t->end < t->first + 2) return;
    struct picture_test picture = picture_of_test(l, test);
    page_figure(p, picture_test, &picture,
                "%s %s: %.3g s %s. Above the pose by the measured lengths, dashed its reference; below the leg forces%s.",
                t->dof == DOF_NONE ? "Motion" : "Test", tests_name(&l->params->tests, t->dof), picture.seconds,
                t->segment_s > 0.0 ? "from its middle" : "from the evaluated part's beginning",
                l->recording->measured.pressures ? " A1 P1 - A2 P2" : "");
}

/* For a motion that was evaluated in parts, writes which part of it the pictures show: the samples
 * of earlier parts are not kept (src/cli/parts.h). Returns false if there is nothing to draw. */
static bool long_motion(FILE *out, const struct identification_log *l) {
    if (!l->id->parts) return true;
    fputs(l->recording->tests ? "<p class=\"small\">The motion is long: the numbers are of all of it, the pictures of what came after "
                                "its last part of 180 s.</p>\n"
                              : "<p class=\"small\">The motion is long: the numbers are of all of it. What came after its last part of "
                                "180 s is too short for pictures.</p>\n",
          out);
    return l->recording->tests > 0;
}

static void section_tests(struct page *p, const struct identification_log *l, const char *number) {
    title(p->out, number, "Motion and leg forces");
    if (l->id->tests) test_table(p->out, l);
    else if (!l->motion.there) fputs("<p>No test in the log.</p>\n", p->out);
    if (l->motion.there) motion_words(p->out, &l->motion);
    bool drawn = long_motion(p->out, l);
    fputs("<div class=\"two\">\n", p->out);
    if (drawn)
        for (int i = 0; i < l->recording->tests; i++) test_figure(p, l, i);
    fputs("</div></section>\n", p->out);
}

/* --- friction */

/* Writes a quantity such as "2000 ± 60"; a dash if it is not known. */
static const char *quantity(double value, double std, int decimals, char text[QUANTITY]) {
    snprintf(text, QUANTITY, isfinite(value) ? "%.*f ± %.*f" : "–", decimals, value, decimals, NUMERIC_95 * std);
    return text;
}

static void friction_figures(struct page *p, const struct identification_log *l, const struct leg_friction *f) {
    const struct method_c *c = &l->id->method_c;
    char viscous[QUANTITY], extending[QUANTITY], retracting[QUANTITY];
    fputs("<div class=\"third\">\n", p->out);
    for (int leg = 0; leg < LEGS; leg++)
        page_figure(p, picture_friction, &(struct picture_friction){.measured = f, .found = c, .leg = leg},
                    "Leg %d: viscous %s N s/m, dry %s N extending, %s N retracting", leg + 1,
                    quantity(c->viscous[leg], c->viscous_std[leg], 0, viscous), quantity(c->dry[leg][0], c->dry_std[leg][0], 1, extending),
                    quantity(c->dry[leg][1], c->dry_std[leg][1], 1, retracting));
    fputs("</div>\n", p->out);
}

static void friction_found(struct page *p, const struct identification_log *l) {
    struct leg_friction friction;
    struct error error;
    fputs("<p>Grey, as measured: the leg's force less what inertia and weight need of it for this motion, with the matrix that method C "
          "found. Blue, what method C found: a slope, the viscous friction, and a step at zero, the dry friction of each direction. A "
          "constant error of the force moves both steps alike.</p>\n",
          p->out);
    int status = leg_friction_find(&friction, l->recording, &l->id->method_c, &error);
    if (status) html_print(p->out, "<p class=\"notice\">%s</p>\n", error.text);
    else friction_figures(p, l, &friction);
    if (!status && friction.tests && friction.test[0].cycle)
        fprintf(p->out,
                "<p class=\"small\">Mean cycles of the tests, in the %d harmonics that method C evaluates: they cannot follow a "
                "step, overshoot beside it, and a leg that sticks at a reversal is anywhere between the two lines.</p>\n",
                RESIDUAL_HARMONICS);
    else if (!status)
        fputs("<p class=\"small\">Up to a dozen pieces all over the motion, the middle of each, in the band that method C evaluates: a "
              "step is drawn out there, and a leg that sticks at a reversal is anywhere between the two lines.</p>\n",
              p->out);
    leg_friction_free(&friction);
}

static void section_friction(struct page *p, const struct identification_log *l, const char *number) {
    if (!l->id->method_c.matrix.evaluated) return;
    title(p->out, number, "Friction of each leg");
    if (long_motion(p->out, l)) friction_found(p, l);
    fputs("</section>\n", p->out);
}

/* --- checks */

static void exclusions(FILE *out, const struct identification_log *l) {
    bool any = false;
    fputs("<h3>What was excluded</h3>\n<p>Only the evaluated part of each test is used, without settling and ramps.</p>\n<ul>\n", out);
    for (int i = REFUSED_NOT + 1; i < REFUSALS; i++) {
        if (!l->refused[i]) continue;
        fprintf(out, "<li>%" PRId64 " sample%s %s</li>\n", l->refused[i], l->refused[i] == 1 ? ":" : "s:", refusals[i].why);
        any = true;
    }
    if (!any) fputs("<li>No sample.</li>\n", out);
    for (int i = 0; i < l->id->tests; i++)
        if (l->id->test[i].refused)
            fprintf(out, "<li>Test %s: %s.</li>\n", dof_names[l->id->test[i].dof], refusals[l->id->test[i].refused].why);
    if (l->loop.lost) fprintf(out, "<li>%" PRId64 " cycles are missing in the log.</li>\n", l->loop.lost);
    if (l->cut >= 0) fprintf(out, "<li>The log is cut off or damaged: read up to byte %" PRId64 ".</li>\n", l->cut);
    if (l->fault) html_print(out, "<li>The run ended with the fault %s.</li>\n", l->fault);
    fputs("</ul>\n", out);
}

/* Finds the largest asymmetry of method A's matrix, in % of sqrt(Mii Mjj) as the verdict computes
 * it, and its row and column, from 1. */
static double asymmetry_pct(const struct method_result *a, int *row, int *column) {
    double most = -1.0;
    for (int i = 0; i < DOFS; i++)
        for (int j = i + 1; j < DOFS; j++) {
            double skew_pct = 100.0 * fabs(a->mt[i][j] - a->mt[j][i]) / sqrt(fabs(a->mt[i][i] * a->mt[j][j]));
            if (skew_pct > most) most = skew_pct, *row = i + 1, *column = j + 1;
        }
    return most;
}

/* Begins a list of a verdict's reasons and notes; the caller ends it. */
static void verdict_list(FILE *out, const struct verdict *v) {
    fputs("<ul>\n", out);
    for (int i = 0; i < v->reasons; i++) html_print(out, "<li><span class=\"notice\">%s</span></li>\n", v->reason[i]);
    if (v->status == VERDICT_PASS) fputs("<li>No check failed.</li>\n", out);
    for (int i = 0; i < v->notes; i++) html_print(out, "<li>Note: %s.</li>\n", v->note[i]);
}

/* Writes the verdicts of the methods that have a result. */
static void method_verdicts(FILE *out, const struct identification_log *l) {
    const struct identification *id = l->id;
    const struct {
        const char *name;
        const struct method_result *result;
        const struct verdict *verdict;
    } method[] = {{"Method C", &id->method_c.matrix, &l->verdicts->method_c},
                  {"Method A", &id->method_a, &l->verdicts->method_a},
                  {"Modified method A", &id->modified_a, &l->verdicts->modified_a},
                  {"Method B", &id->method_b, &l->verdicts->method_b}};
    for (size_t i = 0; i < sizeof method / sizeof *method; i++) {
        if (!method[i].result->evaluated) continue;
        fprintf(out, "<p>%s: <b>%s</b></p>\n", method[i].name, verdict_names[method[i].verdict->status]);
        verdict_list(out, method[i].verdict);
        fputs("</ul>\n", out);
    }
}

static void verdict_words(FILE *out, const struct identification_log *l) {
    const struct check_params *limit = &l->params->checks;
    const struct verdict *run = &l->verdicts->run;
    html_print(out, "<h3>Checks of the verdict</h3>\n<p>Verdict <b>%s</b>. It is about: %s.</p>\n", verdict_names[run->status], run->scope);
    verdict_list(out, run);
    double overruns_pct = l->loop.cycles > 0 ? 100.0 * (double)l->loop.overruns / (double)l->loop.cycles : 0.0;
    fprintf(out, "<li>%.3f %% of the cycles overran, limit %g %%.</li>\n", overruns_pct, limit->overruns_pct);
    if (l->sinusoids) fprintf(out, "<li>A cycle of %g ms, limit %g ms.</li>\n", 1e3 * l->loop.period_s, 1e3 * limit->period_s);
    if (l->id->method_a.evaluated) {
        int row = 0, column = 0;
        double pct = asymmetry_pct(&l->id->method_a, &row, &column);
        fprintf(out,
                "<li>Method A: Mt(%d,%d) and Mt(%d,%d) differ by %.2f %% of √(Mii Mjj), the most of all; "
                "limit %g %%.</li>\n",
                row, column, column, row, pct, limit->symmetry_pct);
    }
    if (l->id->method_c.matrix.evaluated)
        fprintf(out,
                "<li>Method C scatters by %.2f times its noise: about 1 where the model holds, less with dry friction; where it is more, "
                "its intervals are as much wider, and more than chance allows fails its verdict.</li>\n",
                l->id->method_c.scatter);
    fputs("</ul>\n", out);
    method_verdicts(out, l);
}

static void time_row(FILE *out, const char *name, const double us[4]) {
    html_row(out, "%s|>%.0f|>%.0f|>%.0f|>%.0f", name, us[0], us[1], us[2], us[3]);
}

static void loop_times(FILE *out, const struct loop_statistics *s) {
    fprintf(out, "<h3>The loop</h3>\n<p>%" PRId64 " cycles of %g ms, %" PRId64 " overrun%s, %" PRId64 " record%s lost. ", s->cycles,
            1e3 * s->period_s, s->overruns, s->overruns == 1 ? "" : "s", s->lost, s->lost == 1 ? "" : "s");
    if (!s->timed) {
        fputs("The log has no times of the loop: it is of a run in virtual time, or was imported.</p>\n", out);
        return;
    }
    fprintf(out, "%.3f times real time, %" PRId64 " stall%s of the host", s->pace, s->stalls, s->stalls == 1 ? "" : "s");
    if (s->stalls) fprintf(out, ", the longest %.0f ms", 1e3 * s->longest_stall_s);
    fputs(".</p>\n", out);
    html_table(out, NULL, "µs|>p50|>p99|>p99.9|>max");
    time_row(out, "wake-up after the deadline", s->wake_us);
    time_row(out, "execution, to the command's write", s->exec_us);
    html_table_end(out);
}

static void section_checks(FILE *out, const struct identification_log *l, const char *number) {
    title(out, number, "Checks");
    verdict_words(out, l);
    exclusions(out, l);
    loop_times(out, &l->loop);
    fputs("</section>\n", out);
}

/* --- the sections of a log */

void sections_of_log(struct page *p, const struct identification_report *report, int log) {
    const struct identification_log *l = &report->log[log];
    char number[20] = "";
    if (report->logs > 1) snprintf(number, sizeof number, "Log %d: ", log + 1);
    section_matrices(p->out, l, number);
    section_tests(p, l, number);
    section_friction(p, l, number);
    section_checks(p->out, l, number);
    title(p->out, number, "Configuration");
    html_print(p->out,
               "<details><summary>Everything that the evaluation was configured with</summary>\n<pre>%s</pre></details></section>\n",
               l->config);
}
