#include "survey.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "clipping.h"
#include "kinematics.h"
#include "noise.h"
#include "params.h"

static const double FULL_SCALE = 0.999; /* a pressure sensor saturates at this share of its full
                                         * scale, which allows for its last count */

const char *const survey_names[SURVEY_KINDS] = {"length", "reference", "p1", "p2", "force", "command"};

/* Offset of each kind's first channel in a sample, in bytes. */
static const size_t offsets[SURVEY_KINDS] = {
    [SURVEY_LENGTH] = offsetof(struct recording_sample, length_m), [SURVEY_REFERENCE] = offsetof(struct recording_sample, ref),
    [SURVEY_P1] = offsetof(struct recording_sample, p1_pa),        [SURVEY_P2] = offsetof(struct recording_sample, p2_pa),
    [SURVEY_FORCE] = offsetof(struct recording_sample, force_n),   [SURVEY_COMMAND] = offsetof(struct recording_sample, valve),
};

static const size_t STRIDE = sizeof(struct recording_sample) / sizeof(double);

static const double *channel_of(const struct recording_sample *sample, enum survey_kind kind, int i) {
    return (const double *)(const void *)((const char *)sample + offsets[kind]) + i;
}

double survey_value(const struct recording_sample *sample, enum survey_kind kind, int i) { return *channel_of(sample, kind, i); }

double survey_seconds(const struct survey *s) {
    const struct recording_test *t = &s->test;
    return t->count ? t->sample[t->count - 1].test_time_s - t->sample[0].test_time_s : 0.0;
}

void survey_init(struct survey *s, const struct params *params, enum dof dof, const char *name) {
    const struct mechanism *mechanism = params_mechanism(params);
    *s = (struct survey){.test = {.dof = dof, .first = -1, .stated_hz = (double)NAN}, .mechanism = mechanism};
    s->evaluated = -1, s->steady_s = s->ramp_least_s = (double)NAN;
    s->stated_hz = s->stated_amplitude = (double)NAN;
    if (dof != DOF_NONE) s->stated_hz = s->test.stated_hz = params->tests.hz[dof], s->stated_amplitude = params->tests.amplitude[dof];
    for (int kind = 0; kind < SURVEY_KINDS; kind++)
        s->channel[kind] = (struct survey_channel){.of = kind == SURVEY_REFERENCE ? mechanism->axes : mechanism->legs,
                                                   .low = (double)NAN,
                                                   .high = (double)NAN,
                                                   .noise = (double)NAN};
    if (!mechanism->force_sensor) s->channel[SURVEY_FORCE].of = 0;
    snprintf(s->name, sizeof s->name, "%s", name);
}

int survey_add(struct survey *s, const struct params *params, const struct cycle *c, struct error *error) {
    struct recording_sample sample = recording_sample_of(params, c);
    const struct recording_test *t = &s->test;
    if (!isfinite(sample.test_time_s) || (t->count && !(sample.test_time_s > t->sample[t->count - 1].test_time_s))) {
        s->unplaced++;
        return STATUS_OK;
    }
    /* Only a force sensor's reading is kept; a force that is computed from the pressures contains
     * nothing new. */
    memcpy(sample.force_n, c->force_n, sizeof sample.force_n);
    sample.refused = refusal_of(c, s->channel[SURVEY_LENGTH].of);
    s->flagged += c->in.flags != 0;
    if (s->evaluated < 0 && c->phase == PHASE_EVALUATE) s->evaluated = t->count;
    return recording_append(&s->test, &sample, error);
}

static void take_channel(const struct recording_test *t, enum survey_kind kind, int i, struct survey_channel *c) {
    double low = (double)NAN, high = (double)NAN;
    for (int j = 0; j < t->count; j++) {
        double value = survey_value(&t->sample[j], kind, i);
        /* fmin and fmax skip NaN */
        if (isfinite(value)) low = fmin(low, value), high = fmax(high, value);
    }
    if (isnan(low)) return;
    struct noise noise = noise_measure(t->count, channel_of(t->sample, kind, i), STRIDE);
    c->there |= 1u << i;
    if (kind != SURVEY_REFERENCE && low == high) c->dead |= 1u << i;
    c->low = fmin(c->low, low), c->high = fmax(c->high, high);
    c->noise = fmax(c->noise, noise.rms);
    if (noise.step > 0.0) c->step = c->step > 0.0 ? fmin(c->step, noise.step) : noise.step;
}

/* Finds saturated channels in the longest steady segment, or, without one, in the longest moving
 * one. At rest every reading stays at one value, saturated or not. */
