#include "segments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "frequency.h"
#include "noise.h"
#include "units.h"

const char *const segment_names[SEGMENT_KINDS] = {"rest", "steady", "moving"};

/* Grid points per second. The search works on an even grid, each point of which stands for the mean
 * of neighbouring samples; at this rate the fastest motion has ten points in a cycle. */
static const double GRID_HZ = 400.0;
static const double POINTS_LEAST = 5.0;  /* least number of points in a cycle */
enum { GRID_MOST = 1 << 22, SAMPLES_LEAST = 10 };

static const double REST_S = 0.5;        /* shortest rest; a shorter one is a reversal */
static const double NOISE_BAND = 5.0;    /* largest deviation of a leg at rest, as a multiple of its
                                          * rms noise; white noise stays within this for about an
                                          * hour */
static const double REST_SHARE = 3e-3;   /* largest deviation of a leg at rest to either side, as a
                                          * share of the leg's range in the whole test; a position
                                          * loop holds a leg at rest more closely than this */

/* Least number of cycles of a steady segment. */
static const double CYCLES_LEAST = 4.0;
/* In steady motion, successive cycles differ by at most this share of the motion's rms, beyond the
 * noise. A larger difference, up to SEARCHED, is allowed if it is usual in the run (RESTLESS). */
static const double ALIKE = 0.05;
/* While the period is searched, successive cycles may differ by this share of the motion's rms,
 * because a trial period with the relative error e adds a difference of 2 pi e. */
static const double SEARCHED = 0.2;
/* Tolerance factor on the mean square difference between a run's successive cycles, because some
 * loops oscillate slightly in addition to their motion. */
static const double RESTLESS = 1.5;
/* A trial period off by this factor makes a sinusoid's cycles differ by more than SEARCHED. */
static const double SEARCHED_RATIO = 1.04;
static const double LAG_RATIO = 1.005;   /* ratio of successive trial periods */
/* In steady motion, the mean square difference of successive cycles is at most this share of the
 * motion's variance, whatever the noise. */
static const double MOTION = 0.25;
/* Largest relative change of period from the first to the second half of a run. A sweep exceeds
 * this limit: if its successive cycles differ by up to ALIKE, the period changes by 8e-3 between
 * the halves. */
static const double SWEEP = 3e-3;
static const double SWELL = 0.1;         /* largest relative change of amplitude from the first to
                                          * the second half of a run */
/* Least share of a cycle's points that must be measured in this cycle and in the next one; also the
 * least share of a rest's points that must be measured. */
static const double COMPARED = 0.25;
/* Tolerance added to SWEEP and SWELL, in standard deviations of the change between the halves. The
 * standard deviations follow from the differences between the run's cycles. */
static const double UNSURE = 2.0;
/* A longer trial period is preferred if the run with it is longer by this factor; with a multiple
 * of the true period the run is longer by less. */
static const double LONGER_BY = 1.1;
enum { WINDOW_POINTS = 64 };             /* points compared in a cycle; others are skipped */
enum { PARTS = 32 };                     /* fractions of a period that are tried: 1/32 to 1/2 */
enum { DEPTH = 64 };                     /* greatest depth of recursion in find_steady() */

struct grid {
    int count, legs;
    /* start_s: time of point 0. step_s: time between points. */
    double start_s, step_s;
    double *x[LEGS];           /* mean lengths of the leg at the points, m, relative to its first
                                * length */
    double noise[LEGS];        /* rms noise of each leg's points, m */
    /* 1 for a point with a sample of its own, 0 for one that is interpolated. The array's second
     * half is scratch memory. */
    unsigned char *measured;
    unsigned char *kind;       /* enum segment_kind of each point */
    double *frequency;         /* frequency at each point of a steady segment, Hz; 0 at other
                                * points */
    double *low, *high;        /* scratch memory of extremes() */
    struct sums *sums;
};

/* Sums over all points before a given one. difference: squared differences from the value one
 * period later. compared: number of these differences. x: values. square: squared values. */
struct sums {
    double difference, compared, x, square;
};

static void grid_free(struct grid *g) {
    for (int k = 0; k < LEGS; k++) free(g->x[k]);
    free(g->measured), free(g->kind), free(g->frequency), free(g->sums), free(g->low), free(g->high);
}

