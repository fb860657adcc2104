#include "witness.h"

#include <math.h>
#include <string.h>

#include "units.h"

enum { BLOCK_SAMPLES = 100 };
/* A block is whole without a gap. A gap is longer than this share of the motion's period, over
 * which a line between two samples is off by at most 2 % of the amplitude, and than this number of
 * the shortest steps, or than a quarter of the period. */
static const double GAP_PERIODS = 1.0 / 16.0, GAP_STEPS = 2.5, GAP_MOST = 0.25;
enum { MEAN, SINE };

static void wander_reset(struct wander *w) {
    *w = (struct wander){0};
    for (int k = 0; k < WITNESS_TERMS; k++) w->low[k] = INFINITY, w->high[k] = -INFINITY;
}

static void base_at(const struct witness *w, double since_s, double base[WITNESS_TERMS]) {
    base[0] = 1.0, base[1] = sin(w->omega * since_s), base[2] = cos(w->omega * since_s);
}

void witness_reset(struct witness *w, double frequency_hz, double period_s, const bool moves[LEGS]) {
    double periods = fmax(1.0, ceil(BLOCK_SAMPLES * period_s * frequency_hz));
    *w = (struct witness){.omega = 2.0 * PI * frequency_hz, .block_s = periods / frequency_hz, .whole = true, .shortest_s = INFINITY};
    base_at(w, 0.0, w->base);
    memcpy(w->moves, moves, sizeof w->moves);
    for (int i = 0; i < LEGS; i++) wander_reset(&w->length[i]), wander_reset(&w->force[i]);
}

/* Integrates over step_s, in which a signal goes from its last value to `value`. from, to: the
 * terms' functions at the step's ends. */
static void wander_add(struct wander *w, double step_s, const double from[WITNESS_TERMS], const double to[WITNESS_TERMS], double value) {
    for (int k = 0; k < WITNESS_TERMS; k++) w->sum[k] += 0.5 * step_s * (from[k] * w->value + to[k] * value);
    w->value = value;
}

static void wander_close(struct wander *w, double block_s, bool whole) {
    for (int k = 0; k < WITNESS_TERMS; k++) {
        double term = (k ? 2.0 : 1.0) * w->sum[k] / block_s;
        if (whole) w->low[k] = fmin(w->low[k], term), w->high[k] = fmax(w->high[k], term);
        w->sum[k] = 0.0;
    }
    w->begin = w->value;
}

static void add_all(struct witness *w, double to_s, const double length_m[LEGS], const double force_n[LEGS]) {
    double to[WITNESS_TERMS], step_s = to_s - w->last_s;
    base_at(w, to_s, to);
    for (int i = 0; i < LEGS; i++) {
        wander_add(&w->length[i], step_s, w->base, to, length_m[i]);
        wander_add(&w->force[i], step_s, w->base, to, force_n[i]);
    }
    memcpy(w->base, to, sizeof w->base);
    w->last_s = to_s;
}

/* Ends the block under way and begins the next one. A block that is not whole does not count,
 * because its mean would contain part of the motion. */
static void close_block(struct witness *w) {
    for (int i = 0; i < LEGS; i++) wander_close(&w->length[i], w->block_s, w->whole), wander_close(&w->force[i], w->block_s, w->whole);
    w->blocks += w->whole;
    w->block++, w->whole = true;
}

/* Drops the block under way, in which a gap begins, and the one in which it ends. */
static void leave_out(struct witness *w, double since_s, const double length_m[LEGS], const double force_n[LEGS]) {
    w->whole = false;
    close_block(w);
    w->whole = false, w->block = floor(since_s / w->block_s), w->last_s = since_s;
    base_at(w, since_s, w->base);
    for (int i = 0; i < LEGS; i++) w->length[i].value = length_m[i], w->force[i].value = force_n[i];
}

/* Takes a step from one sample to the next. True if it leaves a gap. */
static bool is_gap(struct witness *w, double step_s) {
    double period_s = 2.0 * PI / w->omega;
    if (step_s > 0.0) w->shortest_s = fmin(w->shortest_s, step_s);
    return !(step_s >= 0.0 && step_s <= fmax(GAP_PERIODS * period_s, fmin(GAP_STEPS * w->shortest_s, GAP_MOST * period_s)));
}

