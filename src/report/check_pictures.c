#include "check_pictures.h"

#include <math.h>

#include "check_report.h"
#include "plot.h"

enum { POINTS = 500, WIDTH = 1100, PANEL = 165, HEAD = 22, FOOT = 50, GROUNDS_MOST = 200 };

/* Returns true if a kind of channel has a panel of its own. Without a pose, the reference is a
 * length and is shown in the panel of the length. */
static bool has_panel(const struct survey *s, int kind) {
    return s->channel[kind].there && !(!s->mechanism->pose && kind == SURVEY_REFERENCE && s->channel[SURVEY_LENGTH].there);
}

static double start_s(const struct survey *s) { return s->test.sample[0].test_time_s; }

static double width_s(const struct survey *s) { return fmax(survey_seconds(s), 1e-9); }

/* The first, the last, the least and the greatest value of a channel in one part of the time. There
 * are POINTS parts, or with few samples one for each sample. All are NaN if the part has no
 * value. */
struct ends {
    double first, last, low, high;
};

static void take(struct ends *e, double value) {
    if (!isfinite(value)) return;
    if (isnan(e->first)) e->first = value;
    e->last = value, e->low = fmin(e->low, value), e->high = fmax(e->high, value);
}

static void write_row(FILE *script, double t_s, const struct ends *ends, int count, bool second) {
    fprintf(script, "%.7g", t_s);
    for (int k = 0; k < count; k++) {
        bool rises = ends[k].last >= ends[k].first;
        if (isnan(ends[k].first)) fputs(" NaN", script);
        else fprintf(script, " %.6g", rises == second ? ends[k].high : ends[k].low);
    }
    fputc('\n', script);
}

/* Writes the data of a kind in columns: time, then each channel. With at most 2 * POINTS samples
 * there is one row for each sample. With more, the time is divided into POINTS parts with two rows
 * each, minimum and maximum, and a part without samples leaves a gap. */
static void write_data(FILE *script, const struct survey *s, enum survey_kind kind) {
    const struct recording_test *t = &s->test;
    int count = s->channel[kind].of;
    bool dense = t->count > 2 * POINTS;
    fprintf(script, "$%s << EOD\n", survey_names[kind]);
    for (int point = 0, i = 0; point < POINTS && i < t->count; point++) {
        double until_s = point == POINTS - 1 ? HUGE_VAL : start_s(s) + width_s(s) * (point + 1) / POINTS;
        struct ends ends[LEGS];
        int first = i;
        for (int k = 0; k < LEGS; k++) ends[k] = (struct ends){(double)NAN, (double)NAN, (double)NAN, (double)NAN};
        for (; i < t->count && t->sample[i].test_time_s < until_s; i++) {
            for (int k = 0; k < count; k++) take(&ends[k], check_units[kind].scale * survey_value(&t->sample[i], kind, k));
            if (dense) continue;
            write_row(script, t->sample[i].test_time_s, ends, count, true);
            for (int k = 0; k < count; k++) ends[k] = (struct ends){(double)NAN, (double)NAN, (double)NAN, (double)NAN};
        }
        if (dense && i == first) fputc('\n', script);
        if (!dense || i == first) continue;
        write_row(script, t->sample[first].test_time_s, ends, count, false);
        write_row(script, t->sample[i - 1].test_time_s, ends, count, true);
    }
    fputs("EOD\n", script);
}

static void write_grounds(FILE *script, const struct survey *s) {
    static const char *const ground[SEGMENT_KINDS] = {[SEGMENT_REST] = "#ededed", [SEGMENT_STEADY] = "#dcebf5"};
    int drawn = 0;
    for (const struct segment *p = s->segments.segment; p < s->segments.segment + s->segments.count && drawn < GROUNDS_MOST; p++) {
        if (!ground[p->kind]) continue;
        fprintf(script, "set object rectangle from first %.7g, graph 0 to first %.7g, graph 1 fc rgb '%s' fs solid noborder behind\n",
                s->test.sample[p->first].test_time_s, s->test.sample[p->end - 1].test_time_s, ground[p->kind]);
        drawn++;
    }
}

