#include "recording.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void recording_init(struct recording *r, const struct params *params) { *r = (struct recording){.params = params}; }

void recording_free(struct recording *r) {
    for (int i = 0; i < r->tests; i++) free(r->test[i].sample);
    r->tests = 0;
}

/* The test that the cycle belongs to: the last one, or a new one. */
static struct recording_test *place(struct recording *r, const struct cycle *c) {
    struct recording_test *t = r->tests ? &r->test[r->tests - 1] : NULL;
    bool same = t && t->test == c->test && t->dof == c->dof && (!t->count || c->test_time_s > t->sample[t->count - 1].test_time_s);
    if (same) return t;
    if (r->tests == RECORDING_TESTS) return NULL;
    const struct test_params *p = &r->params->tests;
    t = &r->test[r->tests++];
    *t = (struct recording_test){.test = c->test, .dof = c->dof, .frequency_hz = p->frequency_hz,
                                 .amplitude = c->dof < DOF_PHI ? p->amplitude_m : p->amplitude_rad, .first = -1};
    return t;
}

static bool finite_all(const double *x) {
    double sum = 0.0;
    for (int i = 0; i < LEGS; i++) sum += fabs(x[i]);
    return isfinite(sum);
}

int recording_add(struct recording *r, const struct cycle *c, struct error *error) {
    if (c->dof == DOF_NONE || (c->phase != PHASE_RAMP_IN && c->phase != PHASE_EVALUATE)) return STATUS_OK;
    struct recording_test *t = place(r, c);
    if (!t) return error_set(error, STATUS_USAGE, "the log has more than %d tests", RECORDING_TESTS);
    if (t->count == t->capacity) {
        int capacity = t->capacity ? 2 * t->capacity : 4096;
        struct recording_sample *more = realloc(t->sample, (size_t)capacity * sizeof *more);
        if (!more) return error_set(error, STATUS_IO, "out of memory for the log's samples");
        t->sample = more, t->capacity = capacity;
    }
    struct recording_sample *s = &t->sample[t->count++];
    s->test_time_s = c->test_time_s;
    memcpy(s->length_m, c->in.length_m, sizeof s->length_m);
    memcpy(s->p1_pa, c->in.p1_pa, sizeof s->p1_pa);
    memcpy(s->p2_pa, c->in.p2_pa, sizeof s->p2_pa);
    memcpy(s->valve, c->out.valve, sizeof s->valve);
    memcpy(s->ref, c->ref, sizeof s->ref);
    s->good = !c->in.flags && finite_all(s->length_m) && finite_all(s->p1_pa) && finite_all(s->p2_pa) && finite_all(s->valve);
    if (c->phase == PHASE_EVALUATE) {
        if (t->first < 0) t->first = t->count - 1;
        t->end = t->count;
    }
    return STATUS_OK;
}
