#include "motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "params.h"
#include "residual.h"
#include "sampling.h"
#include "sort.h"
#include "units.h"

static const double SINUSOID = 0.995;     /* least share of a sinusoid in the legs' mean square
                                           * motion; a triangle has 0.986 */
static const double STATED = 0.5;         /* least share of a sinusoid in the legs' mean square
                                           * motion for a test at its stated frequency: friction, a
                                           * weak loop or a shut valve distort it */
static const double CYCLE = 0.5;          /* least amplitude of each cycle, as a share of the
                                           * cycles' mean amplitude */
static const double FREQUENCY = 0.1;      /* relative tolerance about the stated frequency: more
                                           * than errors of a clock or of typing, less than the
                                           * distance of two tests' frequencies */
/* Lower limit of a segment's highest frequency, which makes the segment 3 s long. Segments are
 * longer only if they must cover a long record, or if the sampling rate is below 22 Hz. */
static const double BAND_LEAST_HZ = 2.75;
static const double BAND_OF_RATE = 1.0 / 8.0; /* highest frequency of a segment, as a share of the
                                               * sampling rate: a segment then has more than
                                               * twice as many samples as coefficients
                                               * (spectrum_cut) */
static const double BAND_OF_MOTION = 8.0; /* highest frequency of a segment, as a multiple of the
                                           * motion's mean frequency: the harmonics of a distorted
                                           * sinusoid are below it */
static const double STANDS_OUT = 10.0;    /* a bin is motion if its power exceeds this times the
                                           * noise floor; the strongest of 500 bins of noise, over
                                           * twelve windows, reaches 3 */
static const double REST = 1e-3;          /* a segment is at rest if its mean square speed is less
                                           * than this share of the mean over the chosen
                                           * segments */
static const double STEPS_LEAST = 3.0;    /* least motion of a segment, in steps of the sensor's
                                           * resolution: path at the rms speed in one period of the
                                           * segment's highest frequency. Rounding errors of slower
                                           * motion are not random */
static const double THIN_HZ = 200.0;      /* sampling rate of the periodogram; faster samples are
                                           * averaged */
static const double MISSING = 0.1;        /* share of a segment's samples that may be missing */
static const double GAP_STEPS = 2.5;      /* two good samples enclose a gap if they are more than
                                           * this many steps apart; jitter is less */
static const double BESIDE = 3.0, /* least time over which a speed beside a gap is fitted, in
                                   * steps */
    BESIDE_S = 0.01;              /* least time over which a speed beside a gap is fitted */
static const double TURN = 4.0;           /* the speed of a leg changes sharply in a gap if it
                                           * changes by more than this times the change that a
                                           * motion of the mean frequency makes over the gap and the
                                           * time beside it */
static const double TURN_LEAST = 0.5;     /* least change of speed that counts as sharp, as a share
                                           * of the rms speed */
static const double GAPS = 2.0;           /* a window of the periodogram is excluded if it lasts
                                           * longer than this times the time that its samples take
                                           * without gaps: half of it is then gaps, across which the
                                           * motion is unknown */
enum { PER_CYCLE = 16, SEGMENTS = 48, SEGMENT = 1024, WINDOWS = 12, BINS_LEAST = 16 };

static double first_good(const struct recording_test *t, int leg) {
    int i = t->first;
    while (i < t->end - 1 && t->sample[i].refused) i++;
    return t->sample[i].length_m[leg];
}

/* Mean square of a leg's length about its mean, m^2. */
static double variance(const struct recording_test *t, int leg) {
    double sum = 0.0, square = 0.0, zero = first_good(t, leg), n = 0.0;
    for (int i = t->first; i < t->end; i++) {
        if (t->sample[i].refused) continue;
        double x = t->sample[i].length_m[leg] - zero;
        sum += x, square += x * x, n++;
    }
    return (square - sum * sum / n) / n;
}

/* Index of the leg that moves most. */
static int mover(const struct recording_test *t, int legs) {
    double most = -1.0;
    int leg = 0;
    for (int k = 0; k < legs; k++) {
        double moves = variance(t, k);
        if (moves > most) most = moves, leg = k;
    }
    return leg;
}

/* Adds the sum of squares of a leg's motion to `square`, and the sum of squares of the motion less
 * a fitted sinusoid to `rest`. Samples are first averaged over a sixteenth of the cycle, so that
 * faster noise does not count. */