static bool grid_alloc(struct grid *g) {
    size_t n = (size_t)g->count + 1;
    bool there = (g->measured = calloc(2, n)) && (g->kind = calloc(n, 1)) && (g->frequency = calloc(n, sizeof(double))) &&
                 (g->sums = calloc(n, sizeof *g->sums)) && (g->low = calloc(n, sizeof(double))) && (g->high = calloc(n, sizeof(double)));
    for (int k = 0; k < g->legs; k++) there = (g->x[k] = calloc(n, sizeof(double))) && there;
    return there;
}

/* Fills the grid points from *next up to the time at[1] by linear interpolation between two values.
 * at: times of the two values, s. */
static void lay_line(struct grid *g, int leg, const double at[2], const double value[2], int *next) {
    double slope = at[1] > at[0] ? (value[1] - value[0]) / (at[1] - at[0]) : 0.0;
    for (; *next < g->count && g->start_s + *next * g->step_s <= at[1]; ++*next)
        g->x[leg][*next] = value[0] + slope * (g->start_s + *next * g->step_s - at[0]);
}

static int point_of(const struct grid *g, double t_s) {
    double point = (t_s - g->start_s) / g->step_s + 0.5;
    return point < 0.0 ? 0 : point >= g->count ? g->count - 1 : (int)point;
}

/* Fills the grid for one leg. The samples nearest to each grid point are averaged; the value at the
 * point is interpolated between the mean instants of these averages. */
static void grid_fill(struct grid *g, const struct recording_test *t, int leg) {
    double zero = (double)NAN, at[2] = {0}, value[2] = {0}, sum_t = 0.0, sum_x = 0.0;
    int point = -1, n = 0, next = 0;
    bool begun = false;
    for (int i = 0; i <= t->count; i++) {
        const struct recording_sample *s = i < t->count ? &t->sample[i] : NULL;
        if (s && s->refused) continue;
        int of = s ? point_of(g, s->test_time_s) : -1;
        if (n && of != point) {
            at[1] = sum_t / n, value[1] = sum_x / n;
            if (!begun) at[0] = g->start_s, value[0] = value[1];
            lay_line(g, leg, at, value, &next);
            at[0] = at[1], value[0] = value[1], begun = true;
            g->measured[point] = 1;
            sum_t = sum_x = 0.0, n = 0;
        }
        if (!s) break;
        if (isnan(zero)) zero = s->length_m[leg];
        sum_t += s->test_time_s, sum_x += s->length_m[leg] - zero, n++, point = of;
    }
    for (; next < g->count; next++) g->x[leg][next] = value[0];
}

static int grid_make(struct grid *g, const struct recording_test *t, double sample_s, int legs, struct error *error) {
    double span_s = t->sample[t->count - 1].test_time_s - t->sample[0].test_time_s;
    int together = (int)fmax(1.0, fmin(floor(1.0 / (GRID_HZ * sample_s) + 1e-6), 1e6));
    *g = (struct grid){.legs = legs, .step_s = fmax(together * sample_s, span_s / (GRID_MOST - 2))};
    /* mean instant of the samples that make the first point */
    g->start_s = t->sample[0].test_time_s + 0.5 * (g->step_s - sample_s);
    g->count = (int)((span_s + sample_s) / g->step_s) + 1;
    if (!grid_alloc(g)) return error_set(error, STATUS_IO, "out of memory for the lengths of a test");
    for (int k = 0; k < legs; k++) {
        grid_fill(g, t, k);
        struct noise n = noise_measure(t->count, t->sample->length_m + k, sizeof *t->sample / sizeof(double));
        /* The quantisation error of a leg at rest does not average out. */
        g->noise[k] = isnan(n.rms) ? 0.0 : fmax(n.rms / sqrt(together), n.step / sqrt(12.0));
    }
    return STATUS_OK;
}

/* Finds, for each point, the least and the greatest of `window` values from this point on. */
static void extremes(struct grid *g, const double *x, int window) {
    memcpy(g->low, x, (size_t)g->count * sizeof *x), memcpy(g->high, x, (size_t)g->count * sizeof *x);
    for (int covered = 1, shift; covered < window; covered += shift) {
        shift = covered < window - covered ? covered : window - covered;
        for (int i = 0; i + shift < g->count; i++)
            g->low[i] = fmin(g->low[i], g->low[i + shift]), g->high[i] = fmax(g->high[i], g->high[i + shift]);
    }
}

