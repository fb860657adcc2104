#include "terminal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"
#include "failure.h"
#include "mechanism.h"
#include "messages.h"
#include "progress.h"
#include "units.h"
#include "words.h"

enum { REDRAW_MS = 200, LINE_MS = 1000, BAR = 11 };

static void erase(struct terminal *t) {
    if (t->drawn) printf("\033[%dA\r\033[J", t->drawn);
    if (t->drawn) t->drawn_ms = 0;
    t->drawn = 0;
}

/* Rounds to a multiple of the unit; + 0.0 turns -0.0 into 0.0, so that "-0.00" is never printed. */
static double rounded(double x, double unit) { return round(x / unit) * unit + 0.0; }

static void headline(const struct cycle *c) {
    char fault[FAULT_TEXT_SIZE];
    fault_describe(c->first_fault, c->faults, fault);
    printf("%9.3f s  %-12s  %-5s %-8s  fault %s", seconds_from_ns(c->in.time_ns), state_names[c->state],
           c->dof >= 0    ? dof_names[c->dof]
           : c->test >= 0 ? "any"
                          : "",
           progress_phases[c->phase], fault);
}

static void pose(const struct params *p, const struct cycle *c) {
    /* units, each printed once, after the last value that has it */
    static const char *const units[DOFS] = {"", "", " mm", "", "", " mrad"};
    const struct mechanism *mechanism = params_mechanism(p);
    if (!mechanism->pose) printf(" %s %.2f mm", mechanism->words.length, rounded(c->in.length_m[0] * 1e3, 0.01));
    for (int i = 0; i < DOFS && mechanism->pose; i++) printf(" %s %.2f%s", dof_names[i], rounded(c->pose[i] * 1e3, 0.01), units[i]);
}

/* Draws a bar from the middle; with a share of 1 or -1 it reaches the right or the left end. */
static const char *bar(double share, char text[BAR + 1]) {
    int half = BAR / 2, marks = isfinite(share) ? (int)round(fmin(fabs(share), 1.0) * half) : 0;
    memset(text, ' ', BAR);
    text[BAR] = '\0';
    memset(text + (share < 0.0 ? half - marks : half), '#', (size_t)marks + 1);
    text[half] = '|';
    return text;
}

/* Enlarges the full scale of the force bars to 1, 2 or 5 times a power of ten, at least 100 N, if a
 * force exceeds it. It never shrinks, so that bars stay comparable. */
static void enlarge(struct terminal *t, const struct cycle *c) {
    static const double least_n = 100.0;
    double most_n = least_n;
    for (int i = 0; i < params_legs(t->params); i++) most_n = fmax(most_n, fabs(c->force_n[i]));
    if (most_n <= t->force_n || !isfinite(most_n)) return;
    double ten = pow(10.0, floor(log10(most_n)));
    t->force_n = ten * (most_n <= ten ? 1.0 : most_n <= 2.0 * ten ? 2.0 : most_n <= 5.0 * ten ? 5.0 : 10.0);
}

static void leg(const struct terminal *t, const struct cycle *c, int i) {
    char force[BAR + 1], valve[BAR + 1];
    words_row(stdout, "  %-2.0d %8.5f %8.3f %8.3f %8.1f [%s] %+8.3f [%s]\n", params_legs(t->params) > 1 ? i + 1 : 0, c->in.length_m[i],
              c->in.p1_pa[i] * 1e-6, c->in.p2_pa[i] * 1e-6, c->force_n[i], bar(c->force_n[i] / t->force_n, force), c->out.valve[i],
              bar(c->out.valve[i], valve));
}

int terminal_view(struct terminal *t, const struct cycle *c) {
    int legs = params_legs(t->params);
    enlarge(t, c);
    headline(c);
    printf("\n    ");
    pose(t->params, c);
    printf("\n  %-3s length m   P1 MPa   P2 MPa  force N  +-%-11.6g valve  +-1\n", legs > 1 ? "leg" : "", t->force_n);
    for (int i = 0; i < legs; i++) leg(t, c, i);
    return 3 + legs;
}

static void take_state(struct terminal *t, const struct cycle *c, int64_t now_ms) {
    if (t->drawn_ms && now_ms - t->drawn_ms < (t->redraws ? REDRAW_MS : LINE_MS)) return;
    erase(t);
    t->drawn_ms = now_ms;
    if (t->redraws) t->drawn = terminal_view(t, c);
    else {
        headline(c);
        printf(" ");
        pose(t->params, c);
        printf("\n");
    }
}

static void test_result(const void *data, int size) {
    struct test_summary t;
    if (!test_result_decode(data, size, &t)) return;
    cli_say(stdout, "             result %s: amplitude %.4g of %.4g, phase %.1f deg, %lld samples, %lld excluded", t.dof_name,
            t.achieved_m_or_rad, t.amplitude_m_or_rad, t.phase_deg, (long long)t.samples, (long long)t.excluded);
}

static void gap_result(const void *data, int size) {
    struct gap_summary g;
    if (!gap_decode(data, size, &g)) return;
    cli_say(stdout, "             gap %s: %s; %.3g -> %.3g of the variation, noise %.3g", g.verdict, g.reason, g.held_out_before_ratio,
            g.held_out_after_ratio, g.noise_floor_ratio);
}

void terminal_take(struct terminal *t, const struct bus_message *m, int64_t now_ms) {
    struct cycle c;
    struct event e;
    if (!strcmp(m->channel, CHANNEL_STATE)) {
        if (state_decode(m->data, m->size, &c)) take_state(t, &c, now_ms);
    } else if (!strcmp(m->channel, CHANNEL_EVENT) && event_decode(m->data, m->size, &e)) {
        erase(t);
        if (strcmp(e.kind, "config") != 0) cli_say(stdout, "%9.3f s  %s: %s", seconds_from_ns(e.time_ns), e.kind, e.text);
    } else if (!strcmp(m->channel, CHANNEL_TEST_RESULT)) {
        erase(t);
        test_result(m->data, m->size);
    } else if (!strcmp(m->channel, CHANNEL_IDENTIFICATION)) {
        erase(t);
        printf("             %s: the matrices; --json and --http show them\n", m->channel);
    } else if (!strcmp(m->channel, CHANNEL_GAP)) {
        erase(t);
        gap_result(m->data, m->size);
    }
    fflush(stdout);
}

void terminal_say(struct terminal *t, const char *line) {
    erase(t);
    fflush(stdout);
    fprintf(stderr, "hexid: %s\n", line);
}
