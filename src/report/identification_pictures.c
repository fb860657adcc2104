#include "identification_pictures.h"

#include <math.h>
#include <string.h>

#include "kinematics.h"
#include "numeric.h"
#include "plot.h"
#include "units.h"

enum { TEST_POINTS = 180, PERIODS = 3, SEGMENTS = 6, FRICTION_TESTS = 12, FRICTION_STEP = 2 };

/* --- entries */

/* Results of one method for one log. */
struct series {
    const struct identification_log *log;
    const struct method_result *method;
    const char *name, *colour;
    int place;
};

static int list_series(const struct identification_report *r, struct series series[2 * REPORT_LOGS]) {
    int count = 0;
    for (int method = 0; method < 2; method++)
        for (int i = 0; i < r->logs; i++) {
            const struct identification *id = r->log[i].id;
            const struct method_result *m = method ? &id->method_c.matrix : &id->method_a;
            const char *colour = r->logs > 1 ? plot_colours[i] : method ? PICTURE_ACCENT : "#1a1a1a";
            if (m->evaluated) series[count++] = (struct series){&r->log[i], m, method ? "C" : "A", colour, i};
        }
    return count;
}

static void series_data(FILE *script, const struct series *s, int number, double offset) {
    fprintf(script, "$s%d << EOD\n", number);
    for (int i = 0; i < IDENT_ENTRIES; i++) {
        int row = ident_entries[i].row, column = ident_entries[i].col;
        const struct identification *id = s->log->id;
        double scale = 100.0 / sqrt(id->nominal_mt[row][row] * id->nominal_mt[column][column]);
        double difference = s->method->mt[row][column] - id->nominal_mt[row][column];
        if (isfinite(difference))
            fprintf(script, "%g %g %g\n", scale * difference, i + offset, scale * NUMERIC_95 * s->method->mt_std[row][column]);
    }
    fputs("EOD\n", script);
}

void picture_entries(FILE *script, const void *subject) {
    const struct identification_report *r = subject;
    struct series series[2 * REPORT_LOGS];
    int count = list_series(r, series), rows = (count + 1) / 2, step = 10 * count + 8 > 30 ? 10 * count + 8 : 30;
    plot_begin(script, 560, IDENT_ENTRIES * step + 60 + 18 * rows);
    for (int i = 0; i < count; i++) series_data(script, &series[i], i, (i - 0.5 * (count - 1)) * 10.0 / step);
    fprintf(script, "set yrange [%g:-0.6]\nset ytics (", IDENT_ENTRIES - 0.4);
    for (int i = 0; i < IDENT_ENTRIES; i++) fprintf(script, "%s'%s' %d", i ? ", " : "", ident_entries[i].name, i);
    fputs(")\nset xlabel 'difference from nominal [% of √(Mii Mjj)]' offset 0,0.3\n"
          "set arrow from 0, graph 0 to 0, graph 1 nohead lc rgb '#777777' lw 1 back\nset offsets graph 0.03, graph 0.03, 0, 0\n"
          "set bars 0.5\nset key maxcols 2 reverse Left\nplot ",
          script);
    for (int i = 0; i < count; i++) {
        fprintf(script, "%s$s%d using 1:2:3 with xerrorbars pt %d ps 0.7 lw 1.4 lc rgb '%s' title '", i ? ", " : "", i,
                series[i].name[0] == 'C' ? 7 : 6, series[i].colour);
        if (r->logs > 1) fprintf(script, "log %d, ", series[i].place + 1);
        fprintf(script, "method %s'", series[i].name);
    }
    fputc('\n', script);
}

/* --- a test */

