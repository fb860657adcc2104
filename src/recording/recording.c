#include "recording.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "force.h"
#include "numeric.h"
#include "params.h"

enum {
    LONG = 400000,     /* number of samples of a test at which every other block is dropped:
                        * thirteen minutes at 2 ms */
    BLOCK = LONG / 16  /* samples in a block: 50 s at 2 ms, long enough for whole segments of any
                        * motion (motion.h) */
};

void recording_init(struct recording *r, const struct params *params) {
    *r = (struct recording){.params = params, .runs = 1, .run = {params->tests}};
}

int recording_begin(struct recording *r, const struct test_params *tests, struct error *error) {
    if (r->runs == RECORDING_RUNS) return error_set(error, STATUS_USAGE, "more than %d logs of one machine", RECORDING_RUNS);
    r->run[r->runs++] = *tests;
    r->measured_before = r->measured;
    r->measured = (struct recording_measured){0};
    return STATUS_OK;
}

void recording_free(struct recording *r) {
    while (r->tests) recording_remove(r, r->tests - 1);
}

/* Returns the number of the current run's first test, which is one above the largest number in
 * earlier runs. */
static int tests_before(const struct recording *r) {
    int n = 0;
    for (int i = 0; i < r->tests; i++)
        if (r->test[i].run < r->runs - 1 && r->test[i].test >= n) n = r->test[i].test + 1;
    return n;
}

/* Returns the test that the cycle belongs to: the last one, or a new one. NULL if there is no room
 * for it. */
static struct recording_test *place(struct recording *r, const struct cycle *c) {
    struct recording_test *t = r->tests ? &r->test[r->tests - 1] : NULL;
    int run = r->runs - 1, test = tests_before(r) + c->test;
    bool same = t && t->run == run && t->test == test && t->dof == c->dof &&
                (!t->count || c->test_time_s > t->sample[t->count - 1].test_time_s);
    if (same) return t;
    if (r->tests == RECORDING_TESTS) return NULL;
    const struct test_params *p = &r->run[run];
    t = &r->test[r->tests++];
    *t = (struct recording_test){.run = run, .test = test, .dof = c->dof, .first = -1};
    bool axis = c->dof != DOF_NONE; /* a motion of several axes has neither frequency nor
                                     * amplitude */
    t->frequency_hz = t->stated_hz = axis ? p->hz[c->dof] : (double)NAN;
    t->amplitude = axis ? p->amplitude[c->dof] : (double)NAN;
    return t;
}

/* Refuses a sample if `numbers` is false, unless it is refused already. */
static void need(struct recording_sample *s, bool numbers) {
    if (!s->refused && !numbers) s->refused = REFUSED_NO_NUMBER;
}

struct recording_sample recording_sample_of(const struct params *params, const struct cycle *c) {
    struct cylinder_areas areas = cylinder_areas(&params->actuator);
    int legs = params_legs(params), axes = params_mechanism(params)->axes;
    struct recording_sample s = {.test_time_s = c->test_time_s, .clock_s = 1e-9 * (double)c->in.time_ns};
    memcpy(s.length_m, c->in.length_m, (size_t)legs * sizeof(double));
    memcpy(s.p1_pa, c->in.p1_pa, (size_t)legs * sizeof(double));
    memcpy(s.p2_pa, c->in.p2_pa, (size_t)legs * sizeof(double));
    memcpy(s.valve, c->out.valve, (size_t)legs * sizeof(double));
    memcpy(s.ref, c->ref, (size_t)axes * sizeof(double));
    bool pressures = all_finite(legs, s.p1_pa) && all_finite(legs, s.p2_pa);
    for (int k = 0; k < legs; k++) s.force_n[k] = pressures ? leg_force(&areas, k, s.p1_pa[k], s.p2_pa[k]) : c->force_n[k];
    s.refused = refusal_of(c, legs);
    need(&s, isfinite(s.test_time_s) && all_finite(legs, s.force_n));
    return s;
}

int recording_append(struct recording_test *t, const struct recording_sample *s, struct error *error) {
    if (t->count == t->capacity) {
        int capacity = t->capacity ? 2 * t->capacity : LONG / 128; /* LONG is reached after seven
                                                                    * doublings */
        struct recording_sample *more = t->capacity < 1 << 29 ? realloc(t->sample, (size_t)capacity * sizeof *more) : NULL;
        if (!more) return error_set(error, STATUS_IO, "out of memory for the log's samples");
        t->sample = more, t->capacity = capacity;
    }
    t->sample[t->count++] = *s;
    return STATUS_OK;
}

/* Refuses the next sample if it falls into a dropped block. Blocks are counted in samples, not in
 * time, so that thinning halves their number whatever the time stamps say. */
static enum refusal surplus(struct recording_test *t) {
    return t->offered++ / BLOCK % (INT64_C(1) << t->thinned) ? REFUSED_SURPLUS : REFUSED_NOT;
}

/* Refuses a cycle that is neither in a ramp-in nor in an evaluated part. Without a tested axis
 * every cycle of a test is used, because an imported recording of any motion has no phases. */