static void add_remainder(const struct recording_test *t, int leg, double hz, double *square, double *rest) {
    double h[9], g[3], s1 = 0.0, s2 = 0.0, zero = first_good(t, leg);
    int n = 0;
    for (int pass = 0; pass < 2; pass++) {
        double x = 0.0, time_s = 0.0, until_s = -HUGE_VAL;
        int many = 0;
        if (!pass) memset(h, 0, sizeof h), memset(g, 0, sizeof g);
        for (int i = t->first; i < t->end; i++) {
            const struct recording_sample *s = &t->sample[i];
            if (s->refused) continue;
            if (s->test_time_s > until_s) {
                double phase = 2.0 * PI * hz * time_s / fmax(many, 1), row[3] = {1.0, sin(phase), cos(phase)}, mean = x / fmax(many, 1);
                for (int a = 0; a < 3 && !pass && many; a++) {
                    g[a] += row[a] * mean;
                    for (int b = 0; b <= a; b++) h[3 * a + b] += row[a] * row[b];
                }
                if (pass && many) s1 += mean, s2 += mean * mean, n++, *rest += pow(mean - g[0] - g[1] * row[1] - g[2] * row[2], 2.0);
                x = time_s = 0.0, many = 0, until_s = s->test_time_s + 1.0 / hz / PER_CYCLE;
            }
            x += s->length_m[leg] - zero, time_s += s->test_time_s, many++;
        }
        if (!pass && !dense_factor(3, 3, h)) return;
        if (!pass) dense_solve(3, 3, h, g);
    }
    if (n) *square += s2 - s1 * s1 / n;
}

/* True if every cycle of the leg's motion has at least half the mean amplitude. */
static bool repeats(const struct recording_test *t, int leg, double hz) {
    double zero = first_good(t, leg), least = HUGE_VAL, sum = 0.0, until_s = t->sample[t->first].test_time_s + 1.0 / hz, s = 0.0, c = 0.0;
    int cycles = 0, n = 0;
    for (int i = t->first; i < t->end; i++) {
        const struct recording_sample *sample = &t->sample[i];
        if (sample->test_time_s >= until_s) {
            double amplitude = n ? hypot(s, c) / n : HUGE_VAL;
            /* a cycle without good samples is not judged */
            if (n) least = fmin(least, amplitude), sum += amplitude, cycles++;
            s = c = 0.0, n = 0, until_s += 1.0 / hz;
        }
        if (sample->refused) continue;
        double phase = 2.0 * PI * hz * sample->test_time_s, x = sample->length_m[leg] - zero;
        s += x * sin(phase), c += x * cos(phase), n++;
    }
    return cycles && least > CYCLE * sum / cycles;
}

bool motion_sinusoid(const struct recording_test *t, int legs, double frequency_hz) {
    bool stated = fabs(frequency_hz / t->stated_hz - 1.0) < FREQUENCY;
    double square = 0.0, rest = 0.0;
    for (int k = 0; k < legs && isfinite(frequency_hz); k++) add_remainder(t, k, frequency_hz, &square, &rest);
    if (stated && repeats(t, mover(t, legs), frequency_hz)) return rest < (1.0 - STATED) * square;
    return rest < (1.0 - SINUSOID) * square;
}

/* Adds |sum rest[i] exp(-2 pi j b i / n)|^2 to power[b] for 0 < b < n / 2. */
static void add_power(int n, const double *rest, double *power) {
    for (int b = 1; b < n / 2; b++) {
        double radians = 2.0 * PI * b / n, c = cos(radians), s = sin(radians), re = 1.0, im = 0.0, sum_re = 0.0, sum_im = 0.0;
        for (int i = 0; i < n; i++) {
            sum_re += rest[i] * re, sum_im += rest[i] * im;
            double next = re * c - im * s;
            im = re * s + im * c, re = next;
        }
        power[b] += sum_re * sum_re + sum_im * sum_im;
    }
}

/* Adds the power under Hann windows of n points, spread evenly over the record. Windows that are
 * half gaps are left out. Returns false if all are left out. */