/* Marks as rest every window in which all legs stay within their bands. */
static void find_rests(struct grid *g) {
    int window = (int)ceil(REST_S / g->step_s) + 1;
    memset(g->kind, SEGMENT_MOVING, (size_t)g->count);
    if (window < 3) window = 3;
    /* leaves[i]: 1 if some leg leaves its band in the window that begins at point i */
    unsigned char *leaves = g->measured + g->count + 1;
    memset(leaves, 0, (size_t)g->count);
    for (int k = 0; k < g->legs; k++) {
        extremes(g, g->x[k], g->count);
        double band = 2.0 * fmax(NOISE_BAND * g->noise[k], REST_SHARE * (g->high[0] - g->low[0]));
        extremes(g, g->x[k], window);
        for (int i = 0; i < g->count; i++) leaves[i] |= !(g->high[i] - g->low[i] <= band);
    }
    int seen = 0; /* number of measured points in the window from i on; a gap is no rest */
    for (int i = 0; i < window - 1 && i < g->count; i++) seen += g->measured[i];
    for (int i = 0, until = 0; i < g->count; i++) {
        seen += g->measured[i + window - 1 < g->count ? i + window - 1 : g->count];
        bool stays = i + window <= g->count && !leaves[i] && seen >= COMPARED * window;
        /* true if a leg jumped from one place of rest to another between two samples; this point
         * then separates the two rests */
        bool jumps = stays && i == until && i > 0;
        if (stays) until = i + window;
        if (i < until && !jumps) g->kind[i] = SEGMENT_REST;
        seen -= g->measured[i];
    }
}

/* Points first..end-1 of the grid. x, noise: values and rms noise of the leg that moves most in
 * them. */
struct stretch {
    int first, end;
    const double *x;
    double noise;
};

/* Variance of a leg's values over the measured points first..end-1. */
static double variance(const struct grid *g, const double *x, int first, int end) {
    double sum = 0.0, square = 0.0, n = 0.0;
    for (int i = first; i < end; i++) {
        if (!g->measured[i]) continue;
        sum += x[i] - x[first], square += (x[i] - x[first]) * (x[i] - x[first]), n += 1.0;
    }
    return n > 0.0 ? fmax(square - sum * sum / n, 0.0) / n : 0.0;
}

static struct stretch stretch_of(const struct grid *g, int first, int end) {
    struct stretch s = {.first = first, .end = end};
    double most = -1.0;
    for (int k = 0; k < g->legs; k++) {
        double v = variance(g, g->x[k], first, end);
        if (v > most) most = v, s.x = g->x[k], s.noise = g->noise[k];
    }
    return s;
}

/* A lag of `whole` points and a fraction of one. The value at such a place is the sum of the values
 * at its four neighbours, times these weights (cubic interpolation). */
struct lag {
    int whole;
    double weight[4];
};