static enum refusal outside(const struct cycle *c) {
    bool kept = c->dof == DOF_NONE ? c->test >= 0 : c->phase == PHASE_RAMP_IN || c->phase == PHASE_EVALUATE;
    return kept ? REFUSED_NOT : REFUSED_OUTSIDE;
}

/* Drops every other block of a test. The first block stays; it contains the ramp-in, unless the
 * ramp-in is longer than a block. */
static void thin(struct recording_test *t) {
    int kept = 0, first = t->first, end = t->end;
    t->thinned++;
    for (int i = 0; i < t->count; i++) {
        if (i == first) t->first = kept;
        if (i == end) t->end = kept;
        if (i / BLOCK % 2 == 0) t->sample[kept++] = t->sample[i];
    }
    if (end == t->count) t->end = kept;
    t->count = kept;
}

static void note_measured(struct recording_measured *m, const struct recording_sample *s, const struct mechanism *mechanism) {
    int legs = mechanism->legs;
    m->pressures = m->pressures || (all_finite(legs, s->p1_pa) && all_finite(legs, s->p2_pa));
    m->force = m->force || all_finite(legs, s->force_n);
    m->valve = m->valve || all_finite(legs, s->valve);
    m->reference = m->reference || all_finite(mechanism->axes, s->ref);
}

int recording_add(struct recording *r, const struct cycle *c, struct error *error) {
    if (outside(c)) return STATUS_OK;
    struct recording_test *t = place(r, c);
    if (!t) return error_set(error, STATUS_USAGE, "more than %d tests, or cycles that are not in the order of their time", RECORDING_TESTS);
    struct recording_sample s = recording_sample_of(r->params, c);
    if (surplus(t)) return STATUS_OK;
    int status = recording_append(t, &s, error);
    if (status) return status;
    note_measured(&r->measured, &s, params_mechanism(r->params));
    if (c->dof == DOF_NONE || c->phase == PHASE_EVALUATE) {
        if (t->first < 0) t->first = t->count - 1;
        t->end = t->count;
    }
    if (t->count == LONG) thin(t);
    return STATUS_OK;
}

void recording_remove(struct recording *r, int test) {
    if (!r->test[test].borrowed) free(r->test[test].sample);
    free(r->test[test].measured);
    memmove(r->test + test, r->test + test + 1, (size_t)(--r->tests - test) * sizeof *r->test);
}

void recording_settle(struct recording *r) {
    const struct recording_measured *m = &r->measured;
    int legs = params_legs(r->params);
    for (int i = 0; i < r->tests; i++)
        for (int j = 0; j < r->test[i].count; j++) {
            struct recording_sample *s = &r->test[i].sample[j];
            if (m->pressures) need(s, all_finite(legs, s->p1_pa) && all_finite(legs, s->p2_pa));
            else memset(s->p1_pa, 0, sizeof s->p1_pa), memset(s->p2_pa, 0, sizeof s->p2_pa);
            if (m->valve) need(s, all_finite(legs, s->valve));
            else memset(s->valve, 0, sizeof s->valve);
        }
}

int recording_at(const struct recording_test *t, double test_time_s) {
    int from = 0, until = t->count;
    while (from < until) {
        int middle = from + (until - from) / 2;
        if (t->sample[middle].test_time_s < test_time_s) from = middle + 1;
        else until = middle;
    }
    return from;
}

const char *recording_test_name(const struct recording_test *t) { return t->dof == DOF_NONE ? "none" : dof_names[t->dof]; }

int recording_first_of_run(const struct recording *r) {
    int first = 0;
    while (first < r->tests - 1 && r->test[first].run < r->runs - 1) first++;
    return first;
}

bool recording_begins(const struct recording *r, int test) { return !test || r->test[test].sample != r->test[test - 1].sample; }

const struct recording_test *recording_find(const struct recording *r, int run, enum dof dof) {
    for (int i = 0; i < r->tests; i++)
        if (r->test[i].run == run && r->test[i].dof == dof) return &r->test[i];
    return NULL;
}

double recording_clock(const struct recording *r, double *std) {
    double xx = 0.0, xy = 0.0, yy = 0.0;
    int n = 0;
    for (int i = 0; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        double x = 0.0, y = 0.0;
        int count = t->end - t->first;
        for (int j = t->first; j < t->end; j++)
            x += t->sample[j].test_time_s / count, y += (t->sample[j].clock_s - t->sample[t->first].clock_s) / count;
        for (int j = t->first; j < t->end; j++) {
            double dx = t->sample[j].test_time_s - x, dy = t->sample[j].clock_s - t->sample[t->first].clock_s - y;
            xx += dx * dx, xy += dx * dy, yy += dy * dy;
        }
        n += count - 1;
    }
    double ratio = xy / xx;
    *std = sqrt(fmax(yy - ratio * xy, 0.0) / (n - 1) / xx);
    if (!(yy > 0.0)) return NAN; /* a time stamp that stands still is no clock */
    return ratio;
}
