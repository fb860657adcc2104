#include <math.h>
#include <string.h>

#include "check_report.h"
#include "printable.h"
#include "words.h"

enum { NAME_COLUMNS = 16, SEGMENTS_SHOWN = 12, LINE = 2400 };

const struct check_unit check_units[SURVEY_KINDS] = {
    [SURVEY_LENGTH] = {1e3, "mm"}, [SURVEY_REFERENCE] = {1e3, "mm, mrad"}, [SURVEY_P1] = {1e-6, "MPa"}, [SURVEY_P2] = {1e-6, "MPa"},
    [SURVEY_FORCE] = {1.0, "N"},   [SURVEY_COMMAND] = {1e2, "%"},
};

const char *check_name_of(const struct survey *s, enum survey_kind kind) {
    return kind == SURVEY_LENGTH ? s->mechanism->words.length : survey_names[kind];
}

const char *check_unit_of(const struct survey *s, enum survey_kind kind) {
    return check_units[!s->mechanism->pose && kind == SURVEY_REFERENCE ? SURVEY_LENGTH : kind].unit;
}

const char *check_amplitude_unit(const struct survey *s) { return s->test.dof >= DOF_PHI ? "mrad" : "mm"; }

double check_jitter_ms(const struct survey *s) { return 1e-3 * round(1e6 * s->sampling.jitter_s); }

const char *check_answer_joint(const struct error *e) { return !e->text[0] ? "" : e->status ? ": " : ", with the "; }

void check_ramp(const struct survey *s, char text[CHECK_RAMP_SIZE]) {
    text[0] = '\0';
    if (isfinite(s->ramp_least_s))
        snprintf(text, CHECK_RAMP_SIZE,
                 "the evaluated part begins at %.3g s, before the motion is steady, from %.3g s on: ramp_s must be at least %.1f",
                 s->test.sample[s->evaluated].test_time_s, s->steady_s, ceil(10.0 * s->ramp_least_s) / 10.0);
}

/* Prints a name in NAME_COLUMNS columns; a longer one is cut. */
static void print_name(FILE *out, const char *name) {
    char text[SURVEY_NAME];
    size_t length = text_printable(name, text, sizeof text), shown = 0, columns = 0;
    for (; shown < length && (columns < NAME_COLUMNS || (text[shown] & 0xc0) == 0x80); shown++) columns += (text[shown] & 0xc0) != 0x80;
    fprintf(out, "  %.*s%*s", (int)shown, text, (int)(NAME_COLUMNS - columns), "");
}

static void print_tests(FILE *out, const struct check_report *r) {
    fprintf(out, "  %-*s%-6s%11s%13s%13s%12s\n", NAME_COLUMNS, "test", "axis", "stated Hz", "measured Hz", "amplitude", "seconds");
    for (const struct survey *s = r->survey; s < r->survey + r->surveys; s++) {
        print_name(out, s->name);
        words_row(out, "%-6s%11.5g%13.6g%8.4g %-4s%12.5g\n", s->test.dof == DOF_NONE ? "none" : dof_names[s->test.dof], s->stated_hz,
                  s->measured_hz, 1e3 * s->amplitude, check_amplitude_unit(s), survey_seconds(s));
    }
}

static void print_sampling(FILE *out, const struct check_report *r) {
    fprintf(out, "\n  %-*s%9s%10s%11s%7s%10s%7s%8s\n", NAME_COLUMNS, "test", "rows", "rate Hz", "jitter ms", "lost", "gap ms", "flags",
            "no num.");
    for (const struct survey *s = r->survey; s < r->survey + r->surveys; s++) {
        print_name(out, s->name);
        words_row(out, "%9d%10.6g%11.2g%7.6g%10.4g%7d%8d\n", s->test.count, 1.0 / s->sampling.step_s, check_jitter_ms(s),
                  (double)s->sampling.lost, 1e3 * s->sampling.gap_s, s->flagged, s->not_a_number);
        if (s->unplaced) fprintf(out, "    %d more rows excluded: %s\n", s->unplaced, refusals[REFUSED_UNPLACED].why);
    }
}

static double segment_seconds(const struct survey *s, const struct segment *p) {
    return s->test.sample[p->end - 1].test_time_s - s->test.sample[p->first].test_time_s + s->sampling.step_s;
}

static void print_segments(FILE *out, const struct survey *s) {
    char text[LINE] = "", name[SURVEY_NAME], label[SURVEY_NAME + 4];
    size_t used = 0;
    for (int i = 0; i < s->segments.count && i < SEGMENTS_SHOWN; i++) {
        const struct segment *p = &s->segments.segment[i];
        used += (size_t)snprintf(text + used, LINE - used, "%s%s %.3g s", used ? ", " : "", segment_names[p->kind], segment_seconds(s, p));
        if (p->kind == SEGMENT_STEADY) used += (size_t)snprintf(text + used, LINE - used, " at %.6g Hz", p->frequency_hz);
    }
    if (s->segments.count > SEGMENTS_SHOWN)
        snprintf(text + used, LINE - used, ", and %d more, %.4g s in all", s->segments.count - SEGMENTS_SHOWN,
                 survey_seconds(s) -
                     (s->test.sample[s->segments.segment[SEGMENTS_SHOWN].first].test_time_s - s->test.sample[0].test_time_s));
    text_printable(s->name, name, sizeof name);
    snprintf(label, sizeof label, "  %s:", name);
    words_print(out, label, text);
}

