#include "witness.h"

#include <math.h>
#include <string.h>

#include "units.h"

enum { BLOCK_SAMPLES = 100 };
enum { MEAN, SINE };

static void wander_reset(struct wander *w) {
    *w = (struct wander){0};
    for (int k = 0; k < WITNESS_TERMS; k++) w->low[k] = INFINITY, w->high[k] = -INFINITY;
}

void witness_reset(struct witness *w, double frequency_hz, double period_s, const bool moves[LEGS]) {
    double periods = fmax(1.0, ceil(BLOCK_SAMPLES * period_s * frequency_hz));
    *w = (struct witness){.omega = 2.0 * PI * frequency_hz, .block_s = periods / frequency_hz};
    w->block_full = w->block_s / period_s;
    memcpy(w->moves, moves, sizeof w->moves);
    for (int i = 0; i < LEGS; i++) wander_reset(&w->length[i]), wander_reset(&w->force[i]);
}

static void wander_close(struct wander *w, int64_t samples, bool whole) {
    for (int k = 0; k < WITNESS_TERMS; k++) {
        double term = (k ? 2.0 : 1.0) * w->sum[k] / (double)samples;
        if (whole) w->low[k] = fmin(w->low[k], term), w->high[k] = fmax(w->high[k], term);
        w->sum[k] = 0.0;
    }
}

static void close_block(struct witness *w) {
    /* A block that is not whole does not count, because its mean would contain part of the
     * motion. */
    bool whole = (double)w->block_samples > w->block_full - 1.0;
    for (int i = 0; i < LEGS; i++) {
        wander_close(&w->length[i], w->block_samples, whole);
        wander_close(&w->force[i], w->block_samples, whole);
    }
    w->block_samples = 0;
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

static void wander_add(struct wander *w, bool first, const double base[WITNESS_TERMS], double value) {
    if (first) w->first = value;
    for (int k = 0; k < WITNESS_TERMS; k++) w->sum[k] += base[k] * (value - w->first);
}

void witness_add(struct witness *w, double since_s, const struct hal_sample *sample, const double force_n[LEGS], bool good) {
    const double base[WITNESS_TERMS] = {1.0, sin(w->omega * since_s), cos(w->omega * since_s)};
    double block = floor(since_s / w->block_s + 1e-6); /* the small term allows for the rounded
                                                        * times of some logs */
    if (!isfinite(block)) return;
    if (block != w->block) close_block(w);
    w->block = block;
    w->block_samples++;
    /* a bad sample before the first good one counts as equal to it; the difference from the
     * first value, which is summed, is then zero */
    if (!good && w->samples == 0) return;
    w->samples += good;
    for (int i = 0; i < LEGS; i++) {
        if (good) read_leg(w, i, sample, force_n[i]);
        bool first = good && w->samples == 1;
        wander_add(&w->length[i], first, base, w->last[i][0]);
        wander_add(&w->force[i], first, base, w->last_n[i]);
    }
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
    close_block(&ended);
    worst(ended.length, SINE, &t.length_m, &t.length_leg);
    worst(ended.force, MEAN, &t.force_n, &t.force_leg);
    for (int i = 0; i < LEGS; i++) {
        t.mean_n[i] = w->total_n[i] / (double)w->samples;
        if (w->longest[i] > t.still_samples) t.still_samples = w->longest[i], t.still_leg = i;
    }
    return t;
}