static bool add_windows(const struct recording_test *t, const double *x, int all, int n, int many, double step_s, double *power) {
    double rest[SEGMENT];
    bool added = false;
    for (int window = 0; window < WINDOWS; window++) {
        int from = (int)((double)(all - n) * window / (WINDOWS - 1)), first = t->first + from * many;
        double mean = 0.0, lasts_s = t->sample[first + n * many - 1].test_time_s - t->sample[first].test_time_s;
        if (n < all && lasts_s > GAPS * n * many * step_s) continue;
        for (int i = 0; i < n; i++) mean += x[from + i] / n;
        for (int i = 0; i < n; i++) rest[i] = (x[from + i] - mean) * 0.5 * (1.0 - cos(2.0 * PI * (i + 0.5) / n));
        add_power(n, rest, power);
        added = true;
    }
    return added;
}

/* Sum of the periodograms of a leg's length over windows of the record, at a reduced sampling rate.
 * If the record comes in bursts, windows are halved until they fit between its gaps. Returns the
 * number of bins, or -3 without memory. */
static int periodogram(const struct recording_test *t, int leg, double step_s, double power[SEGMENT / 2], double *bin_hz) {
    int many = (int)fmax(1.0 / THIN_HZ / step_s, 1.0), all = (t->end - t->first) / many, n = all < SEGMENT ? all : SEGMENT;
    double *x = malloc((size_t)all * sizeof *x), held = first_good(t, leg);
    if (!x) return STATUS_IO;
    for (int i = 0; i < all; i++) {
        x[i] = 0.0;
        for (int j = 0; j < many; j++) {
            const struct recording_sample *s = &t->sample[t->first + i * many + j];
            if (!s->refused) held = s->length_m[leg];
            x[i] += held / many;
        }
    }
    while (n > 1 && !add_windows(t, x, all, n, many, step_s, power)) n /= 2;
    free(x);
    *bin_hz = 1.0 / (n * many * step_s);
    return n / 2;
}

/* Finds the highest frequency to evaluate: BAND_OF_MOTION times the speed's mean frequency. A long
 * record gets a lower one, so that the segments cover all of it, but not below BAND_OF_MOTION times
 * the length's mean frequency. Sets found->lacks if the record is too short or shows no motion.
 * Returns 0, or -3 without memory. */
static int find_band(const struct recording_test *t, int legs, double step_s, struct motion_cut *found, double *band_hz,
                     struct error *error) {
    double power[SEGMENT / 2] = {0}, sorted[SEGMENT / 2], bin_hz = 0.0, square = 0.0, rate = 0.0, curve = 0.0;
    int bins = periodogram(t, mover(t, legs), step_s, power, &bin_hz);
    if (bins < 0) return error_set(error, STATUS_IO, "out of memory");
    found->lacks = bins < BINS_LEAST ? CUT_TIME : CUT_NOTHING;
    if (found->lacks) return STATUS_OK;
    memcpy(sorted, power + bins / 2, (size_t)(bins - bins / 2) * sizeof *sorted);
    sort_ascending(bins - bins / 2, sorted);
    double floor = sorted[(bins - bins / 2) / 2];
    for (int b = 1; b < bins; b++) {
        if (!(power[b] > STANDS_OUT * floor)) continue;
        double excess = power[b] - floor, w = b * bin_hz;
        square += excess, rate += excess * w * w, curve += excess * w * w * w * w;
    }
    found->lacks = square > 0.0 ? CUT_NOTHING : CUT_MOTION;
    double motion_hz = BAND_OF_MOTION * sqrt(rate / square), all_hz = RESIDUAL_BAND * SEGMENTS / found->span_s;
    double most = fmin(fmin(BAND_OF_RATE / step_s, RECORDING_FASTEST_HZ), fmax(motion_hz, all_hz));
    *band_hz = fmin(fmax(BAND_OF_MOTION * sqrt(curve / rate), BAND_LEAST_HZ), most);
    return STATUS_OK;
}

struct cut_segment {
    /* speed: mean square of the legs' speeds, m^2/s^2 */
    double start_s, speed;
    int first, end; /* samples of the segment and of its margins: first <= i < end */
    enum refusal refused; /* why the segment is not evaluated */
};

/* A record cut into consecutive segments. */
struct cut {
    const struct recording_test *test;
    int legs;
    /* before_s, behind_s: lengths of record that a segment needs before and behind it */
    double step_s, segment_s, before_s, behind_s;
    /* turns: number of segments with a gap in which the speed of a leg may change sharply */
    int all, kept, turns;
    struct cut_segment *segment;                /* all segments; keep_segments() moves the kept
                                                 * ones to the front */
};