struct picture_test picture_of_test(const struct identification_log *log, int test) {
    const struct recording *r = log->recording;
    const struct recording_test *t = &r->test[test];
    double from_s = t->sample[t->first].test_time_s, span_s = t->sample[t->end - 1].test_time_s - from_s;
    int segments = 1;
    if (!(t->segment_s > 0.0)) return (struct picture_test){log, test, from_s, fmin(PERIODS / t->frequency_hz, span_s)};
    while (test + segments < r->tests && r->test[test + segments].sample == t->sample) segments++;
    int middle = segments > SEGMENTS ? (segments - SEGMENTS) / 2 : 0;
    return (struct picture_test){log, test, r->test[test + middle].start_s, SEGMENTS * t->segment_s};
}

enum { POSE_COLUMN = 2, REF_COLUMN = POSE_COLUMN + DOFS, FORCE_COLUMN = REF_COLUMN + DOFS };

static void test_row(FILE *script, const struct recording_sample *s, const double pose[DOFS], bool known) {
    fprintf(script, "%.6g", s->test_time_s);
    for (int i = 0; i < DOFS; i++) fprintf(script, " %.5g", known ? 1e3 * pose[i] : (double)NAN);
    for (int i = 0; i < DOFS; i++) fprintf(script, " %.5g", 1e3 * s->ref[i]);
    for (int i = 0; i < LEGS; i++) fprintf(script, " %.5g", known ? s->force_n[i] : (double)NAN);
    fputc('\n', script);
}

/* Writes columns: time in s; pose and reference in mm and mrad; forces in N. Excluded samples, and
 * samples with lengths that no pose has, leave a gap in pose and forces. */
static void test_data(FILE *script, const struct picture_test *p, const struct kinematics *k) {
    const struct recording_test *t = &p->log->recording->test[p->test];
    double pose[DOFS] = {0};
    int first = t->first;
    while (first < t->count - 1 && t->sample[first].test_time_s < p->from_s) first++;
    int end = first;
    while (end < t->count && t->sample[end].test_time_s <= p->from_s + p->seconds) end++;
    int step = (end - first + TEST_POINTS - 1) / TEST_POINTS;
    fputs("$data << EOD\n", script);
    for (int i = first; i < end; i += step) {
        const struct recording_sample *s = &t->sample[i];
        test_row(script, s, pose, !s->refused && fk_solve(k, s->length_m, pose).converged);
    }
    fputs("EOD\n", script);
}

/* Begins panel `number`, 0 at the top, with one line for its key above it. */
static void panel(FILE *script, int number, int panels, const char *label) {
    double height = (1.0 - 0.27 / panels) / panels, top = 1.0 - number * height, key = 0.16 / panels;
    plot_panel(script, top - key, top - height + 0.02, number == panels - 1 ? "time of the test [s]" : NULL, label);
    fprintf(script, "set key at screen 0.98, screen %.4f right top horizontal\n", top - 0.005);
}

static void plot_poses(FILE *script, const struct picture_test *p, enum dof first, enum dof last) {
    bool reference = p->log->recording->measured.reference, one = first == last;
    const char *before = "plot";
    for (int i = (int)first; i <= (int)last; i++, before = ",") {
        const char *colour = one ? "#1a1a1a" : plot_colours[i % 3];
        fprintf(script, "%s $data using 1:%d with lines lw 1.8 lc rgb '%s' title '%s%s'", before, POSE_COLUMN + i, colour, dof_names[i],
                one ? " measured" : "");
        if (!reference) continue;
        fprintf(script, ", $data using 1:%d with lines lw 1.4 dt (6,4) lc rgb '%s' %s", REF_COLUMN + i, one ? "#8a8a8a" : colour,
                one ? "title 'reference'" : "notitle");
    }
    fputc('\n', script);
}

static void plot_forces(FILE *script) {
    for (int i = 0; i < LEGS; i++)
        fprintf(script, "%s $data using 1:%d with lines lw 1.3 lc rgb '%s' title '%s%d'", i ? "," : "plot", FORCE_COLUMN + i,
                plot_colours[i], i ? "" : "leg ", i + 1);
    fputc('\n', script);
}

