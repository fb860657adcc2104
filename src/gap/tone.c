#include "tone.h"

#include <math.h>
#include <stdlib.h>

#include "memory.h"
#include "parallel.h"
#include "units.h"

enum {
    TONE_BINS = 3,       /* least distance of a tone from a harmonic of the motion, in bins */
    TONE_SAMPLES = 4096, /* most samples of a test that are searched: eight seconds suffice, and the
                          * computing time grows with the square of the number */
};
static const double TONE_STEP_S = 2e-3;     /* longest time over which samples are averaged before
                                             * the search. With this, tones are found up to 250 Hz,
                                             * unless the samples of the log are farther apart */
static const double TONE_POWER = 12.0;      /* least power of a tone, averaged over six legs, as a
                                             * multiple of the power of white noise in a bin; noise
                                             * gives 1 +- 0.4 */
static const double TONE_POWER_ONE = 30.0;  /* least power of a tone with a single leg, as a
                                             * multiple of the power of white noise in a bin; the
                                             * strongest of 20,000 bins of noise has 10 */

/* Fills `rest` with the samples of a channel, without their mean cycle, constant and trend. Refused
 * samples count as 0 before the trend is removed. */
static void leave_rest(const struct spectrum *s, const struct recording_test *t, enum channel channel, int leg, double *rest) {
    int n = t->end - t->first;
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, value[3];
    for (int i = 0; i < n; i++) {
        const struct recording_sample *sample = &t->sample[t->first + i];
        spectrum_value(s->mean[channel][leg], s->harmonics, s->omega, sample->test_time_s, value);
        rest[i] = sample->refused ? 0.0 : spectrum_channel(sample, channel)[leg] - value[0];
        x += (double)i / n, y += rest[i] / n;
    }
    for (int i = 0; i < n; i++) xx += (i - x) * (i - x), xy += (i - x) * rest[i];
    for (int i = 0; i < n; i++) rest[i] -= y + xy / xx * (i - x);
}

enum { AT_ONCE = 8 };

/* Power |sum rest[i] exp(-2 pi j b i / n)|^2 of AT_ONCE bins b, from `first` on, by rotating
 * phasors. */
static void power_at(int n, const double *rest, int first, double power[AT_ONCE]) {
    double c[AT_ONCE], s[AT_ONCE], re[AT_ONCE], im[AT_ONCE], sum_re[AT_ONCE] = {0}, sum_im[AT_ONCE] = {0};
    for (int j = 0; j < AT_ONCE; j++) {
        double radians = 2.0 * PI * (first + j) / n;
        c[j] = cos(radians), s[j] = sin(radians), re[j] = 1.0, im[j] = 0.0;
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < AT_ONCE; j++) {
            sum_re[j] += rest[i] * re[j], sum_im[j] += rest[i] * im[j];
            double next = re[j] * c[j] - im[j] * s[j];
            im[j] = re[j] * s[j] + im[j] * c[j], re[j] = next;
        }
    for (int j = 0; j < AT_ONCE; j++) power[j] = sum_re[j] * sum_re[j] + sum_im[j] * sum_im[j];
}

/* True if a frequency is above that of the motion, because slower changes are drift, and off its
 * harmonics. All harmonics count, even those above the highest of the mean cycle, because rounding
 * errors excite them. */
static bool off_harmonics(const struct spectrum *s, double hz, double width_hz) {
    double base_hz = s->omega / (2.0 * PI), nearest_hz = base_hz * round(hz / base_hz);
    return hz > base_hz && fabs(hz - nearest_hz) >= width_hz;
}

/* Decimates values in place: each of the n results is the mean of `many` values. */
static void thin(int n, int many, double *value) {
    for (int i = 0; i < n; i++) {
        double sum = 0.0;
        for (int j = 0; j < many; j++) sum += value[i * many + j] / many;
        value[i] = sum;
    }
}

/* Applies a Hann window in place, so that a transient at an end of the record does not look like a
 * tone beside a harmonic of the motion. Returns the sum of the weights. */
static double window(int n, double *value) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        double weight = 0.5 - 0.5 * cos(2.0 * PI * (i + 0.5) / n);
        value[i] *= weight, sum += weight;
    }
    return sum;
}

struct tone tone_in(const struct spectrum *s, const struct recording_test *t, double sampling_s, enum channel channel) {
    int all = t->end - t->first, many = (int)fmax(TONE_STEP_S / sampling_s, 1.0), n = (int)fmin(all / many, TONE_SAMPLES);
    int bins = n / 2;
    struct tone tone = {0};
    double *rest = memory_get((size_t)all, sizeof *rest), *power = memory_get((size_t)bins + 1, sizeof *power), step_s;
    double *absolute = memory_get((size_t)bins + 1, sizeof *absolute);
    double weights = 0.0;
    int legs = 0; /* number of legs that have the channel */
    for (int k = 0; k < LEGS; k++) {
        double square = 0.0;
        leave_rest(s, t, channel, k, rest);
        thin(n, many, rest);
        weights = window(n, rest);
        for (int i = 0; i < n; i++) square += rest[i] * rest[i];
        legs += square > 0.0;
        for (int first = TONE_BINS; first < bins && square > 0.0; first += AT_ONCE) {
            double p[AT_ONCE];
            power_at(n, rest, first, p);
            for (int b = first; b < bins && b < first + AT_ONCE; b++) power[b] += p[b - first] / square, absolute[b] += p[b - first];
        }
    }
    step_s = (t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s) / (all - 1) * many;
    for (int b = TONE_BINS; b < bins && legs; b++)
        if (power[b] / legs > tone.power && off_harmonics(s, b / (n * step_s), TONE_BINS / (n * step_s)))
            tone = (struct tone){b / (n * step_s), sqrt(2.0 * absolute[b] / legs) / weights, power[b] / legs};
    free(rest);
    free(power);
    free(absolute);
    return tone;
}

enum { TONE_CHANNELS = 3 };
static const struct {
    enum channel channel;
    enum gap_channel name;
} tone_channel[TONE_CHANNELS] = {{CHANNEL_P1, GAP_P1}, {CHANNEL_P2, GAP_P2}, {CHANNEL_LENGTH, GAP_LENGTH}};

struct tones {
    const struct recording *recording;
    struct tone (*of)[TONE_CHANNELS]; /* [tests]: strongest tone of each channel */
};

static void find_in_test(void *context, int i) {
    const struct tones *tones = context;
    const struct recording_test *test = &tones->recording->test[i];
    const struct spectrum *s = measured_spectrum(test, CYCLES_ALL);
    for (int j = 0; j < TONE_CHANNELS && s; j++) tones->of[i][j] = tone_in(s, test, test->measured->step_s, tone_channel[j].channel);
}

struct gap_tone tone_find(const struct recording *recording, int threads, double share) {
    struct gap_tone found = {0};
    struct tones tones = {recording, memory_get((size_t)recording->tests, sizeof *tones.of)};
    double most = share * (params_legs(recording->params) > 1 ? TONE_POWER : TONE_POWER_ONE);
    parallel_run(threads, recording->tests, find_in_test, &tones);
    for (int i = 0; i < recording->tests; i++)
        for (int j = 0; j < TONE_CHANNELS; j++) {
            struct tone tone = tones.of[i][j];
            if (!(tone.power > most)) continue;
            most = tone.power;
            found = (struct gap_tone){tone.hz, tone.rms, tone_channel[j].name, recording->test[i].dof, recording->test[i].test};
        }
    free(tones.of);
    return found;
}