static struct lag lag_of(double points) {
    int whole = (int)points;
    double f = points - whole;
    return (struct lag){whole,
                        {-f * (f - 1.0) * (f - 2.0) / 6.0, (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0, -(f + 1.0) * f * (f - 2.0) / 2.0,
                         (f + 1.0) * f * (f - 1.0) / 6.0}};
}

static const double LAG_MARGIN = 2.0; /* points beyond the lag that cubic interpolation needs */

/* Finds d, the value one lag after point i less the value at point i. Returns false, with d = 0, if
 * one of the two is not measured. */
static bool differs(const struct grid *g, const struct stretch *s, int i, const struct lag *lag, double *d) {
    const double *x = s->x + i + lag->whole, *w = lag->weight;
    bool measured = g->measured[i] && g->measured[i + lag->whole + (w[2] > w[1])];
    *d = measured ? w[0] * x[-1] + w[1] * x[0] + w[2] * x[1] + w[3] * x[2] - s->x[i] : 0.0;
    return measured;
}

/* Mean square difference between values a period apart, over points first..end-1. */
static double misfit(const struct grid *g, const struct stretch *s, int first, int end, double period) {
    struct lag lag = lag_of(period);
    double sum = 0.0, d;
    int n = 0, last = end - (int)ceil(period + LAG_MARGIN);
    for (int i = first; i < last; i++)
        if (differs(g, s, i, &lag, &d)) sum += d * d, n++;
    return n ? sum / n : HUGE_VAL;
}

/* Period, in points, at which points first..end-1 repeat best near a trial period, by golden
 * section search. */
static double refine(const struct grid *g, const struct stretch *s, int first, int end, double period) {
    static const double golden = 0.6180339887498949;
    double low = period / SEARCHED_RATIO, high = period * SEARCHED_RATIO;
    double a = high - golden * (high - low), b = low + golden * (high - low);
    double at_a = misfit(g, s, first, end, a), at_b = misfit(g, s, first, end, b);
    while (high - low > 1e-6 * period) {
        if (at_a < at_b) high = b, b = a, at_b = at_a, a = high - golden * (high - low), at_a = misfit(g, s, first, end, a);
        else low = a, a = b, at_a = at_b, b = low + golden * (high - low), at_b = misfit(g, s, first, end, b);
    }
    return 0.5 * (low + high);
}

/* A run of cycles that are alike. */
struct run {
    int first, end;
    double period; /* in grid points */
};

/* Returns the smallest fraction of a period with which the run repeats as well as with the whole
 * period, or the period itself. A gap or a single unlike cycle may have hidden the fraction from
 * the search. */
static double shortest_period(const struct grid *g, const struct stretch *s, const struct run *r, double period, double shortest) {
    double most = RESTLESS * misfit(g, s, r->first, r->end, period) + 4.0 * s->noise * s->noise;
    for (int part = PARTS; part > 1; part--)
        if (period / part >= shortest && misfit(g, s, r->first, r->end, period / part) < most)
            return refine(g, s, r->first, r->end, period / part);
    return period;
}

/* True if the cycle that starts at `from` is like the next one. from: sums before the cycle's first
 * point. cycle: number of points in a cycle. share: largest rms difference beyond the noise, as a
 * share of the motion's rms; whatever the noise, MOTION limits the difference. */
static bool alike(const struct sums *from, int cycle, double share, double noise) {
    double n = from[cycle].compared - from->compared, points = 2.0 * cycle;
    double e = (from[cycle].difference - from->difference) / n, mean = (from[2 * cycle].x - from->x) / points;
    double motion = fmax((from[2 * cycle].square - from->square) / points - mean * mean, 0.0);
    return n > COMPARED * cycle && e <= fmin(share * share * motion + 4.0 * noise * noise, MOTION * motion);
}

static void sum_up(const struct grid *g, const struct stretch *s, double period, int stride, int points) {
    struct lag lag = lag_of(period);
    struct sums *sum = g->sums;
    double d;
    sum[0] = (struct sums){0};
    for (int i = 0; i < points; i++) {
        int at = s->first + i * stride;
        double x = s->x[at] - s->x[s->first];
        bool compared = at < s->end - period - LAG_MARGIN && differs(g, s, at, &lag, &d);
        sum[i + 1] = sum[i];
        sum[i + 1].x += x, sum[i + 1].square += x * x;
        if (compared) sum[i + 1].difference += d * d, sum[i + 1].compared += 1.0;
    }
}

static int run_points(const struct run *r) { return r->end - r->first; }

/* Finds the longest run of alike cycles with this period in a stretch. The run is empty if all runs
 * are shorter than CYCLES_LEAST cycles. */
static struct run longest_run(const struct grid *g, const struct stretch *s, double period, double share) {
    int stride = (int)fmax(1.0, period / WINDOW_POINTS), cycle = (int)lround(period / stride);
    int points = (s->end - s->first) / stride, begin = -1;
    struct run best = {.period = period};
    sum_up(g, s, period, stride, points);
    for (int i = 0; i + 2 * cycle <= points; i++) {
        if (!alike(g->sums + i, cycle, share, s->noise)) {
            begin = -1;
            continue;
        }
        if (begin < 0) begin = i;
        if ((i - begin + 2 * cycle) * stride > run_points(&best))
            best.first = s->first + begin * stride, best.end = s->first + (i + 2 * cycle) * stride;
    }
    if (run_points(&best) < CYCLES_LEAST * period - stride) best.end = best.first;
    return best;
}

/* True if period and amplitude are the same in both halves of a run. */
static bool holds(const struct grid *g, const struct stretch *s, const struct run *r) {
    int middle = (r->first + r->end) / 2, cycles = (int)(floor(0.5 * run_points(r) / r->period) * r->period);
    double first = variance(g, s->x, r->first, r->first + cycles), second = variance(g, s->x, r->end - cycles, r->end);
    double early = refine(g, s, r->first, middle, r->period), late = refine(g, s, middle, r->end, r->period);
    double restless = fmax(misfit(g, s, r->first, middle, early), misfit(g, s, middle, r->end, late)) / fmin(first, second);
    /* UNSURE times the standard deviation of an amplitude ratio, and of a phase in radians */
    double unsure = UNSURE * sqrt(2.0 * restless * r->period / run_points(r));
    return fabs(late / early - 1.0) < SWEEP + unsure / (2.0 * PI) && fabs(sqrt(second / first) - 1.0) < SWELL + unsure;
}

/* Finds the longest run of any period. Returns false if there is no run, or if it is part of a
 * sweep. */
static bool steady_run(const struct grid *g, const struct stretch *s, struct run *best) {
    double shortest = fmax(POINTS_LEAST, 1.0 / (RECORDING_FASTEST_HZ * g->step_s));
    *best = (struct run){0};
    for (double period = shortest; period * CYCLES_LEAST <= s->end - s->first; period *= LAG_RATIO) {
        struct run r = longest_run(g, s, period, SEARCHED);
        if (run_points(&r) > LONGER_BY * run_points(best)) *best = r;
    }
    if (!run_points(best)) return false;
    double period = shortest_period(g, s, best, refine(g, s, best->first, best->end, best->period), shortest);
    double whole = misfit(g, s, best->first, best->end, period) / variance(g, s->x, best->first, best->end);
    *best = longest_run(g, s, period, fmin(fmax(ALIKE, sqrt(RESTLESS * whole)), SEARCHED));
    if (!run_points(best)) return false;
    best->period = refine(g, s, best->first, best->end, best->period);
    return holds(g, s, best);
}

/* Marks the longest steady run in points first..end-1, then searches the points before and behind
 * it. */
static void find_steady(struct grid *g, int first, int end, int depth) {
    struct stretch s = stretch_of(g, first, end);
    struct run r;
    if (!depth || end - first < CYCLES_LEAST * POINTS_LEAST || !steady_run(g, &s, &r)) return;
    for (int i = r.first; i < r.end; i++) g->kind[i] = SEGMENT_STEADY, g->frequency[i] = 1.0 / (r.period * g->step_s);
    find_steady(g, first, r.first, depth - 1);
    find_steady(g, r.end, end, depth - 1);
}

/* First point behind `first` that belongs to another segment. */
static int end_of(const struct grid *g, int first) {
    int end = first + 1;
    while (end < g->count && g->kind[end] == g->kind[first] && g->frequency[end] == g->frequency[first]) end++;
    return end;
}

/* Joins moving segments of less than half a cycle to a steady segment beside them. */
static void join_slivers(struct grid *g) {
    for (int first = 0, end; first < g->count; first = end) {
        end = end_of(g, first);
        int measured = 0;
        for (int i = first; i < end; i++) measured += g->measured[i];
        double before = first ? g->frequency[first - 1] : 0.0, behind = end < g->count ? g->frequency[end] : 0.0;
        double joined = before > 0.0 ? before : behind;
        if (g->kind[first] != SEGMENT_MOVING || !(joined * measured * g->step_s < 0.5)) continue;
        for (int i = first; i < end && joined > 0.0; i++) g->kind[i] = SEGMENT_STEADY, g->frequency[i] = joined;
    }
}

/* Frequency of a steady segment, Hz, fitted to all legs; if the fit is far from the repetition
 * rate, the repetition rate. */
static double exact_hz(const struct recording_test *t, int legs, const struct segment *p) {
    struct recording_test part = *t;
    part.first = p->first, part.end = p->end;
    double hz = frequency_fit(&part, legs, false, p->frequency_hz);
    return fabs(hz / p->frequency_hz - 1.0) < SEARCHED_RATIO - 1.0 ? hz : p->frequency_hz;
}

/* Rms of the motion in a segment, over all legs. */
static double motion_of(const struct recording_test *t, int legs, const struct segment *p) {
    double all = 0.0;
    for (int k = 0; k < legs; k++) {
        double sum = 0.0, square = 0.0, n = 0.0, zero = (double)NAN;
        for (int i = p->first; i < p->end; i++) {
            if (t->sample[i].refused) continue;
            if (isnan(zero)) zero = t->sample[i].length_m[k];
            double x = t->sample[i].length_m[k] - zero;
            sum += x, square += x * x, n += 1.0;
        }
        all += fmax(square - sum * sum / n, 0.0) / n;
    }
    return sqrt(all);
}

/* True if two neighbouring segments are parts of the same steady motion, so that a few unlike
 * cycles do not split it. */
static bool goes_on(const struct recording_test *t, int legs, const struct segment *a, const struct segment *b) {
    if (a->kind != SEGMENT_STEADY || b->kind != SEGMENT_STEADY || !(fabs(b->frequency_hz / a->frequency_hz - 1.0) < SWEEP)) return false;
    return fabs(motion_of(t, legs, b) / motion_of(t, legs, a) - 1.0) < SWELL;
}

static void finish_segments(struct segments *p, const struct recording_test *t, int legs) {
    int kept = 0;
    for (int i = 0; i < p->count; i++) {
        struct segment *q = &p->segment[i], *before = kept ? &p->segment[kept - 1] : NULL;
        if (q->kind == SEGMENT_STEADY) q->frequency_hz = exact_hz(t, legs, q);
        if (!before || !goes_on(t, legs, before, q)) p->segment[kept++] = *q;
        else before->end = q->end, before->frequency_hz = exact_hz(t, legs, before);
    }
    p->count = kept;
}

static int list_segments(struct segments *p, const struct grid *g, const struct recording_test *t, struct error *error) {
    int capacity = 0, before = -1;
    for (int i = 0; i < t->count; i++) {
        int point = g->count ? point_of(g, t->sample[i].test_time_s) : 0;
        enum segment_kind kind = g->count ? (enum segment_kind)g->kind[point] : SEGMENT_MOVING;
        double hz = kind == SEGMENT_STEADY ? g->frequency[point] : (double)NAN;
        bool same = before >= 0 && p->segment[before].kind == kind && (kind != SEGMENT_STEADY || p->segment[before].frequency_hz == hz);
        if (same) {
            p->segment[before].end = i + 1;
            continue;
        }
        if (p->count == capacity) {
            capacity = capacity ? 2 * capacity : 16;
            struct segment *more = realloc(p->segment, (size_t)capacity * sizeof *more);
            if (!more) return error_set(error, STATUS_IO, "out of memory for the pieces of a test");
            p->segment = more;
        }
        p->segment[before = p->count++] = (struct segment){i, i + 1, kind, hz};
    }
    return STATUS_OK;
}

int segments_find(struct segments *p, const struct recording_test *t, double step_s, int legs, struct error *error) {
    struct grid g = {0};
    int good = 0, status = STATUS_OK;
    *p = (struct segments){0};
    for (int i = 0; i < t->count; i++) good += !t->sample[i].refused;
    if (good >= SAMPLES_LEAST) status = grid_make(&g, t, step_s, legs, error);
    if (!status && g.count) {
        find_rests(&g);
        for (int first = 0, end; first < g.count; first = end) {
            end = end_of(&g, first);
            if (g.kind[first] == SEGMENT_MOVING) find_steady(&g, first, end, DEPTH);
        }
        join_slivers(&g);
    }
    if (!status) status = list_segments(p, &g, t, error);
    grid_free(&g);
    if (!status) finish_segments(p, t, legs);
    if (status) segments_free(p);
    return status;
}

void segments_free(struct segments *p) {
    free(p->segment);
    *p = (struct segments){0};
}

const struct segment *segments_longest(const struct segments *p, enum segment_kind kind) {
    const struct segment *longest = NULL;
    for (const struct segment *q = p->segment; q < p->segment + p->count; q++)
        if (q->kind == kind && (!longest || q->end - q->first > longest->end - longest->first)) longest = q;
    return longest;
}
