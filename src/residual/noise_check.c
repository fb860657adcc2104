#include "noise_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "numeric.h"
#include "params.h"
#include "sort.h"
#include "whiten.h"

/* Median, for an even number the lower middle value. Sorts the values. */
static double middle(int count, double *value) {
    sort_ascending(count, value);
    return value[(count - 1) / 2];
}

static const enum channel kind_channel[RESIDUALS] = {CHANNEL_FORCE, CHANNEL_P1, CHANNEL_P2};

/* Mean of a channel over the instants of a test. */
static double level_of(const struct residual_test *t, enum channel channel, int leg) {
    double sum = 0.0;
    for (int i = 0; i < t->phases; i++) {
        double value[3];
        spectrum_at(t->spectrum.mean[channel][leg], t->harmonics, t->spectrum.omega, t->cycle + i * SPECTRUM_SIZE, value);
        sum += value[0];
    }
    return sum / t->phases;
}

typedef double levels[RESIDUALS][LEGS];

/* Computes the means of the channels over all segments. A force that is constant within each
 * segment, as dry friction is in a slow stroke, varies from one segment to the next. */
static void mean_levels(const struct recording *r, const struct residual_data *data, levels mean) {
    int segments = 0;
    memset(mean, 0, sizeof(levels));
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < data->tests; i++) {
            const struct residual_test *t = &data->test[i];
            if (t->spectrum.cycles || t->of < recording_first_of_run(r)) continue;
            if (!pass) segments++;
            for (int kind = 0; pass && kind < RESIDUALS; kind++)
                for (int k = 0; k < t->legs; k++) mean[kind][k] += level_of(t, kind_channel[kind], k) / segments;
        }
}

/* Share of noise in a test's mean square variation: the share in the force, or, if the chambers are
 * evaluated, the median of the shares in the force and both pressures, because a chamber may hardly
 * change its pressure. mean: means of the channels over all segments (mean_levels()); a segment's
 * difference from them counts as variation. If it is NULL, only variation within the segment
 * counts. */
static double noise_share(const struct residual_test *t, const struct params *params, double (*mean)[LEGS], struct whitener *w) {
    int kinds = t->chambers ? RESIDUALS : 1;
    double share[RESIDUALS];
    whitener_init(w, t, params, NOISE_ALONE);
    for (int kind = 0; kind < kinds; kind++) {
        double noise = 0.0, varies = 0.0;
        for (int k = 0; k < t->legs; k++) {
            /* in a cycle the constant is left out, because it is undetermined in a chamber whose
             * valve stays shut */
            for (int a = t->spectrum.cycles ? 1 : 0; a < t->size; a++) noise += t->weight[a] * w->noise[k][a][kind];
            varies += residual_variation(t, kind_channel[kind], k);
            if (mean && !t->spectrum.cycles) varies += square(level_of(t, kind_channel[kind], k) - mean[kind][k]);
        }
        share[kind] = varies > 0.0 ? noise / varies : 1.0;
    }
    return middle(kinds, share);
}

/* Marks segments that are mostly noise, so that they are not evaluated. Returns the median share of
 * noise in the rms variation. */
static double mark_noise(struct recording *r, const struct residual_data *data, double (*mean)[LEGS], struct whitener *w) {
    double share[RECORDING_TESTS];
    int n = 0;
    for (int i = 0; i < data->tests; i++) {
        struct recording_test *t = &r->test[data->test[i].of];
        if (data->test[i].of < recording_first_of_run(r)) continue;
        share[n] = noise_share(&data->test[i], r->params, mean, w);
        t->refused = t->segment_s > 0.0 && !(sqrt(share[n]) <= NOISE_MOST) ? REFUSED_NOISE : REFUSED_NOT;
        n++;
    }
    return n ? sqrt(middle(n, share)) : 0.0;
}

int noise_check(struct recording *r, const struct residual_data *data, double *share, struct error *error) {
    struct whitener *w = malloc(sizeof *w);
    levels mean;
    if (!w) return error_set(error, STATUS_IO, "out of memory");
    *share = mark_noise(r, data, NULL, w);
    mean_levels(r, data, mean);
    if (*share > NOISE_MOST) *share = mark_noise(r, data, mean, w);
    free(w);
    return STATUS_OK;
}
