#include "spectrum.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "numeric.h"
#include "sort.h"
#include "units.h"

enum {
    SAMPLES_PER_HARMONIC = 3,
    SPEED_POINTS = 64,
    SLOWEST = 2,         /* number of lowest bins of the periodogram over the cycles that lasting()
                          * uses */
};
static const double RIDGE_PER_SAMPLE = 1e-9; /* ridge per sample on the diagonal of the normal
                                              * equations: above rounding, below any signal */
static const double SAME_PHASE = 0.05; /* difference of sampling phases up to which they count as
                                        * equal, in sampling periods */
static const double GOOD_SHARE = 0.9; /* share of a cycle's samples that must be good */

void spectrum_basis(double phase, int harmonics, double *basis) {
    double s1 = sin(phase), c1 = cos(phase), s = 0.0, c = 1.0;
    basis[0] = 1.0;
    for (int h = 1; h <= harmonics; h++) {
        double next = s * c1 + c * s1;
        c = c * c1 - s * s1, s = next;
        basis[2 * h - 1] = s, basis[2 * h] = c;
    }
}

void spectrum_at(const double *row, int harmonics, double omega, const double *basis, double value[3]) {
    value[0] = row[0], value[1] = value[2] = 0.0;
    for (int h = 1; h <= harmonics; h++) {
        double w = h * omega, s = row[2 * h - 1], c = row[2 * h];
        double y = s * basis[2 * h - 1] + c * basis[2 * h];
        value[0] += y;
        value[1] += w * (s * basis[2 * h] - c * basis[2 * h - 1]);
        value[2] -= w * w * y;
    }
}

void spectrum_value(const double *row, int harmonics, double omega, double t_s, double value[3]) {
    double basis[SPECTRUM_SIZE];
    spectrum_basis(omega * t_s, harmonics, basis);
    spectrum_at(row, harmonics, omega, basis, value);
}

double spectrum_speed_std(const struct spectrum *s, int leg, int harmonics) {
    if (!s->cycles) return s->speed_gain * s->noise[CHANNEL_LENGTH][leg];
    const double *std = s->std[CHANNEL_LENGTH][leg], *in_step = s->in_step[CHANNEL_LENGTH][leg];
    double sum = 0.0;
    for (int a = 1; a < 1 + 2 * harmonics; a++) {
        double w = (a + 1) / 2 * s->omega;
        sum += 0.5 * w * w * (std[a] * std[a] + in_step[a] * in_step[a]);
    }
    return sqrt(sum);
}

const double *spectrum_channel(const struct recording_sample *s, enum channel channel) {
    const double *const all[CHANNELS] = {s->length_m, s->p1_pa, s->p2_pa, s->valve, s->force_n};
    return all[channel];
}

/* Samples first .. end-1 of a test, such as a cycle. */
struct span {
    int first, end;
    double middle_s;
};

/* Sums, over the good samples, the products of the Fourier basis with itself, with the channels,
 * and with a drift of one unit per period about the middle. longest_s: longest time between two
 * good samples. Returns the number of good samples. */
static int add_samples(const struct spectrum *s, const struct recording_test *t, const struct span *span,
                       double product[SPECTRUM_SIZE][SPECTRUM_SIZE], double row[CHANNELS][LEGS][SPECTRUM_SIZE], double ramp[SPECTRUM_SIZE],
                       double *longest_s) {
    double basis[SPECTRUM_SIZE], last_s = NAN;
    int size = 1 + 2 * s->harmonics, good = 0;
    *longest_s = 0.0;
    memset(row, 0, CHANNELS * sizeof row[0]);
    memset(ramp, 0, SPECTRUM_SIZE * sizeof *ramp);
    for (int i = span->first; i < span->end; i++) {
        const struct recording_sample *sample = &t->sample[i];
        if (sample->refused) continue;
        double drifted = s->omega / (2.0 * PI) * (sample->test_time_s - span->middle_s);
        *longest_s = fmax(*longest_s, sample->test_time_s - last_s);
        last_s = sample->test_time_s;
        good++;
        spectrum_basis(s->omega * sample->test_time_s, s->harmonics, basis);
        for (int a = 0; a < size; a++) {
            for (int b = 0; b <= a; b++) product[a][b] += basis[a] * basis[b];
            ramp[a] += basis[a] * drifted;
        }
        for (int ch = 0; ch < CHANNELS; ch++)
            for (int k = 0; k < LEGS; k++) {
                double y = spectrum_channel(sample, (enum channel)ch)[k];
                for (int a = 0; a < size; a++) row[ch][k][a] += basis[a] * y;
            }
    }
    return good;
}