static void find_clipped(struct survey *s, const struct params *params) {
    const struct segment *p = segments_longest(&s->segments, SEGMENT_STEADY);
    struct recording_test part = s->test;
    if (!p) p = segments_longest(&s->segments, SEGMENT_MOVING);
    if (!p) return;
    part.first = p->first, part.end = p->end;
    for (int kind = 0; kind < SURVEY_KINDS; kind++) {
        struct survey_channel *c = &s->channel[kind];
        struct recording_scale scale = {.top = HUGE_VAL, .step = c->step, .smooth = kind == SURVEY_LENGTH};
        if (kind == SURVEY_P1 || kind == SURVEY_P2) scale.top = FULL_SCALE * params->sensors.pressure_full_scale_pa;
        if (kind == SURVEY_COMMAND) scale.top = 1.0;
        for (int i = 0; i < c->of && kind != SURVEY_REFERENCE; i++) {
            bool looked_at = (c->there & ~c->dead) >> i & 1u;
            if (looked_at && recording_clipped(&part, channel_of(&part.sample[part.first], (enum survey_kind)kind, i), &scale))
                c->clipped |= 1u << i;
        }
    }
}

static bool lacks_number(const struct survey *s, const struct recording_sample *sample) {
    for (int kind = 0; kind < SURVEY_KINDS; kind++)
        for (int i = 0; i < s->channel[kind].of; i++)
            if (s->channel[kind].there >> i & 1u && !isfinite(survey_value(sample, (enum survey_kind)kind, i))) return true;
    return false;
}

/* Position on the tested axis, m or rad, or length of the leg if no axis is tested or the mechanism
 * has no pose. NaN for a refused sample, or if no pose has its lengths. */
static double place_of(const struct survey *s, const struct kinematics *k, const struct recording_sample *sample, int leg) {
    double pose[DOFS] = {0};
    if (sample->refused) return (double)NAN;
    if (!s->mechanism->pose || s->test.dof == DOF_NONE) return sample->length_m[leg];
    return fk_solve(k, sample->length_m, pose).converged ? pose[s->test.dof] : (double)NAN;
}

static double swing(const struct survey *s, const struct kinematics *k, int leg, int first, int end) {
    double low = (double)NAN, high = (double)NAN;
    for (int i = first; i < end; i++) {
        double place = place_of(s, k, &s->test.sample[i], leg);
        low = fmin(low, place), high = fmax(high, place);
    }
    return 0.5 * (high - low);
}

static void find_amplitude(struct survey *s, const struct params *params) {
    struct kinematics k;
    struct error unsaid;
    const struct segment *p = segments_longest(&s->segments, SEGMENT_STEADY);
    int legs = s->test.dof == DOF_NONE ? s->mechanism->legs : 1;
    s->measured_hz = p ? p->frequency_hz : (double)NAN;
    s->amplitude = (double)NAN;
    if (kinematics_init(&k, params, &unsaid)) return;
    for (int leg = 0; leg < legs; leg++) s->amplitude = fmax(s->amplitude, swing(s, &k, leg, p ? p->first : 0, p ? p->end : s->test.count));
}

/* Finds whether the evaluated part begins before the motion is steady. One period is added to the
 * least ramp, because a steady segment tolerates cycles that differ by 5 %, so that its first cycle
 * may still be the end of the ramp. */
static void find_ramp(struct survey *s) {
    const struct segment *p = s->segments.segment, *end = p + s->segments.count;
    while (p < end && !(p->kind == SEGMENT_STEADY && p->end > s->evaluated)) p++;
    if (s->evaluated < 0 || p == end || p->first <= s->evaluated) return;
    s->steady_s = s->test.sample[p->first].test_time_s;
    s->ramp_least_s = s->steady_s + 1.0 / p->frequency_hz;
}

int survey_end(struct survey *s, const struct params *params, struct error *error) {
    struct recording_test *t = &s->test;
    t->first = t->count ? 0 : -1, t->end = t->count;
    s->sampling = sampling_measure(t);
    for (int kind = 0; kind < SURVEY_KINDS && t->count; kind++)
        for (int i = 0; i < s->channel[kind].of; i++) take_channel(t, (enum survey_kind)kind, i, &s->channel[kind]);
    for (int i = 0; i < t->count; i++) s->not_a_number += lacks_number(s, &t->sample[i]);
    int status = segments_find(&s->segments, t, s->sampling.step_s, s->channel[SURVEY_LENGTH].of, error);
    if (status) return status;
    find_clipped(s, params);
    find_amplitude(s, params);
    find_ramp(s);
    return STATUS_OK;
}

void survey_free(struct survey *s) {
    segments_free(&s->segments);
    free(s->test.sample);
    s->test = (struct recording_test){.first = -1};
}
