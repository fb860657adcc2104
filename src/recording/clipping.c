#include "clipping.h"

#include <math.h>

#include "units.h"

/* Least share of the samples that must be at the channel's largest value, or, for a length, at its
 * smallest, if the channel does not stay at its known `top`. With fewer it is not clipped. */
static const double CLIPPED = 0.12;
/* A channel counts as clipped only if the number of samples at its largest value exceeds this times
 * the number that a sinusoid of the same resolution has there. */
static const double CLIPPED_TIMES = 2.0;
/* Mean change of a length in the last step before its largest value, as a share of the largest
 * change between any two successive samples. Above this share an end stop stopped the leg; below
 * it, friction or the motion itself may have done so. */
static const double ABRUPT = 0.3;

static const size_t STRIDE = sizeof(struct recording_sample) / sizeof(double);
_Static_assert(sizeof(struct recording_sample) % sizeof(double) == 0, "samples are addressed as doubles");

/* Returns the number of samples at the channel's largest value, or, with sign -1, at its smallest.
 * Returns 0 if they are too few (CLIPPED, CLIPPED_TIMES), or if a smooth channel does not arrive
 * there at speed (ABRUPT). */
static int plateau(const struct recording_test *t, const double *first, double sign, const struct recording_scale *scale) {
    double top = -HUGE_VAL, next = -HUGE_VAL, bottom = HUGE_VAL, before = NAN, entering = 0.0, fastest = 0.0;
    int there = 0, n = 0, entries = 0;
    for (int i = t->first; i < t->end; i++) {
        double value = sign * first[(size_t)(i - t->first) * STRIDE];
        if (t->sample[i].refused) continue;
        if (value > top) next = top, top = value, there = entries = 0, entering = 0.0;
        else if (value < top) next = fmax(next, value);
        if (value == top && before < top) entering += top - before, entries++;
        fastest = fmax(fastest, fabs(value - before));
        there += value == top, n++;
        bottom = fmin(bottom, value), before = value;
    }
    double share = acos(fmax(1.0 - 2.0 * fmax(top - next, scale->step) / (top - bottom), -1.0)) / PI;
    bool abrupt = !scale->smooth || entering > ABRUPT * fastest * entries;
    return abrupt && there > fmax(CLIPPED, CLIPPED_TIMES * share) * n ? there : 0;
}

int recording_clipped(const struct recording_test *t, const double *first, const struct recording_scale *scale) {
    int clipped = 0, few = (t->end - t->first) / 50;
    for (int i = t->first; i < t->end; i++) clipped += first[(size_t)(i - t->first) * STRIDE] >= scale->top;
    if (clipped <= few) clipped = plateau(t, first, 1.0, scale);
    /* The low end is examined for lengths only. Other channels may rest there: pressures, for
     * example, at the tank's pressure. */
    if (clipped <= few && scale->smooth) clipped = plateau(t, first, -1.0, scale);
    return clipped > few ? clipped : 0;
}