/* Finds the Fourier coefficients of one cycle by least squares over its good samples. ramp: the
 * coefficients that a drift of one unit per cycle would have. Refuses the cycle if too few samples
 * are good, or if a gap lasts half a period of the highest harmonic; single lost samples are no
 * gap. */
static enum refusal fit_cycle(const struct spectrum *s, const struct recording_test *t, const struct span *span, double step_s,
                              double row[CHANNELS][LEGS][SPECTRUM_SIZE], double ramp[SPECTRUM_SIZE]) {
    double product[SPECTRUM_SIZE][SPECTRUM_SIZE] = {0}, longest_s;
    int size = 1 + 2 * s->harmonics, good = add_samples(s, t, span, product, row, ramp, &longest_s);
    bool enough = good > GOOD_SHARE * 2.0 * PI / s->omega / step_s && longest_s < fmax(PI / s->omega / s->harmonics, 2.5 * step_s);
    if (!enough) return REFUSED_GAP;
    if (!dense_factor(size, SPECTRUM_SIZE, product[0])) return REFUSED_UNDETERMINED;
    for (int ch = 0; ch < CHANNELS; ch++)
        for (int k = 0; k < LEGS; k++) dense_solve(size, SPECTRUM_SIZE, product[0], row[ch][k]);
    dense_solve(size, SPECTRUM_SIZE, product[0], ramp);
    return REFUSED_NOT;
}

/* The whole cycles of a test. Those that are averaged are stored from the front of the arrays, the
 * others from their end. */
struct cycles_of_test {
    int averaged, all;
    double place[CYCLES_MAX]; /* number of the cycle */
    struct span span[CYCLES_MAX];
    double ramp[SPECTRUM_SIZE]; /* mean, over the averaged cycles, of the series fitted to a drift
                                 * of one unit per cycle */
};

/* Fits a line to the constants of all whole cycles over the cycles' numbers, and returns the slope
 * per cycle; 0 if there are too few cycles. Cycles that are not averaged count too, so that even
 * and odd cycles have one drift. lost: degrees of freedom that the slope takes from the averaged
 * cycles, which is the sum of squares of these cycles' numbers about their mean, divided by the
 * same sum for all cycles. */
static double slope_of(const struct cycles_of_test *c, spectrum_cycle *row, int ch, int leg, double *lost) {
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, own = 0.0, own_square = 0.0;
    *lost = 0.0;
    if (c->all < (c->averaged < c->all ? 4 : 3)) return 0.0;
    for (int i = 0; i < c->averaged; i++) own += c->place[i], own_square += square(c->place[i]);
    for (int n = 0; n < c->all; n++) {
        int i = n < c->averaged ? n : CYCLES_MAX - 1 - n + c->averaged;
        double value = row[i][ch][leg][0];
        x += c->place[i], y += value, xx += c->place[i] * c->place[i], xy += c->place[i] * value;
    }
    *lost = (own_square - square(own) / c->averaged) / (xx - x * x / c->all);
    return (c->all * xy - x * y) / (c->all * xx - x * x);
}

/* Finds the mean of a coefficient over the averaged cycles, and the mean's standard deviation.
 * Deviations are taken from a line of this slope; lost: degrees of freedom that the slope takes. */
static void average(const struct cycles_of_test *c, const double *value, double slope, double lost, double *mean, double *std) {
    int n = c->averaged;
    double sum = 0.0, x = 0.0, rest = 0.0;
    for (int i = 0; i < n; i++) sum += value[i], x += c->place[i];
    sum /= n, x /= n;
    for (int i = 0; i < n; i++) rest += square(value[i] - sum - slope * (c->place[i] - x));
    *mean = sum;
    *std = sqrt(rest / (n - 1 - lost) / n);
}

/* Ratio of the variance of a harmonic's mean to the variance that independent cycles would give the
 * mean: the spectral density over the cycles near frequency zero, from the slowest bins of the
 * periodogram, divided by the mean density (Priestley 1981, section 6.1). Rounding errors that
 * recur with the sampling phase lie in other bins. */
