#include "reference.h"

#include <math.h>
#include <string.h>

#include "params/motion.h"
#include "params/tests.h"
#include "units.h"

/* Shortest braking time; it limits the rate of change of the acceleration. */
static const double brake_least_s = 0.25;

static int64_t ticks_of(double seconds, double dt_s) { return llround(seconds / dt_s); }

/* Value of a scalar and its time derivatives up to the third. */
struct course {
    double d[MOTION_ORDERS];
};

static struct course product(const struct course *a, const struct course *b) {
    const double *x = a->d, *y = b->d;
    return (struct course){{x[0] * y[0], x[1] * y[0] + x[0] * y[1], x[2] * y[0] + 2.0 * x[1] * y[1] + x[0] * y[2],
                            x[3] * y[0] + 3.0 * (x[2] * y[1] + x[1] * y[2]) + x[0] * y[3]}};
}

static struct course less_than_one(const struct course *a) { return (struct course){{1.0 - a->d[0], -a->d[1], -a->d[2], -a->d[3]}}; }

/* Returns 3q^2 - 2q^3 with q = ticks / length, limited to 0..1, and its time derivatives. */
static struct course smooth(double ticks, int64_t length, double dt_s) {
    if (ticks <= 0.0) return (struct course){{0}};
    if (ticks >= (double)length) return (struct course){{1.0}};
    double q = ticks / (double)length, per_s = 1.0 / ((double)length * dt_s);
    return (struct course){
        {q * q * (3.0 - 2.0 * q), 6.0 * q * (1.0 - q) * per_s, (6.0 - 12.0 * q) * per_s * per_s, -12.0 * per_s * per_s * per_s}};
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

/* Returns the duration of a move of this distance from rest to rest. */
static double travel_s(double distance_m, const struct move_limits *l) {
    double limited_s = fmax(15.0 / 8.0 * distance_m / l->rate_mps, sqrt(10.0 / sqrt(3.0) * distance_m / l->accel_mps2));
    return fmax(l->duration_s, limited_s);
}

double reference_park_s(const struct motion_params *m, double asked_s) {
    return travel_s(m->park_z_m, &(struct move_limits){asked_s, m->rate_mps, m->accel_mps2, 0.0});
}

double reference_run_s(const struct motion_params *m, const struct test_params *t) {
    double test_s = t->settle_s + t->ramp_s + t->duration_s + t->ramp_out_s;
    return m->rest_s + reference_park_s(m, m->engage_s) + 2.0 * m->hold_s + tests_count(t) * test_s + reference_park_s(m, m->park_s);
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
    move.travel_s = travel_s(norm(distance, limits->arm_m), &rest);
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

static void brake(const struct reference *r, double q, double motion[MOTION_ORDERS][DOFS]) {
    double b = r->brake_s, of_rate_s = b * (q - q * q * q + q * q * q * q / 2.0);
    double of_accel_s2 = b * b * q * q * (1.0 / 2.0 - 2.0 / 3.0 * q + q * q / 4.0);
    for (int i = 0; i < DOFS; i++) {
        double v = r->rate_from[i], a = r->accel_from[i];
        motion[MOTION_POSE][i] = r->from[i] + of_rate_s * v + of_accel_s2 * a;
        motion[MOTION_RATE][i] = v * (1.0 + q * q * (2.0 * q - 3.0)) + a * b * q * (1.0 - q) * (1.0 - q);
        motion[MOTION_ACCEL][i] = (1.0 - q) * (a * (1.0 - 3.0 * q) - 6.0 * v / b * q);
        motion[MOTION_JERK][i] = (a * (6.0 * q - 4.0) + 6.0 * v / b * (2.0 * q - 1.0)) / b;
    }
}

static void travel(const struct reference *r, double q, double motion[MOTION_ORDERS][DOFS]) {
    double share = q * q * q * (10.0 + q * (6.0 * q - 15.0)), per_s = 1.0 / r->travel_s;
    double rate = 30.0 * q * q * (1.0 - q) * (1.0 - q) * per_s, acceleration = 60.0 * q * (1.0 - q) * (1.0 - 2.0 * q) * per_s * per_s;
    double jerk = 60.0 * (1.0 - 6.0 * q * (1.0 - q)) * per_s * per_s * per_s;
    for (int i = 0; i < DOFS; i++) {
        double way = r->to[i] - r->turn[i];
        motion[MOTION_POSE][i] = r->turn[i] + share * way;
        motion[MOTION_RATE][i] = rate * way, motion[MOTION_ACCEL][i] = acceleration * way, motion[MOTION_JERK][i] = jerk * way;
    }
}

static void rest(const double pose[DOFS], double motion[MOTION_ORDERS][DOFS]) {
    memset(motion, 0, MOTION_ORDERS * sizeof *motion);
    memcpy(motion[MOTION_POSE], pose, sizeof motion[MOTION_POSE]);
}

/* Returns true once a move has ended. The caller then uses r->to, so that no rounding error of the
 * polynomials remains. */
static bool arrived(const struct reference *r, double time_s, double dt_s) { return r->brake_s + r->travel_s - time_s <= 1e-9 * dt_s; }

static void move_motion(const struct reference *r, double time_s, double dt_s, double motion[MOTION_ORDERS][DOFS]) {
    if (arrived(r, time_s, dt_s)) rest(r->to, motion);
    else if (time_s < r->brake_s) brake(r, time_s / r->brake_s, motion);
    else travel(r, (time_s - r->brake_s) / r->travel_s, motion);
}

static void sinusoid(const struct test_params *t, enum dof dof, double time_s, double motion[MOTION_ORDERS][DOFS]) {
    double radps = 2.0 * PI * t->hz[dof], sine = t->amplitude[dof] * sin(radps * time_s), cosine = t->amplitude[dof] * cos(radps * time_s);
    motion[MOTION_POSE][dof] = sine, motion[MOTION_RATE][dof] = radps * cosine;
    motion[MOTION_ACCEL][dof] = -radps * radps * sine, motion[MOTION_JERK][dof] = -radps * radps * radps * cosine;
}

/* Computes a test's motion without its envelope. SAFETY: a test that is neither a sinusoid, a
 * multisine nor a trajectory stays at neutral. */
static void bare_motion(const struct reference *r, const struct test_params *t, double time_s, double begin_s,
                        double motion[MOTION_ORDERS][DOFS]) {
    if (r->trajectory) trajectory_motion(r->trajectory, time_s - begin_s, motion);
    for (int i = 0; i < t->count && r->dof == DOF_NONE && !r->trajectory && t->multisine; i++) sinusoid(t, t->order[i], time_s, motion);
    if (r->dof != DOF_NONE) sinusoid(t, r->dof, time_s, motion);
}

static int64_t test_end(const struct reference *r, const struct test_params *t, double dt_s) {
    return r->ramp_out_tick + ticks_of(t->ramp_out_s, dt_s);
}

static void test_motion(const struct reference *r, const struct test_params *t, double ticks, double dt_s,
                        double motion[MOTION_ORDERS][DOFS]) {
    int64_t ramp = ticks_of(t->ramp_s, dt_s), out = r->ramp_out_tick;
    struct course in = smooth(ticks, ramp, dt_s), gone = smooth(ticks - (double)out, test_end(r, t, dt_s) - out, dt_s);
    struct course left = less_than_one(&gone), envelope = product(&in, &left);
    memset(motion, 0, MOTION_ORDERS * sizeof *motion);
    bare_motion(r, t, ticks * dt_s, (double)ramp * dt_s, motion);
    for (int i = 0; i < DOFS; i++) {
        struct course axis = {{motion[MOTION_POSE][i], motion[MOTION_RATE][i], motion[MOTION_ACCEL][i], motion[MOTION_JERK][i]}};
        axis = product(&axis, &envelope);
        for (int k = 0; k < MOTION_ORDERS; k++) motion[k][i] = axis.d[k];
    }
}

/* Computes the motion at a time in cycles, not necessarily whole, since the start of the move or of
 * the test's ramp-in. */
static void motion_at(const struct reference *r, const struct test_params *t, double ticks, double dt_s,
                      double motion[MOTION_ORDERS][DOFS]) {
    switch (r->mode) {
    case REFERENCE_HOLD: rest(r->to, motion); break;
    case REFERENCE_MOVE: move_motion(r, ticks * dt_s, dt_s, motion); break;
    case REFERENCE_TEST: test_motion(r, t, ticks, dt_s, motion); break;
    }
}

static void test_step(struct reference *r, const struct test_params *t, double dt_s, struct reference_sample *s) {
    s->test_time_s = (double)r->ticks * dt_s;
    s->phase = r->ticks >= r->ramp_out_tick           ? PHASE_RAMP_OUT
               : r->ticks < 0                         ? PHASE_SETTLE
               : r->ticks < ticks_of(t->ramp_s, dt_s) ? PHASE_RAMP_IN
                                                      : PHASE_EVALUATE;
    s->done = r->ticks >= test_end(r, t, dt_s) || (r->ticks < 0 && s->phase == PHASE_RAMP_OUT);
    if (s->done) reference_hold(r, (double[DOFS]){0});
}

struct reference_sample reference_step(struct reference *r, const struct test_params *t, double dt_s) {
    struct reference_sample s = {.phase = PHASE_NONE};
    double motion[MOTION_ORDERS][DOFS];
    motion_at(r, t, (double)r->ticks, dt_s, motion);
    memcpy(s.pose, motion[MOTION_POSE], sizeof s.pose);
    if (r->mode == REFERENCE_HOLD) s.done = true;
    if (r->mode == REFERENCE_MOVE && (s.done = arrived(r, (double)r->ticks * dt_s, dt_s))) reference_hold(r, r->to);
    if (r->mode == REFERENCE_TEST) test_step(r, t, dt_s, &s);
    r->ticks++;
    return s;
}

void reference_motion(const struct reference *r, const struct test_params *t, double dt_s, double ahead_s,
                      double motion[MOTION_ORDERS][DOFS]) {
    motion_at(r, t, (double)(r->ticks - 1) + ahead_s / dt_s, dt_s, motion);
}
