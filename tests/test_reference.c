/* The reference announces its motion ahead of time: pose, rate, acceleration and jerk. */
#include "support.h"

#include "reference.h"

static const double dt_s = 0.002;

static struct test_params quick_tests(void) {
    struct params params = brisk();
    struct test_params t = params.tests;
    for (int i = 0; i < DOFS; i++) t.hz[i] = 3.0 + i;
    return t;
}

static struct trajectory wave(int passes) {
    static struct trajectory_knot knot[9];
    struct trajectory t = {.knots = 9, .passes = passes, .knot = knot};
    for (int i = 0; i < 9; i++) {
        knot[i].time_s = 0.05 * i;
        for (int k = 0; k < DOFS; k++) knot[i].pose[k] = 0.01 * sin(2.0 * PI * i / 8.0 + k) - 0.01 * sin(k);
    }
    assert_true(trajectory_bend(&t));
    return t;
}

static struct reference moving(void) {
    struct reference r;
    const double pose[DOFS] = {0.1, -0.05, 0.2, 0.1, -0.1, 0.2}, rate[DOFS] = {0.2, 0.1, -0.1, 0.1, 0, 0.3}, accel[DOFS] = {0.3, 0, 0.2};
    const struct move_limits limits = {1.0, 0.42, 1.1, 0.56};
    reference_move(&r, &(struct move_start){pose, rate, accel}, (const double[DOFS]){[DOF_Z] = 0.3}, &limits);
    return r;
}

enum { KINDS = 6 };

/* Returns a reference of each kind at its start. */
static struct reference reference_of(int kind, const struct trajectory *trajectory, struct test_params *t) {
    struct reference r = moving();
    t->multisine = kind == 3;
    if (kind == 1) reference_test(&r, DOF_THETA, NULL, t, dt_s);
    if (kind == 2) reference_test(&r, DOF_NONE, trajectory, t, dt_s);
    if (kind == 3) reference_test(&r, DOF_NONE, NULL, t, dt_s);
    if (kind == 4) reference_hold(&r, (const double[DOFS]){0.1, 0.2, 0.3, 0.1, 0.2, 0.3});
    if (kind == 5) reference_test(&r, DOF_X, NULL, t, dt_s);
    return r;
}

/* Kind 5 is a test that is stopped in its middle. */
static struct reference_sample next(struct reference *r, int kind, int n, const struct test_params *t) {
    if (kind == 5 && n == 250) reference_stop(r);
    return reference_step(r, t, dt_s);
}

static void what_it_announces_comes(void **unused) {
    (void)unused;
    struct test_params t = quick_tests();
    struct trajectory trajectory = wave(3);
    for (int kind = 0; kind < KINDS; kind++) {
        struct reference r = reference_of(kind, &trajectory, &t);
        for (int n = 0; n < 2000; n++) {
            double now[MOTION_ORDERS][DOFS], ahead[MOTION_ORDERS][DOFS];
            struct reference_sample s = next(&r, kind, n, &t);
            reference_motion(&r, &t, dt_s, 0.0, now);
            assert_true(distance(now[MOTION_POSE], s.pose, DOFS) == 0.0);
            if (kind == 5 && n > 240 && n < 250) continue; /* a stop cannot be announced */
            reference_motion(&r, &t, dt_s, 5.0 * dt_s, ahead);
            struct reference later = r;
            for (int k = 0; k < 5; k++) s = reference_step(&later, &t, dt_s);
            assert_close(distance(ahead[MOTION_POSE], s.pose, DOFS), 0.0, 1e-15);
        }
    }
}

static bool jumps(const struct trajectory *trajectory, const struct reference *r, const struct test_params *t, double ahead_s) {
    double time_s = (double)(r->ticks - 1) * dt_s + ahead_s, joint[32] = {0.0,
                                                                          t->ramp_s,
                                                                          (double)r->ramp_out_tick * dt_s,
                                                                          (double)r->ramp_out_tick * dt_s + t->ramp_out_s,
                                                                          r->brake_s,
                                                                          r->brake_s + r->travel_s};
    int joints = 6;
    for (int pass = 0; pass < 3 && r->trajectory; pass++)
        for (int i = 0; i < 8; i++) joint[joints++] = t->ramp_s + pass * 0.4 + trajectory->knot[i].time_s;
    for (int i = 0; i < joints; i++)
        if (fabs(time_s - joint[i]) < 2e-4) return true;
    return false;
}

/* Tolerance: a central difference has an error of its step's square over 6 times a derivative two
 * orders higher, at most 1e5 m/s^5 here, and rounding divided by the step. */
static void every_order_is_the_derivative_of_the_one_before(void **unused) {
    (void)unused;
    struct test_params t = quick_tests();
    struct trajectory trajectory = wave(3);
    const double h = 1e-5;
    uint64_t seed = 5;
    for (int kind = 0; kind < KINDS; kind++) {
        struct reference r = reference_of(kind, &trajectory, &t);
        for (int n = 0; n < 1200; n++) {
            next(&r, kind, n, &t);
            double at_s = dt_s * (1.0 + random_unit(&seed)), before[MOTION_ORDERS][DOFS], now[MOTION_ORDERS][DOFS],
                   after[MOTION_ORDERS][DOFS];
            if (jumps(&trajectory, &r, &t, at_s)) continue;
            reference_motion(&r, &t, dt_s, at_s - h, before);
            reference_motion(&r, &t, dt_s, at_s, now);
            reference_motion(&r, &t, dt_s, at_s + h, after);
            for (int k = 1; k < MOTION_ORDERS; k++)
                for (int i = 0; i < DOFS; i++) {
                    double size = fmax(1.0, fabs(now[k][i]));
                    assert_close((after[k - 1][i] - before[k - 1][i]) / (2.0 * h), now[k][i], 1e-5 * size);
                }
        }
    }
}

static void a_move_is_continuous_in_acceleration(void **unused) {
    (void)unused;
    struct test_params t = quick_tests();
    struct reference r = moving();
    double before[MOTION_ORDERS][DOFS], now[MOTION_ORDERS][DOFS];
    reference_motion(&r, &t, dt_s, 0.0, before);
    assert_close(distance(before[MOTION_ACCEL], r.accel_from, DOFS), 0.0, 1e-15);
    for (int n = 0; n < 4000; n++, memcpy(before, now, sizeof now)) {
        reference_motion(&r, &t, dt_s, 0.5e-3 * n, now);
        /* between the pieces of the polynomial the jerk may jump, so the larger one bounds the
         * change */
        for (int i = 0; i < DOFS && n; i++)
            assert_below(fabs(now[MOTION_ACCEL][i] - before[MOTION_ACCEL][i]),
                         1.05 * 0.5e-3 * fmax(fabs(now[MOTION_JERK][i]), fabs(before[MOTION_JERK][i])) + 1e-3 * 0.5e-3);
    }
    assert_close(distance(now[MOTION_POSE], r.to, DOFS), 0.0, 1e-15);
    for (int k = 1; k < MOTION_ORDERS; k++) assert_close(distance(now[k], (const double[DOFS]){0}, DOFS), 0.0, 1e-15);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_it_announces_comes),
        cmocka_unit_test(every_order_is_the_derivative_of_the_one_before),
        cmocka_unit_test(a_move_is_continuous_in_acceleration),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