static double lasting(const struct spectrum *s, spectrum_cycle *row, int channel, int leg, int harmonic) {
    double slow = 0.0, all = 0.0;
    for (int a = 2 * harmonic - 1; a <= 2 * harmonic; a++) {
        double re[SLOWEST] = {0}, im[SLOWEST] = {0};
        for (int i = 0; i < s->cycles; i++) {
            double apart = row[i][channel][leg][a] - s->mean[channel][leg][a];
            all += apart * apart / (s->cycles - 1);
            for (int j = 0; j < SLOWEST; j++) {
                double phase = 2.0 * PI * (j + 1) * i / s->cycles;
                re[j] += apart * cos(phase), im[j] += apart * sin(phase);
            }
        }
        for (int j = 0; j < SLOWEST; j++) slow += (re[j] * re[j] + im[j] * im[j]) / s->cycles / SLOWEST;
    }
    return all > 0.0 ? slow / all : 1.0;
}

/* Enlarges the standard deviations of the mean cycle if errors last over several cycles, so that
 * averaging cancels them less: multiplies by the root of the ratio of lasting(), if this ratio is
 * above 1. Each ratio is averaged with the neighbouring harmonics', because one harmonic has too
 * few of the lowest bins. An average over all harmonics would let the drift of one harmonic, such
 * as the motion's own, count as noise of the others. */
static void lengthen(struct spectrum *s, spectrum_cycle *row, int channel, int leg) {
    double ratio[1 + SPECTRUM_HARMONICS];
    if (s->cycles <= 2 * SLOWEST) return;
    for (int h = 1; h <= s->harmonics; h++) ratio[h] = lasting(s, row, channel, leg, h);
    for (int h = 1; h <= s->harmonics; h++) {
        int first = h > 1 ? h - 1 : h, last = h < s->harmonics ? h + 1 : h;
        double sum = 0.0;
        for (int i = first; i <= last; i++) sum += ratio[i];
        double longer = sqrt(fmax(sum / (last - first + 1), 1.0));
        for (int a = 2 * h - 1; a <= 2 * h; a++) s->std[channel][leg][a] *= longer;
    }
}

/* Adds the squares of a span's good samples, less the varying part of the mean cycle, the drift and
 * the span's own constant. Returns the number of good samples. */
static int add_noise(const struct spectrum *s, const struct recording_test *t, const struct span *span,
                     double row[CHANNELS][LEGS][SPECTRUM_SIZE], double square_sum[CHANNELS][LEGS]) {
    double basis[SPECTRUM_SIZE];
    int good = 0;
    for (int i = span->first; i < span->end; i++) {
        if (t->sample[i].refused) continue;
        double after_s = t->sample[i].test_time_s - span->middle_s;
        good++;
        spectrum_basis(s->omega * t->sample[i].test_time_s, s->harmonics, basis);
        for (int ch = 0; ch < CHANNELS; ch++)
            for (int k = 0; k < LEGS; k++) {
                double rest = spectrum_channel(&t->sample[i], (enum channel)ch)[k] - row[ch][k][0] - s->drift[ch][k] * after_s;
                for (int a = 1; a < 1 + 2 * s->harmonics; a++) rest -= basis[a] * s->mean[ch][k][a];
                square_sum[ch][k] += rest * rest;
            }
    }
    return good;
}

/* Finds cycles whose samples are at the same phases. alike: for each averaged cycle, the index of
 * the first averaged cycle with the same phases. Returns the number of different sets of phases. */
static int find_alike(const struct spectrum *s, const struct recording_test *t, double step_s, const struct cycles_of_test *c,
                      int alike[CYCLES_MAX]) {
    double period_s = 2.0 * PI / s->omega, start_s = t->sample[t->first].test_time_s, offset[CYCLES_MAX];
    int different = 0;
    for (int i = 0; i < c->averaged; i++) {
        const struct span *one = &c->span[i];
        offset[i] = (t->sample[one->first].test_time_s - start_s - c->place[i] * period_s) / step_s;
        int b = 0;
        for (; b < i; b++) {
            bool phases = fabs(remainder(offset[b] - offset[i], 1.0)) < SAME_PHASE;
            if (alike[b] == b && phases && c->span[b].end - c->span[b].first == one->end - one->first) break;
        }
        alike[i] = b, different += b == i;
    }
    return different;
}

/* Scatter of a channel at one phase from one cycle to the next: the median over the cycles, because
 * the first ones may still settle. */
