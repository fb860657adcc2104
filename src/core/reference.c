#include "reference.h"

#include <math.h>
#include <string.h>

#include "units.h"

static const double brake_longest_s = 1.0;

static int64_t ticks_of(double seconds, double dt_s) { return llround(seconds / dt_s); }

/* 3q^2 - 2q^3 from 0 to 1 over [0, length]. */
static double smooth(int64_t ticks, int64_t length) {
    if (ticks <= 0) return 0.0;
    if (ticks >= length) return 1.0;
    double q = (double)ticks / (double)length;
    return q * q * (3.0 - 2.0 * q);
}

void reference_hold(struct reference *r, const double pose[DOFS]) {
    struct reference hold = {.mode = REFERENCE_HOLD, .dof = DOF_NONE};
    memcpy(hold.to, pose, sizeof hold.to); /* pose may be r->to */
    *r = hold;
}

void reference_move(struct reference *r, const double from[DOFS], const double rate_from[DOFS], const double to[DOFS], double duration_s) {
    struct reference move = {.mode = REFERENCE_MOVE, .dof = DOF_NONE, .duration_s = duration_s, .ticks = 1};
    memcpy(move.from, from, sizeof move.from);
    memcpy(move.rate_from, rate_from, sizeof move.rate_from);
    memcpy(move.to, to, sizeof move.to);
    *r = move;
}

void reference_test(struct reference *r, enum dof dof, const struct trajectory *trajectory, const struct test_params *t, double dt_s) {
    *r = (struct reference){.mode = REFERENCE_TEST, .dof = dof, .ticks = -ticks_of(t->settle_s, dt_s)};
    r->trajectory = dof == DOF_NONE ? trajectory : NULL;
    r->ramp_out_tick = ticks_of(t->ramp_s, dt_s) + ticks_of(r->trajectory ? trajectory_s(trajectory) : t->duration_s, dt_s);
}

void reference_stop(struct reference *r) {
    if (r->mode == REFERENCE_TEST && r->ticks < r->ramp_out_tick) r->ramp_out_tick = r->ticks;
}

static void move_step(struct reference *r, double dt_s, struct reference_sample *s) {
    double t = (double)r->ticks * dt_s, brake_s = fmin(r->duration_s, brake_longest_s);
    double q = fmin(t / r->duration_s, 1.0), arrived = q * q * (3.0 - 2.0 * q);
    double b = fmin(t / brake_s, 1.0), coasted_s = brake_s * b * (1.0 - b) * (1.0 - b);
    for (int i = 0; i < DOFS; i++) s->pose[i] = r->from[i] + arrived * (r->to[i] - r->from[i]) + coasted_s * r->rate_from[i];
    s->done = q >= 1.0;
    if (!s->done) return;
    memcpy(s->pose, r->to, sizeof s->pose); /* without the sum's rounding */
    reference_hold(r, r->to);
}

static double sinusoid(const struct test_params *t, enum dof dof, double time_s) {
    return t->amplitude[dof] * sin(2.0 * PI * t->hz[dof] * time_s);
}

/* What a test does, without its envelope. SAFETY: what is neither one axis's, nor a multisine, nor
 * has a trajectory stays at neutral. */
static void motion(const struct reference *r, const struct test_params *t, double time_s, double begin_s, double pose[DOFS]) {
    if (r->trajectory) trajectory_at(r->trajectory, time_s - begin_s, pose);
    for (int i = 0; i < t->count && r->dof == DOF_NONE && !r->trajectory && t->multisine; i++)
        pose[t->order[i]] = sinusoid(t, t->order[i], time_s);
    if (r->dof != DOF_NONE) pose[r->dof] = sinusoid(t, r->dof, time_s);
}

static void test_step(struct reference *r, const struct test_params *t, double dt_s, struct reference_sample *s) {
    int64_t ramp = ticks_of(t->ramp_s, dt_s), end = r->ramp_out_tick + ticks_of(t->ramp_out_s, dt_s);
    double envelope = smooth(r->ticks, ramp) * (1.0 - smooth(r->ticks - r->ramp_out_tick, end - r->ramp_out_tick));
    s->test_time_s = (double)r->ticks * dt_s;
    motion(r, t, s->test_time_s, (double)ramp * dt_s, s->pose);
    for (int i = 0; i < DOFS; i++) s->pose[i] *= envelope;
    s->phase = r->ticks >= r->ramp_out_tick ? PHASE_RAMP_OUT
               : r->ticks < 0               ? PHASE_SETTLE
               : r->ticks < ramp            ? PHASE_RAMP_IN
                                            : PHASE_EVALUATE;
    s->done = r->ticks >= end || (r->ticks < 0 && s->phase == PHASE_RAMP_OUT);
    if (s->done) reference_hold(r, (double[DOFS]){0});
}

struct reference_sample reference_step(struct reference *r, const struct test_params *t, double dt_s) {
    struct reference_sample s = {.phase = PHASE_NONE};
    switch (r->mode) {
    case REFERENCE_HOLD:
        memcpy(s.pose, r->to, sizeof s.pose);
        s.done = true;
        break;
    case REFERENCE_MOVE: move_step(r, dt_s, &s); break;
    case REFERENCE_TEST: test_step(r, t, dt_s, &s); break;
    }
    r->ticks++;
    return s;
}