/* Merges a kind of channel over all tests: widest range, largest noise, smallest step. */
static struct survey_channel all_of(const struct check_report *r, enum survey_kind kind) {
    struct survey_channel all = r->survey[0].channel[kind];
    for (int i = 1; i < r->surveys; i++) {
        const struct survey_channel *c = &r->survey[i].channel[kind];
        all.of = c->of > all.of ? c->of : all.of;
        all.there |= c->there;
        all.low = fmin(all.low, c->low), all.high = fmax(all.high, c->high), all.noise = fmax(all.noise, c->noise);
        if (c->step > 0.0) all.step = all.step > 0.0 ? fmin(all.step, c->step) : c->step;
    }
    return all;
}

static void print_channels(FILE *out, const struct check_report *r) {
    fprintf(out, "\n  %-*s%-8s%12s%12s%12s%10s\n", NAME_COLUMNS - 4, "channel", "present", "minimum", "maximum", "noise rms", "step");
    for (int kind = 0; kind < SURVEY_KINDS; kind++) {
        struct survey_channel c = all_of(r, (enum survey_kind)kind);
        const struct check_unit *u = &check_units[kind];
        if (!c.of) continue;
        int there = __builtin_popcount(c.there);
        fprintf(out, "  %-*s", NAME_COLUMNS - 4, check_name_of(r->survey, (enum survey_kind)kind));
        if (!there) fputs("none\n", out);
        else
            words_row(out, "%d of %d  %12.6g%12.6g%12.3g%10.3g %s\n", there, c.of, u->scale * c.low, u->scale * c.high, u->scale * c.noise,
                      c.step > 0.0 ? u->scale * c.step : (double)NAN, check_unit_of(r->survey, (enum survey_kind)kind));
    }
}

static void print_fault(FILE *out, const struct survey *s, const char *text) {
    char name[SURVEY_NAME], label[SURVEY_NAME];
    snprintf(name, sizeof name, "  ! %.200s:", s->name);
    text_printable(name, label, sizeof label);
    words_print(out, label, text);
}

/* Prints a test's faults, such as "p1 of leg 2 never changes". */
static void print_faults(FILE *out, const struct survey *s) {
    char text[LINE], ramp[CHECK_RAMP_SIZE];
    check_ramp(s, ramp);
    if (*ramp) print_fault(out, s, ramp);
    for (int kind = 0; kind < SURVEY_KINDS; kind++)
        for (int i = 0; i < s->channel[kind].of; i++) {
            bool dead = s->channel[kind].dead >> i & 1u, clipped = s->channel[kind].clipped >> i & 1u;
            if (!dead && !clipped) continue;
            char leg[20] = "";
            if (s->mechanism->legs > 1) snprintf(leg, sizeof leg, " of leg %d", i + 1);
            snprintf(text, sizeof text, "%s%s %s", survey_names[kind], leg,
                     dead ? "never changes: dead, or not connected" : "is clipped: it stays at the end of what it reads");
            print_fault(out, s, text);
        }
}

static void print_list(FILE *out, const char *label, const char *words) {
    char text[LINE];
    text_printable(words, text, sizeof text);
    if (*text) words_print(out, label, text);
}

static void print_answer(FILE *out, const char *label, const struct error *e) {
    char text[LINE];
    snprintf(text, sizeof text, "would %s%s%s", e->status ? "refuse it" : "take it", check_answer_joint(e), e->text);
    print_list(out, label, text);
}

void check_text_print(FILE *out, const struct check_report *r) {
    char excluded[LINE];
    snprintf(excluded, sizeof excluded, "  ! hexid gap excludes, because %s:", refusals[REFUSED_EMPTY].why);
    fputc('\n', out);
    print_tests(out, r);
    print_sampling(out, r);
    fputs("\n", out);
    for (int i = 0; i < r->surveys; i++) print_segments(out, &r->survey[i]);
    print_channels(out, r);
    fputs("\n", out);
    for (int i = 0; i < r->surveys; i++) print_faults(out, &r->survey[i]);
    print_list(out, "  t = 0, found by the motion, at t_s =", r->zero);
    print_list(out, excluded, r->left_out);
    print_list(out, "  missing columns:", r->missing);
    print_list(out, "  areas of the pressures:", r->areas);
    print_list(out, "  as in the default configuration:", r->defaults);
    print_list(out, "  ! another unit?", r->doubtful);
    print_list(out, "  not understood and left out:", r->ignored);
    print_answer(out, "  hexid identify", &r->identify);
    print_answer(out, "  hexid gap", &r->gap);
}
