#include "reference.h"

#include <math.h>
#include <string.h>

#include "params/motion.h"
#include "params/tests.h"
#include "units.h"

/* Shortest braking time. It bounds the rate of change of the acceleration. */
static const double brake_least_s = 0.25;

static int64_t ticks_of(double seconds, double dt_s) { return llround(seconds / dt_s); }

/* Returns 3q^2 - 2q^3, which rises from 0 to 1 over [0, length]. */
static double smooth(int64_t ticks, int64_t length) {
    if (ticks <= 0) return 0.0;
    if (ticks >= length) return 1.0;
    double q = (double)ticks / (double)length;
    return q * q * (3.0 - 2.0 * q);
}

void reference_hold(struct reference *r, const double pose[DOFS]) {
    struct reference hold = {.mode = REFERENCE_HOLD, .dof = DOF_NONE};
    memcpy(hold.to, pose, sizeof hold.to); /* r->to and pose may be the same array */
    *r = hold;
}

static double norm(const double v[DOFS], double arm_m) {
    double square = 0.0;
    for (int i = 0; i < DOFS; i++) square += v[i] * v[i] * (i < DOF_PHI ? 1.0 : arm_m * arm_m);
    return sqrt(square);
}

static double brake_s(double rate_mps, double accel_mps2, double most_mps2) {
    double a = accel_mps2, most = fmax(most_mps2, a);
    if (rate_mps <= 0.0 && a <= 0.0) return 0.0;
    return fmax(brake_least_s, 3.0 * rate_mps / (most - a + sqrt(most * most + most * a)));
}

double reference_travel_s(double distance_m, const struct move_limits *l) {
    double limited_s = fmax(15.0 / 8.0 * distance_m / l->rate_mps, sqrt(10.0 / sqrt(3.0) * distance_m / l->accel_mps2));
    return fmax(l->duration_s, limited_s);
}

double reference_park_s(const struct motion_params *m, double asked_s) {
    return reference_travel_s(m->park_z_m, &(struct move_limits){asked_s, m->rate_mps, m->accel_mps2, 0.0});
}

void reference_move(struct reference *r, const struct move_start *from, const double to[DOFS], const struct move_limits *limits) {
    struct reference move = {.mode = REFERENCE_MOVE, .dof = DOF_NONE, .ticks = 1};
    struct move_limits rest = *limits;
    double distance[DOFS];
    memcpy(move.from, from->pose, sizeof move.from);
    memcpy(move.rate_from, from->rate, sizeof move.rate_from);
    memcpy(move.accel_from, from->accel, sizeof move.accel_from);
    memcpy(move.to, to, sizeof move.to);
    double b = brake_s(norm(from->rate, limits->arm_m), norm(from->accel, limits->arm_m), limits->accel_mps2);
    for (int i = 0; i < DOFS; i++) {
        move.turn[i] = move.from[i] + b * (move.rate_from[i] / 2.0 + b * move.accel_from[i] / 12.0);
        distance[i] = move.to[i] - move.turn[i];
    }
    rest.duration_s = fmax(limits->duration_s - b, 0.0);
    move.brake_s = b;
    move.travel_s = reference_travel_s(norm(distance, limits->arm_m), &rest);
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

static void brake(const struct reference *r, double q, double pose[DOFS]) {
    double b = r->brake_s, of_rate_s = b * (q - q * q * q + q * q * q * q / 2.0);
    double of_accel_s2 = b * b * q * q * (1.0 / 2.0 - 2.0 / 3.0 * q + q * q / 4.0);
    for (int i = 0; i < DOFS; i++) pose[i] = r->from[i] + of_rate_s * r->rate_from[i] + of_accel_s2 * r->accel_from[i];
}

static void travel(const struct reference *r, double q, double pose[DOFS]) {
    double share = q * q * q * (10.0 + q * (6.0 * q - 15.0));
    for (int i = 0; i < DOFS; i++) pose[i] = r->turn[i] + share * (r->to[i] - r->turn[i]);
}

static void move_step(struct reference *r, double dt_s, struct reference_sample *s) {
    double t = (double)r->ticks * dt_s, left_s = r->brake_s + r->travel_s - t;
    s->done = left_s <= 1e-9 * dt_s;
    if (s->done) {
        memcpy(s->pose, r->to, sizeof s->pose); /* the exact end, without the sum's rounding */
        reference_hold(r, r->to);
    } else if (t < r->brake_s) brake(r, t / r->brake_s, s->pose);
    else travel(r, (t - r->brake_s) / r->travel_s, s->pose);
}

static double sinusoid(const struct test_params *t, enum dof dof, double time_s) {
    return t->amplitude[dof] * sin(2.0 * PI * t->hz[dof] * time_s);
}

/* Computes a test's motion without its envelope. SAFETY: a test that is neither a sinusoid, a
 * multisine nor a trajectory stays at neutral. */
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