/* Labels the longer segments of rest and steady motion, above the first panel and below the key.
 * at: height of the labels, as a share of the picture's height. */
static void write_labels(FILE *script, const struct survey *s, double at) {
    int drawn = 0;
    for (const struct segment *p = s->segments.segment; p < s->segments.segment + s->segments.count && drawn < GROUNDS_MOST; p++) {
        double from_s = s->test.sample[p->first].test_time_s, until_s = s->test.sample[p->end - 1].test_time_s;
        if (p->kind == SEGMENT_MOVING || !(until_s - from_s > 0.08 * width_s(s))) continue;
        fprintf(script, "set label at first %.7g, screen %.4f center front tc rgb '#444444' '", 0.5 * (from_s + until_s), at);
        if (p->kind == SEGMENT_STEADY) fprintf(script, "steady, %.5g Hz'\n", p->frequency_hz);
        else fprintf(script, "%s'\n", segment_names[p->kind]);
        drawn++;
    }
}

static void channel_name(char name[16], const struct survey *s, enum survey_kind kind, int k) {
    if (s->mechanism->legs == 1) snprintf(name, 16, "%s", check_name_of(s, kind));
    else if (kind == SURVEY_REFERENCE) snprintf(name, 16, "%s", dof_names[k]);
    else snprintf(name, 16, "leg %d", k + 1);
}

static void plot_channels(FILE *script, const struct survey *s, enum survey_kind kind) {
    const struct survey_channel *c = &s->channel[kind];
    const char *before = "plot";
    for (int k = 0; k < c->of; k++) {
        char name[16];
        if (!(c->there >> k & 1u)) continue;
        channel_name(name, s, kind, k);
        fprintf(script, "%s $%s using 1:%d with lines lw 1.3 lc rgb '%s' title '%s'", before, survey_names[kind], k + 2, plot_colours[k],
                name);
        before = ",";
    }
    if (!s->mechanism->pose && kind == SURVEY_LENGTH && s->channel[SURVEY_REFERENCE].there)
        fputs(", $reference using 1:2 with lines lw 1.2 dt (6,4) lc rgb '#1a1a1a' title 'reference'", script);
    fputc('\n', script);
}

void check_picture(FILE *script, const void *survey) {
    const struct survey *s = survey;
    int panels = 0, panel = 0;
    if (!s->test.count) return;
    for (int kind = 0; kind < SURVEY_KINDS; kind++) panels += has_panel(s, kind);
    int height = HEAD + panels * PANEL + FOOT;
    plot_begin(script, WIDTH, height);
    for (int kind = 0; kind < SURVEY_KINDS; kind++)
        if (s->channel[kind].there) write_data(script, s, (enum survey_kind)kind);
    plot_panels(script, 0.085, start_s(s), start_s(s) + width_s(s));
    fputs("set offsets 0,0,graph 0.05,graph 0.05\nset datafile missing 'NaN'\n", script);
    write_grounds(script, s);
    for (int kind = 0; kind < SURVEY_KINDS; kind++) {
        if (!has_panel(s, kind)) continue;
        double top = height - HEAD - panel * PANEL;
        char label[40];
        snprintf(label, sizeof label, "%s [%s]", check_name_of(s, (enum survey_kind)kind), check_unit_of(s, (enum survey_kind)kind));
        plot_panel(script, (top - HEAD) / height, (top - PANEL + 8) / height, ++panel == panels ? "time of the test [s]" : NULL, label);
        fprintf(script, "set key at screen 0.98, screen %.5f right top horizontal\n", (panel == 1 ? height - 2.0 : top) / height);
        if (panel == 1) write_labels(script, s, (top - 0.45 * HEAD) / height);
        if (panel > 1 && kind != SURVEY_REFERENCE) fputs("unset key\n", script);
        plot_channels(script, s, (enum survey_kind)kind);
        if (panel == 1) fputs("unset label\n", script);
    }
}