static struct cut_segment take_segment(const struct cut *c, int i) {
    const struct recording_test *t = c->test;
    struct cut_segment p = {.start_s = t->sample[t->first].test_time_s + c->before_s + i * c->segment_s};
    double from_s = p.start_s - c->before_s, until_s = p.start_s + c->segment_s + c->behind_s, sum = 0.0;
    int n = (int)((until_s - from_s) / c->step_s), good = 0, steps = 0, coarse = (int)fmax(0.02 / c->step_s, 1.0), last = -1;
    p.first = p.end = recording_at(t, from_s) > t->first ? recording_at(t, from_s) : t->first;
    for (; p.end < t->end && t->sample[p.end].test_time_s <= until_s; p.end++) {
        const struct recording_sample *s = &t->sample[p.end];
        good += !s->refused;
        if ((p.end - p.first) % coarse || s->refused) continue;
        for (int k = 0; k < c->legs && last >= 0; k++) {
            double v = (s->length_m[k] - t->sample[last].length_m[k]) / (s->test_time_s - t->sample[last].test_time_s);
            sum += v * v, steps++;
        }
        last = p.end;
    }
    p.speed = steps ? sum / steps : 0.0;
    bool complete = good > (1.0 - MISSING) * n && spectrum_gap(t, from_s, until_s) < residual_gap_s(c->segment_s, c->step_s);
    p.refused = complete ? REFUSED_NOT : REFUSED_GAP;
    return p;
}

/* Speed of a leg, from a line through the good samples of a time span; NaN if there are fewer than
 * two. */
static double speed_of(const struct recording_test *t, int leg, double from_s, double until_s) {
    double n = 0.0, x1 = 0.0, x2 = 0.0, y1 = 0.0, xy = 0.0;
    for (int i = recording_at(t, from_s); i < t->end && t->sample[i].test_time_s <= until_s; i++) {
        if (t->sample[i].refused || t->sample[i].test_time_s < from_s) continue;
        double x = t->sample[i].test_time_s - from_s, y = t->sample[i].length_m[leg];
        n++, x1 += x, x2 += x * x, y1 += y, xy += x * y;
    }
    double determinant = n * x2 - x1 * x1;
    return n > 1.0 && determinant > 0.0 ? (n * xy - x1 * y1) / determinant : (double)NAN;
}

/* True if the speed of a leg may change more sharply within one of the segment's gaps than in a
 * motion of the mean frequency. The series is right within a gap only if the motion continues there
 * as before. */
static bool hides_turn(const struct cut *c, const struct cut_segment *p, double omega, double speed) {
    const struct recording_test *t = c->test;
    double last_s = p->start_s - c->before_s;
    bool hides = false;
    for (int i = recording_at(t, last_s); i < t->end && t->sample[i].test_time_s <= p->start_s + c->segment_s + c->behind_s; i++) {
        double at_s = t->sample[i].test_time_s, gap_s = at_s - last_s, beside_s = fmax(fmax(gap_s, BESIDE_S), BESIDE * c->step_s);
        double turn = fmax(TURN * omega * (gap_s + beside_s), TURN_LEAST);
        if (t->sample[i].refused) continue;
        for (int k = 0; k < c->legs && gap_s > GAP_STEPS * c->step_s; k++) {
            double before = speed_of(t, k, last_s - beside_s, last_s), after = speed_of(t, k, at_s, at_s + beside_s);
            /* NaN, an unknown speed, counts as a sharp change */
            hides = hides || !(fabs(after - before) <= turn * speed);
        }
        last_s = at_s;
    }
    return hides;
}

/* Chooses at most `most` complete segments, spread evenly over the record. Returns their number. */
static int choose_segments(struct cut *c, int most) {
    int complete = 0, chosen = 0;
    for (int i = 0; i < c->all; i++) complete += !c->segment[i].refused;
    for (int i = 0, n = 0; i < c->all; i++) {
        if (c->segment[i].refused) continue;
        bool chooses = chosen < most && (complete <= most || n == (int)((double)complete * chosen / most));
        if (!chooses) c->segment[i].refused = REFUSED_SURPLUS;
        chosen += chooses, n++;
    }
    return chosen;
}

