#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "html.h"
#include "identification_pictures.h"
#include "identification_sections.h"
#include "identification_tables.h"
#include "page.h"
#include "params.h"

/* September 2001, us since 1970. An earlier time comes from a clock that started at 0 and is not a
 * date. */
static const int64_t DATED_US = 1000000000000000;

static const char *file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* --- facts */

static void fact_file(FILE *out, const struct identification_log *l) { html_print(out, "<code>%s</code>", l->path); }

static void fact_date(FILE *out, const struct identification_log *l) {
    char text[40];
    struct tm tm;
    time_t seconds = (time_t)(l->began_us / 1000000);
    bool dated = l->began_us >= DATED_US && gmtime_r(&seconds, &tm) && strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &tm);
    fputs(dated ? text : "no date: of a run in virtual time", out);
}

/* Writes a value of the legs, "63 mm", or "60 to 63 mm" if they differ. */
static void range(FILE *out, const double value[LEGS], double scale, const char *unit) {
    double least = value[0], most = value[0];
    for (int i = 1; i < LEGS; i++) least = fmin(least, value[i]), most = fmax(most, value[i]);
    if (least < most) html_print(out, "%g to %g %s", scale * least, scale * most, unit);
    else html_print(out, "%g %s", scale * least, unit);
}

static void joints(FILE *out, const char *of, const struct leg_vectors *points, double radius_m) {
    if (points->given) fprintf(out, ", joints of the %s as points", of);
    else fprintf(out, ", joints of the %s on a circle of radius %g m", of, radius_m);
}

static void fact_machine(FILE *out, const struct identification_log *l) {
    const struct geometry_params *g = &l->params->geometry;
    const struct actuator_params *a = &l->params->actuator;
    fputs("six legs", out);
    joints(out, "platform", &g->upper, g->upper_radius_m), joints(out, "base", &g->lower, g->lower_radius_m);
    fprintf(out, ", %g m apart; pistons ", g->height_m), range(out, a->piston_diameter_m, 1e3, "mm");
    fputs(", rods ", out), range(out, a->rod_diameter_m, 1e3, "mm");
    fputs(", stroke ", out), range(out, a->stroke_m, 1.0, "m");
    fprintf(out, "; payload configured with %g kg", l->params->payload.mass_kg);
}

static void fact_motion(FILE *out, const struct identification_log *l) {
    const struct identification *id = l->id;
    if (l->motion.there) html_print(out, "%s, %lld samples", l->motion.name, (long long)l->motion.samples);
    const char *before = l->motion.there ? "; sinusoids of " : "sinusoids of ";
    for (int i = 0; i < id->tests; i++, before = " ") html_print(out, "%s%s", before, dof_names[id->test[i].dof]);
    double low = INFINITY, high = 0.0;
    for (int i = 0; i < id->tests; i++) low = fmin(low, id->test[i].frequency_hz), high = fmax(high, id->test[i].frequency_hz);
    if (id->tests && low == high) html_print(out, " at %g Hz", low);
    else if (id->tests) html_print(out, " at %g to %g Hz", low, high);
    else if (!l->motion.there) fputs("no test", out);
}

static void fact_verdict(FILE *out, const struct identification_log *l) {
    const struct verdict *v = &l->verdicts->run;
    fprintf(out, "<b>%s</b>", verdict_names[v->status]);
    for (int i = 0; i < v->reasons; i++) html_print(out, "<br><span class=\"notice\">%s</span>", v->reason[i]);
}

static void fact_methods(FILE *out, const struct identification_log *l) {
    const struct identification *id = l->id;
    if (id->method_a.evaluated) fputs("A, modified A, B", out);
    else if (id->refuted) fputs("not A and B: the recording contradicts the configured machine", out);
    else fputs(l->sinusoids ? "not A and B: they need complete tests of all six axes" : "not A and B: for one axis after another", out);
    if (id->method_c.matrix.evaluated) fputs(id->method_a.evaluated ? ", C" : "; C", out);
    else html_print(out, "; not C%s%s", id->no_method_c.status ? ": " : "", id->no_method_c.status ? id->no_method_c.text : "");
}

static void facts(FILE *out, const struct identification_report *r) {
    static const struct {
        const char *name;
        void (*write)(FILE *out, const struct identification_log *log);
    } fact[] = {{"log", fact_file},      {"recorded", fact_date},   {"machine", fact_machine},
                {"motion", fact_motion}, {"methods", fact_methods}, {"verdict", fact_verdict}};
    fputs("<div class=\"wide\"><table class=\"facts\">\n", out);
    for (int i = 0; i < r->logs && r->logs > 1; i++) fprintf(out, "%s<th>log %d</th>", i ? "" : "<tr><th></th>", i + 1);
    if (r->logs > 1) fputs("</tr>\n", out);
    for (size_t f = 0; f < sizeof fact / sizeof *fact; f++) {
        fprintf(out, "<tr><th>%s</th>", fact[f].name);
        for (int i = 0; i < r->logs; i++) {
            fputs("<td>", out);
            fact[f].write(out, &r->log[i]);
            fputs("</td>", out);
        }
        fputs("</tr>\n", out);
    }
    html_table_end(out);
}

/* --- first screen */