void picture_test(FILE *script, const void *subject) {
    const struct picture_test *p = subject;
    const struct recording_test *t = &p->log->recording->test[p->test];
    struct kinematics k;
    struct error error;
    int axis = t->dof != DOF_NONE, panels = axis ? 2 : 3;
    plot_begin(script, 540, axis ? 380 : 520);
    /* gnuplot draws nothing from the lines of plot_begin() alone, which counts as a failed picture
     * (page_figure()) */
    if (kinematics_init(&k, p->log->params, &error)) return;
    test_data(script, p, &k);
    plot_panels(script, 0.13, p->from_s, p->from_s + p->seconds);
    fputs("set offsets 0,0,graph 0.05,graph 0.05\nset key samplen 1 maxrows 1\n", script);
    if (axis) {
        panel(script, 0, panels, t->dof < DOF_PHI ? "position [mm]" : "position [mrad]");
        plot_poses(script, p, t->dof, t->dof);
    } else {
        panel(script, 0, panels, "position [mm]");
        plot_poses(script, p, DOF_X, DOF_Z);
        panel(script, 1, panels, "angle [mrad]");
        plot_poses(script, p, DOF_PHI, DOF_PSI);
    }
    panel(script, panels - 1, panels, "leg force [N]");
    plot_forces(script);
}

/* --- friction */

static void friction_data(FILE *script, const struct leg_friction_test *t, int leg) {
    int count = t->cycle ? t->points + 1 : t->points;
    for (int i = 0; i < count; i += FRICTION_STEP)
        fprintf(script, "%.4g %.4g\n", 1e3 * t->rate_mps[leg][i % t->points], t->force_n[leg][i % t->points]);
    fputc('\n', script);
}

/* Finds the largest rate and the largest force of all legs. */
static void friction_range(const struct leg_friction *f, double *rate_mps, double *force_n) {
    *rate_mps = *force_n = 0.0;
    for (int i = 0; i < f->tests; i++)
        for (int k = 0; k < LEGS; k++)
            for (int j = 0; j < f->test[i].points; j++) {
                *rate_mps = fmax(*rate_mps, fabs(f->test[i].rate_mps[k][j]));
                *force_n = fmax(*force_n, fabs(f->test[i].force_n[k][j]));
            }
}

void picture_friction(FILE *script, const void *subject) {
    const struct picture_friction *p = subject;
    const struct method_c *c = p->found;
    double rate_mps, force_n, b = c->viscous[p->leg], extend = c->dry[p->leg][0], retract = c->dry[p->leg][1];
    int step = (p->measured->tests + FRICTION_TESTS - 1) / FRICTION_TESTS;
    bool found = isfinite(b) && isfinite(extend) && isfinite(retract);
    friction_range(p->measured, &rate_mps, &force_n);
    plot_begin(script, 372, 290);
    fputs("$data << EOD\n", script);
    for (int i = 0; i < p->measured->tests; i += step) friction_data(script, &p->measured->test[i], p->leg);
    fputs("EOD\n", script);
    if (found)
        fprintf(script, "$found << EOD\n%.5g %.5g\n0 %.5g\n\n0 %.5g\n%.5g %.5g\nEOD\n", -1e3 * rate_mps, -b * rate_mps - retract, -retract,
                extend, 1e3 * rate_mps, b * rate_mps + extend);
    fprintf(script, "set xrange [%.4g:%.4g]\nset yrange [%.4g:%.4g]\nset xzeroaxis lc rgb '#bbbbbb'\nset yzeroaxis lc rgb '#bbbbbb'\n",
            -1.05e3 * rate_mps, 1.05e3 * rate_mps, -1.1 * force_n - 1.0, 1.1 * force_n + 1.0);
    plot_axes(script, "leg rate [mm/s]", "friction [N]");
    fputs("plot $data using 1:2 with lines lw 1 lc rgb '#8a8a8a' title 'measured'", script);
    if (found) fputs(", $found using 1:2 with lines lw 2.4 lc rgb '" PICTURE_ACCENT "' title 'method C'", script);
    fputc('\n', script);
}