/* Goes on to the next sample. The end of a block lies between two samples, where the signals are
 * interpolated. */
static void go_on(struct witness *w, double since_s, const double length_m[LEGS], const double force_n[LEGS]) {
    double end_s = (w->block + 1.0) * w->block_s, step_s = since_s - w->last_s;
    if (is_gap(w, step_s)) {
        leave_out(w, since_s, length_m, force_n);
        return;
    }
    if (since_s >= end_s && step_s > 0.0) {
        double length_at_m[LEGS], force_at_n[LEGS], share = (end_s - w->last_s) / step_s;
        for (int i = 0; i < LEGS; i++) {
            length_at_m[i] = w->length[i].value + share * (length_m[i] - w->length[i].value);
            force_at_n[i] = w->force[i].value + share * (force_n[i] - w->force[i].value);
        }
        add_all(w, end_s, length_at_m, force_at_n);
        close_block(w);
    }
    add_all(w, since_s, length_m, force_n);
    w->step_s = step_s;
}

static void look(struct witness *w, int leg, int which, double reading) {
    bool same = w->samples > 1 && reading == w->last[leg][which] && (which || w->moves[leg]);
    w->same[leg][which] = same ? w->same[leg][which] + 1 : 1;
    if (w->same[leg][which] > w->longest[leg]) w->longest[leg] = w->same[leg][which];
    w->last[leg][which] = reading;
}

static void read_leg(struct witness *w, int leg, const struct hal_sample *sample, double force_n) {
    look(w, leg, 0, sample->length_m[leg]);
    look(w, leg, 1, sample->p1_pa[leg]);
    look(w, leg, 2, sample->p2_pa[leg]);
    w->last_n[leg] = force_n;
    w->total_n[leg] += force_n;
}

void witness_add(struct witness *w, double since_s, const struct hal_sample *sample, const double force_n[LEGS], bool good) {
    double length_m[LEGS], leg_n[LEGS];
    if (!isfinite(since_s / w->block_s)) return;
    if (!good && w->samples == 0) return; /* nothing that could count in its place */
    w->samples += good;
    if (w->samples == 1 && good) memcpy(w->first_m, sample->length_m, sizeof w->first_m), memcpy(w->first_n, force_n, sizeof w->first_n);
    for (int i = 0; i < LEGS; i++) {
        if (good) read_leg(w, i, sample, force_n[i]);
        length_m[i] = w->last[i][0] - w->first_m[i], leg_n[i] = w->last_n[i] - w->first_n[i];
    }
    go_on(w, since_s, length_m, leg_n);
}

/* Finds the leg with the largest change between blocks in any of its terms from number `term`
 * on. */
static void worst(const struct wander w[LEGS], int term, double *largest, int *leg) {
    for (int i = 0; i < LEGS; i++)
        for (int k = term; k < WITNESS_TERMS; k++)
            if (w[i].high[k] - w[i].low[k] > *largest) *largest = w[i].high[k] - w[i].low[k], *leg = i;
}

struct testimony witness_says(const struct witness *w) {
    struct witness ended = *w;
    struct testimony t = {0};
    double length_m[LEGS], force_n[LEGS], end_s = (w->block + 1.0) * w->block_s;
    for (int i = 0; i < LEGS; i++) length_m[i] = w->length[i].begin, force_n[i] = w->force[i].begin;
    /* n samples cover n steps, and a block ends as it began, because the motion repeats */
    ended.whole = w->whole && end_s - w->last_s <= 1.5 * w->step_s;
    if (ended.whole) add_all(&ended, end_s, length_m, force_n), close_block(&ended);
    t.compared = ended.blocks >= 2;
    if (t.compared) worst(ended.length, SINE, &t.length_m, &t.length_leg), worst(ended.force, MEAN, &t.force_n, &t.force_leg);
    for (int i = 0; i < LEGS; i++) {
        t.mean_n[i] = w->total_n[i] / (double)w->samples;
        if (w->longest[i] > t.still_samples) t.still_samples = w->longest[i], t.still_leg = i;
    }
    return t;
}