static double scatter_of(const struct recording_test *t, const struct cycles_of_test *c, const int alike[CYCLES_MAX], enum channel channel,
                         int leg) {
    double mean_square[CYCLES_MAX];
    int last[CYCLES_MAX], pairs = 0;
    for (int i = 0; i < c->averaged; i++) {
        int before = alike[i] == i ? -1 : last[alike[i]], n = 0;
        double sum = 0.0;
        last[alike[i]] = i;
        for (int j = 0; j < c->span[i].end - c->span[i].first && before >= 0; j++) {
            const struct recording_sample *now = &t->sample[c->span[i].first + j], *then = &t->sample[c->span[before].first + j];
            if (now->refused || then->refused) continue;
            sum += 0.5 * square(spectrum_channel(now, channel)[leg] - spectrum_channel(then, channel)[leg]), n++;
        }
        if (n) mean_square[pairs++] = sum / n;
    }
    if (!pairs) return 0.0;
    sort_ascending(pairs, mean_square);
    return sqrt(mean_square[pairs / 2]);
}

static void summarise(struct spectrum *s, const struct recording_test *t, double step_s, const struct cycles_of_test *c,
                      spectrum_cycle *row) {
    double value[CYCLES_MAX], square_sum[CHANNELS][LEGS] = {0};
    int samples = 0, alike[CYCLES_MAX];
    for (int ch = 0; ch < CHANNELS; ch++)
        for (int k = 0; k < LEGS; k++) {
            double lost, slope = slope_of(c, row, ch, k, &lost);
            s->drift[ch][k] = slope * s->omega / (2.0 * PI);
            for (int a = 0; a < 1 + 2 * s->harmonics; a++) {
                for (int i = 0; i < c->averaged; i++) value[i] = row[i][ch][k][a] -= slope * c->ramp[a];
                average(c, value, a ? 0.0 : slope, a ? 0.0 : lost, &s->mean[ch][k][a], &s->std[ch][k][a]);
            }
            lengthen(s, row, ch, k);
        }
    for (int i = 0; i < c->averaged; i++) samples += add_noise(s, t, &c->span[i], row[i], square_sum);
    s->offsets = find_alike(s, t, step_s, c, alike);
    for (int ch = 0; ch < CHANNELS; ch++)
        for (int k = 0; k < LEGS; k++) {
            s->noise[ch][k] = sqrt(square_sum[ch][k] / samples);
            s->scatter[ch][k] = scatter_of(t, c, alike, (enum channel)ch, k);
        }
}

/* Fits all whole cycles of the test. Returns false if fewer than two of them are to be averaged. */
static bool fit_cycles(const struct spectrum *s, const struct recording_test *t, double step_s, enum cycles which, struct cycles_of_test *c,
                       spectrum_cycle *row) {
    double start_s = t->sample[t->first].test_time_s, period_s = 2.0 * PI / s->omega, one[SPECTRUM_SIZE];
    c->averaged = c->all = 0;
    memset(c->ramp, 0, sizeof c->ramp);
    for (int cycle = 0, i = t->first; c->all < CYCLES_MAX && i < t->end; cycle++) {
        struct span span = {.first = i, .middle_s = start_s + (cycle + 0.5) * period_s};
        double until_s = start_s + (cycle + 1) * period_s - 1e-6 * step_s;
        while (i < t->end && t->sample[i].test_time_s < until_s) i++;
        span.end = i;
        bool whole = i < t->end || until_s - t->sample[i - 1].test_time_s <= 1.5 * step_s;
        bool averaged = which & (cycle % 2 ? CYCLES_ODD : CYCLES_EVEN);
        int at = averaged ? c->averaged : CYCLES_MAX - 1 - (c->all - c->averaged);
        if (!whole || fit_cycle(s, t, &span, step_s, row[at], one)) continue;
        c->place[at] = cycle, c->span[at] = span, c->all++;
        if (!averaged) continue;
        for (int a = 0; a < 1 + 2 * s->harmonics; a++) c->ramp[a] += (one[a] - c->ramp[a]) / (c->averaged + 1);
        c->averaged++;
    }
    return c->averaged >= 2;
}

