#include "fast_motion.h"

#include <math.h>
#include <stdlib.h>

#include "units.h"

static const double OF_PERIOD = 1.0 / 12.0, /* half-width of a node's window, as a share of the
                                             * series' shortest period */
    SAMPLES = 3.0,                          /* least half-width of a node's window, in samples */
    NODES_APART = 0.25,                     /* distance of neighbouring nodes, as a share of the
                                             * window's half-width */
    SPREAD_LEAST = 0.06; /* a node is fitted only if the variance of its samples' times, in squares
                          * of the half-width, exceeds this. The variance is 0.13 with samples on
                          * both sides, and 0.04 at a record's end, where a node would be off by
                          * microns; 5 um are 26 kPa in a shut chamber. */

/* Finds the differences between a sample's lengths and the Fourier series at its time. */
static void rest_of(const struct recording_sample *sample, const struct spectrum *series, double rest[LEGS]) {
    double basis[SPECTRUM_SIZE], value[3];
    spectrum_basis(series->omega * sample->test_time_s, series->harmonics, basis);
    for (int k = 0; k < LEGS; k++) {
        spectrum_at(series->mean[CHANNEL_LENGTH][k], series->harmonics, series->omega, basis, value);
        rest[k] = sample->length_m[k] - value[0];
    }
}

/* Fits a straight line, value and slope at t_s, under a Hann window of half-width reach_s. Returns
 * false if there are too few good samples, or if all are on one side of t_s. */
static bool fit_line(const struct recording_sample *sample, int samples, const double (*rest)[LEGS], double t_s, double reach_s,
                     struct rods_motion *node) {
    double w0 = 0.0, w1 = 0.0, w2 = 0.0, y0[LEGS] = {0}, y1[LEGS] = {0};
    for (int i = 0; i < samples; i++) {
        double x = (sample[i].test_time_s - t_s) / reach_s, weight = 1.0 + cos(PI * x);
        if (sample[i].refused || fabs(x) >= 1.0) continue;
        w0 += weight, w1 += weight * x, w2 += weight * x * x;
        for (int k = 0; k < LEGS; k++) y0[k] += weight * rest[i][k], y1[k] += weight * x * rest[i][k];
    }
    double determinant = w0 * w2 - w1 * w1;
    if (!(determinant > SPREAD_LEAST * w0 * w0)) return false;
    for (int k = 0; k < LEGS; k++) {
        node->length_m[k] = (w2 * y0[k] - w1 * y1[k]) / determinant;
        node->rate_mps[k] = (w0 * y1[k] - w1 * y0[k]) / determinant / reach_s;
    }
    return true;
}

/* Cubic through the values and slopes of two nodes, at a share x of the time between them. value:
 * length and rate. */
static inline void between(const struct rods_motion *from, const struct rods_motion *until, double step_s, double x, int leg,
                           double value[2]) {
    double a = from->length_m[leg], b = step_s * from->rate_mps[leg], end = until->length_m[leg] - a;
    double slope = step_s * until->rate_mps[leg], c = 3.0 * end - 2.0 * b - slope, d = b + slope - 2.0 * end;
    value[0] = a + x * (b + x * (c + x * d));
    value[1] = (b + x * (2.0 * c + x * 3.0 * d)) / step_s;
}

/* Fills the nodes known+1 .. next-1, which had no samples, from the cubic between nodes `known` and
 * `next`. Before the first node with samples (known is -1) and behind the last, the value stays
 * constant. */
static void bridge(struct fast_motion *f, int known, int next) {
    bool both = known >= 0 && next < f->nodes;
    const struct rods_motion *from = &f->node[known >= 0 ? known : next], *until = &f->node[next < f->nodes ? next : known];
    for (int i = known + 1; i < next; i++)
        for (int k = 0; k < LEGS; k++) {
            double value[2] = {from->length_m[k]};
            if (both) between(from, until, (next - known) * f->step_s, (double)(i - known) / (next - known), k, value);
            f->node[i].length_m[k] = value[0], f->node[i].rate_mps[k] = value[1];
        }
}

static void fit_nodes(struct fast_motion *f, const struct recording_sample *sample, int samples, const double (*rest)[LEGS],
                      double reach_s) {
    int known = -1;
    for (int i = 0, from = 0, to = 0; i < f->nodes; i++) {
        double t_s = f->first_s + i * f->step_s;
        while (from < samples && sample[from].test_time_s <= t_s - reach_s) from++;
        while (to < samples && sample[to].test_time_s < t_s + reach_s) to++;
        if (!fit_line(sample + from, to - from, rest + from, t_s, reach_s, &f->node[i])) continue;
        bridge(f, known, i);
        known = i;
    }
    if (known >= 0) bridge(f, known, f->nodes);
}

bool fast_motion_fit(struct fast_motion *f, const struct recording_test *test, double sampling_s, const struct spectrum *series,
                     double from_s, double until_s) {
    double reach_s = fmax(OF_PERIOD * 2.0 * PI / series->omega / series->harmonics, SAMPLES * sampling_s);
    int first = test->first, end;
    while (first < test->end && test->sample[first].test_time_s < from_s) first++;
    for (end = first; end < test->end && test->sample[end].test_time_s <= until_s;) end++;
    *f = (struct fast_motion){.first_s = from_s, .step_s = NODES_APART * reach_s};
    f->nodes = (int)((until_s - from_s) / f->step_s) + 2;
    double (*rest)[LEGS] = malloc((size_t)(end - first + 1) * sizeof *rest);
    f->node = calloc((size_t)f->nodes, sizeof *f->node);
    bool all = rest && f->node;
    for (int i = first; i < end && all; i++) rest_of(&test->sample[i], series, rest[i - first]);
    if (all) fit_nodes(f, test->sample + first, end - first, (const double (*)[LEGS])rest, reach_s);
    free(rest);
    return all;
}

void fast_motion_free(struct fast_motion *f) { free(f->node); }

void fast_motion_add(const struct fast_motion *f, int leg, double t_s, double scale, double *length_m, double *rate_mps) {
    double place = (t_s - f->first_s) / f->step_s, last = f->nodes - 1, value[2];
    place = place < 0.0 ? 0.0 : place > last ? last : place;
    int i = place < last ? (int)place : f->nodes - 2;
    between(&f->node[i], &f->node[i + 1], f->step_s, place - i, leg, value);
    *length_m += value[0] / scale, *rate_mps += value[1] / scale;
}