/* Keeps the chosen segments that move and whose gaps hide no sharp change of speed. */
static void keep_segments(struct cut *c, int most, double resolution_m) {
    double mean = 0.0, moves = 0.0;
    int chosen = choose_segments(c, most);
    for (int i = 0; i < c->all; i++) mean += c->segment[i].refused ? 0.0 : c->segment[i].speed / chosen;
    for (int k = 0; k < c->legs; k++) moves += variance(c->test, k) / c->legs;
    double least = fmax(REST * mean, pow(STEPS_LEAST * resolution_m * RESIDUAL_BAND / c->segment_s, 2.0)), omega = sqrt(mean / moves);
    for (int i = 0; i < c->all; i++) {
        struct cut_segment p = c->segment[i];
        bool turn = hides_turn(c, &p, omega, sqrt(fmax(p.speed, mean)));
        c->turns += turn;
        if (!p.refused) p.refused = turn ? REFUSED_TURN : p.speed > least ? REFUSED_NOT : REFUSED_REST;
        if (!p.refused) c->segment[c->kept++] = p;
    }
}

/* Replaces a test of the recording by its kept segments. */
static void put_segments(struct recording *r, int test, const struct cut *c) {
    struct recording_test whole = r->test[test];
    free(whole.measured), whole.measured = NULL;
    int before = 0; /* the segments of all records are numbered consecutively, so that even and odd
                     * ones alternate also if each record has only one */
    for (int i = 0; i < test; i++) before += r->test[i].segment_s > 0.0;
    memmove(r->test + test + c->kept, r->test + test + 1, (size_t)(r->tests - test - 1) * sizeof *r->test);
    r->tests += c->kept - 1;
    for (int i = 0; i < c->kept; i++) {
        struct recording_test *t = &r->test[test + i];
        *t = whole;
        t->segment_s = c->segment_s, t->start_s = c->segment[i].start_s, t->segment = before + i;
        t->first = c->segment[i].first, t->end = c->segment[i].end;
        t->borrowed = whole.borrowed || i > 0;
        t->frequency_hz = t->stated_hz = NAN;
    }
}

/* Replaces a test by its segments. If that is impossible, leaves it as it is and returns what the
 * record lacks. */
static enum cut_lacks cut_segments(struct recording *r, int test, struct cut *c) {
    int most = (RECORDING_TESTS - test) / (r->tests - test); /* the tests that are not yet cut share
                                                              * the remaining room */
    if (most < SEGMENTS_NEEDED) return CUT_ROOM;
    for (int i = 0; i < c->all; i++) c->segment[i] = take_segment(c, i);
    keep_segments(c, most < SEGMENTS ? most : SEGMENTS, r->params->sensors.enabled ? r->params->sensors.position_resolution_m : 0.0);
    if (2 * c->turns > c->all || (c->kept < SEGMENTS_NEEDED && c->kept + c->turns >= SEGMENTS_NEEDED)) return CUT_TURNS;
    if (!c->kept) return CUT_SEGMENTS;
    put_segments(r, test, c);
    return CUT_NOTHING;
}

int motion_cut(struct recording *r, int test, struct motion_cut *found, struct error *error) {
    const struct recording_test *t = &r->test[test];
    struct cut c = {.test = t, .legs = params_legs(r->params), .step_s = sampling_step_s(t, t->first, t->end)};
    double hz;
    *found = (struct motion_cut){.span_s = t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s};
    int status = find_band(t, c.legs, c.step_s, found, &hz, error);
    if (status || found->lacks) return status;
    c.segment_s = RESIDUAL_BAND / hz, c.behind_s = residual_margin_s(c.segment_s), c.before_s = c.behind_s + MEASURED_SETTLE_S + c.step_s;
    c.all = (int)fmax((found->span_s - c.before_s - c.behind_s) / c.segment_s, 0.0);
    c.segment = malloc((size_t)(c.all + 1) * sizeof *c.segment);
    if (!c.segment) return error_set(error, STATUS_IO, "out of memory");
    found->lacks = cut_segments(r, test, &c);
    found->segment_s = c.segment_s, found->all = c.all, found->turns = c.turns;
    free(c.segment);
    return STATUS_OK;
}