bool spectrum_measure(struct spectrum *s, spectrum_cycle row[CYCLES_MAX], const struct recording_test *t, double step_s,
                      enum cycles which) {
    memset(s, 0, sizeof *s);
    if (t->first < 0 || t->end - t->first < 8 || t->segment_s > 0.0 || !(t->frequency_hz > 0.0)) return false;
    struct cycles_of_test cycles;
    s->omega = 2.0 * PI * t->frequency_hz;
    s->harmonics = (int)fmin(SPECTRUM_HARMONICS, 1.0 / t->frequency_hz / step_s / SAMPLES_PER_HARMONIC);
    bool enough = s->harmonics >= 1 && fit_cycles(s, t, step_s, which, &cycles, row);
    if (!enough) return false;
    s->cycles = cycles.averaged;
    summarise(s, t, step_s, &cycles, row);
    return true;
}

/* rms error of the speed in the middle half of the segment, for one unit of a sample's rms
 * noise. */
static double speed_gain(const struct spectrum *s, const struct recording_test *t, const struct span *span,
                         double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]) {
    double basis[SPECTRUM_SIZE], rate[SPECTRUM_SIZE] = {0}, sum = 0.0;
    int n = 0, size = 1 + 2 * s->harmonics;
    int samples = span->end - span->first;
    int margin = samples / 4; /* the ends are not used: the series is less certain there */
    for (int i = span->first + margin; i < span->end - margin; i += samples / SPEED_POINTS + 1, n++) {
        spectrum_basis(s->omega * t->sample[i].test_time_s, s->harmonics, basis);
        for (int h = 1; h <= s->harmonics; h++)
            rate[2 * h - 1] = h * s->omega * basis[2 * h], rate[2 * h] = -h * s->omega * basis[2 * h - 1];
        for (int a = 0; a < size; a++)
            for (int b = 0; b < size; b++) sum += rate[a] * inverse[a][b] * rate[b];
    }
    return sqrt(sum / n);
}

double spectrum_gap(const struct recording_test *t, double from_s, double until_s) {
    double last_s = from_s, longest_s = 0.0;
    for (int i = recording_at(t, from_s); i < t->count && t->sample[i].test_time_s <= until_s; i++) {
        if (t->sample[i].refused) continue;
        longest_s = fmax(longest_s, t->sample[i].test_time_s - last_s);
        last_s = t->sample[i].test_time_s;
    }
    return fmax(longest_s, until_s - last_s);
}

bool spectrum_cut(struct spectrum *s, const struct recording_test *t, double from_s, double until_s, double omega,
                  double inverse[SPECTRUM_SIZE][SPECTRUM_SIZE]) {
    double product[SPECTRUM_SIZE][SPECTRUM_SIZE] = {0}, square_sum[CHANNELS][LEGS] = {0}, ramp[SPECTRUM_SIZE], longest_s;
    struct span span = {.first = recording_at(t, from_s)};
    int size = SPECTRUM_SIZE;
    for (span.end = span.first; span.end < t->count && t->sample[span.end].test_time_s <= until_s;) span.end++;
    *s = (struct spectrum){.omega = omega, .harmonics = SPECTRUM_HARMONICS};
    int good = add_samples(s, t, &span, product, s->mean, ramp, &longest_s);
    double step_s = (until_s - from_s) / (span.end - span.first);
    if (good <= 2 * size || spectrum_gap(t, from_s, until_s) > fmax(PI / omega / s->harmonics, 2.5 * step_s)) return false;
    /* The ridge keeps the series finite beyond the first and last sample, where it is not used. */
    for (int a = 0; a < size; a++) product[a][a] += RIDGE_PER_SAMPLE * good;
    if (!dense_factor(size, SPECTRUM_SIZE, product[0])) return false;
    for (int a = 0; a < size; a++) {
        memset(inverse[a], 0, sizeof inverse[a]);
        inverse[a][a] = 1.0;
        dense_solve(size, SPECTRUM_SIZE, product[0], inverse[a]);
    }
    for (int ch = 0; ch < CHANNELS; ch++)
        for (int k = 0; k < LEGS; k++) dense_solve(size, SPECTRUM_SIZE, product[0], s->mean[ch][k]);
    add_noise(s, t, &span, s->mean, square_sum);
    for (int ch = 0; ch < CHANNELS; ch++)
        for (int k = 0; k < LEGS; k++) {
            s->noise[ch][k] = sqrt(square_sum[ch][k] / (good - size));
            for (int a = 0; a < size; a++) s->std[ch][k][a] = s->noise[ch][k] * sqrt(fmax(inverse[a][a], 0.0));
        }
    s->speed_gain = speed_gain(s, t, &span, inverse);
    return true;
}