static void headline(FILE *out, const struct identification_report *r) {
    int passed = 0;
    for (int i = 0; i < r->logs; i++) passed += r->log[i].verdicts->run.status == VERDICT_PASS;
    static const char *const words[] = {[VERDICT_PASS] = "The run passed its checks",
                                        [VERDICT_FAIL] = "The run failed its checks",
                                        [VERDICT_NOT_EVALUATED] = "The run is not evaluated as a whole"};
    fputs("<p class=\"kicker\">Inertia matrix at the neutral pose</p>\n<h1>", out);
    if (r->logs == 1) fputs(words[r->log[0].verdicts->run.status], out);
    else fprintf(out, "%d of %d runs passed their checks", passed, r->logs);
    fputs("</h1>\n<p class=\"lead\">A pass says that the tests were good, not that the machine is as configured: the difference from "
          "the nominal matrix is reported, never judged.</p>\n",
          out);
}

static bool any_entries(const struct identification_report *r, bool *a) {
    bool c = false;
    *a = false;
    for (int i = 0; i < r->logs; i++) *a = *a || r->log[i].id->method_a.evaluated, c = c || r->log[i].id->method_c.matrix.evaluated;
    return *a || c;
}

static void entry_words(FILE *out, const struct identification_report *r, bool a) {
    fputs("<p class=\"small\">Every ± on this page, and every bar in the picture, is a 95 % interval: 1.96 standard deviations to either "
          "side. Below a value its difference from nominal, of a coupling (Mt15 ...) in % of √(Mii Mjj); "
          "<span class=\"off\">orange</span> where the interval does not hold the nominal value. ",
          out);
    if (a) fputs("Of method A (Tian 2015) the interval is the sensors' noise alone: what dry friction does to it is not in there. ", out);
    fputs("Method C takes viscous and dry friction of each leg into the estimate; its matrix is symmetric (Mt42 is Mt24, Mt51 is Mt15). "
          "– : not determined, or not evaluated.",
          out);
    if (r->logs > 1)
        fputs(" σ from log 1: the difference divided by its standard deviation, the root of the sum of both squared ones; by chance "
              "one in twenty is above 2. Nothing is pooled.",
              out);
    fputs("</p>\n", out);
}

static void entries(struct page *p, const struct identification_report *r) {
    bool a, any = any_entries(r, &a), one = r->logs == 1;
    fputs(one ? "<section id=\"entries\"><div class=\"beside\"><div>\n" : "<section id=\"entries\">\n", p->out);
    table_entries(p->out, r);
    if (any) entry_words(p->out, r, a);
    if (one) fputs("</div>\n", p->out);
    if (any)
        page_figure(p, picture_entries, r,
                    "Difference from nominal, in %% of √(Mii Mjj), the two diagonal entries of its row and column. "
                    "Open: method A; filled: method C");
    fputs(one ? "</div></section>\n" : "</section>\n", p->out);
}

static void payload(FILE *out, const struct identification_report *r) {
    fputs("<div id=\"payload\"><h2>Payload</h2>\n<p>What is left of method C's matrix when the legs as configured are taken off, as one "
          "rigid body: the mass centre from where it is configured, the inertia about it (entries of the tensor; "
          "the difference of Ixy in % of √(Ixx Iyy), and so on).</p>\n",
          out);
    if (!table_payload(out, r)) fputs("<p class=\"notice\">Not determined.</p>\n", out);
    for (int i = 0; i < r->logs; i++) {
        const struct payload *found = &r->log[i].id->method_c.payload;
        if (!r->log[i].id->method_c.matrix.evaluated || !found->evaluated || !found->whole || found->possible) continue;
        fputs("<p class=\"notice\">", out);
        if (r->logs > 1) fprintf(out, "Log %d: ", i + 1);
        fputs("No body of positive density has these parameters; <code>hexid identify --json</code> has the nearest that one has.</p>\n",
              out);
    }
    fputs("</div>\n", out);
}

static void friction(FILE *out, const struct identification_report *r) {
    fputs("<div id=\"friction\"><h2>Friction</h2>\n<p>Of each leg by method C. – : not determined.</p>\n", out);
    if (!table_friction(out, r)) fputs("<p class=\"notice\">Not evaluated.</p>\n", out);
    fputs("</div>\n", out);
}

/* Writes the springs (hoses and cables), if the configuration allows any. */
static void springs(FILE *out, const struct identification_report *r) {
    bool asked = false;
    for (int i = 0; i < r->logs; i++) asked = asked || r->log[i].id->method_c.springs;
    if (!asked) return;
    fputs("<div id=\"springs\"><h2>Springs</h2>\n"
          "<p>Hoses and cables that may be there by <code>model.tolerance</code>, by method C. – : not determined; at "
          "one frequency a spring is an inertia of −K/ω².</p>\n",
          out);
    if (!table_springs(out, r)) fputs("<p class=\"notice\">Not determined: record a second frequency.</p>\n", out);
    fputs("</div>\n", out);
}

static void write_page(struct page *p, const void *subject) {
    const struct identification_report *r = subject;
    page_begin(p, "report", NULL);
    for (int i = 0; i < r->logs; i++) html_print(p->out, "%s%s", i ? " " : "", file_name(r->log[i].path));
    html_print(p->out, "</code></span><span>evaluated by hexid %s</span></header>\n", r->version);
    headline(p->out, r);
    facts(p->out, r);
    entries(p, r);
    fputs(r->logs == 1 ? "<section class=\"beside\">\n" : "<section>\n", p->out);
    payload(p->out, r);
    friction(p->out, r);
    springs(p->out, r);
    fputs("</section>\n", p->out);
    for (int i = 0; i < r->logs; i++) sections_of_log(p, r, i);
}

int identification_html(const struct identification_report *report, char **page, struct error *error) {
    return page_make(write_page, report, page, error);
}
