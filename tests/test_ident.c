/* Identification: from synthetic cycles of a known machine back to its matrices, and what it does with flagged, lost and repeated data. */
#include "support.h"

#include <complex.h>

#include "ident.h"
#include "lin.h"
#include "units.h"

enum { RATE_HZ = 500, SAMPLES_MAX = 2500, HARMONICS = 3 };

static const double tank_pa = 1e6;

/* A machine as the method sees it, and how its six tests went. Poses and wrenches are constant + drift + three harmonics. */
struct rig {
    struct params params;
    struct kinematics kinematics;
    struct cylinder_areas areas;
    double mt[DOFS][DOFS], bt[DOFS][DOFS];
    double pose[DOFS][DOFS][HARMONICS][2]; /* test, axis, harmonic, [sin, cos] */
    int samples;                           /* evaluated, a test */
    struct cycle cycle[DOFS][SAMPLES_MAX]; /* by test */
};

static double random_normal(uint64_t *state) {
    double radius = sqrt(-2 * log(0.5 + 0.5 * random_unit(state) + 1e-300));
    return radius * cos(PI * random_unit(state));
}

static double omega(const struct rig *r) { return 2 * PI * r->params.tests.frequency_hz; }

static double amplitude(const struct rig *r, int dof) { return dof < 3 ? r->params.tests.amplitude_m : r->params.tests.amplitude_rad; }

/* Own axis near the command with a phase lag, the others a few percent of theirs; weaker harmonics. */
static void rig_motions(struct rig *r, uint64_t *state) {
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < DOFS; i++)
            for (int k = 0; k < HARMONICS; k++) {
                double share = k > 0 ? 0.01 : i == d ? 0.0 : 0.05;
                r->pose[d][i][k][0] = amplitude(r, i) * (share * random_unit(state) + (k == 0 && i == d ? 0.97 : 0));
                r->pose[d][i][k][1] = amplitude(r, i) * (share * random_unit(state) - (k == 0 && i == d ? 0.30 : 0));
            }
}

/* General matrices, so that a transposed or misplaced entry shows: the nominal one and viscous legs, each entry disturbed. */
static void rig_matrices(struct rig *r, uint64_t *state) {
    static const double neutral[DOFS] = {0};
    double j[LEGS][DOFS];
    nominal_matrix(&r->params, &r->kinematics, neutral, r->mt);
    ik_jacobian(&r->kinematics, neutral, j);
    for (int i = 0; i < DOFS; i++)
        for (int k = 0; k < DOFS; k++) {
            r->bt[i][k] = 0;
            for (int leg = 0; leg < LEGS; leg++) r->bt[i][k] += 2000 * j[leg][i] * j[leg][k];
        }
    for (int i = 0; i < DOFS; i++)
        for (int k = 0; k < DOFS; k++) {
            r->mt[i][k] += random_unit(state);
            r->bt[i][k] += 20 * random_unit(state);
        }
}

/* Pose, its first and second time derivatives. */
static void rig_motion(const struct rig *r, int d, double t_s, double pose[3][DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        pose[0][i] = amplitude(r, i) * (0.1 + 0.02 * (t_s - 1));
        pose[1][i] = pose[2][i] = 0; /* the drift's rate is no part of the fundamental */
        for (int k = 0; k < HARMONICS; k++) {
            double w = (k + 1) * omega(r), s = sin(w * t_s), c = cos(w * t_s);
            const double *a = r->pose[d][i][k];
            pose[0][i] += a[0] * s + a[1] * c;
            pose[1][i] += w * (a[0] * c - a[1] * s);
            pose[2][i] -= w * w * (a[0] * s + a[1] * c);
        }
    }
}

static void rig_wrench(const struct rig *r, double t_s, double motion[3][DOFS], double wrench[DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        wrench[i] = (i == 2 ? -3000 : 50) + 2 * t_s;
        for (int k = 0; k < DOFS; k++) wrench[i] += r->mt[i][k] * motion[2][k] + r->bt[i][k] * motion[1][k];
    }
}

/* Lengths and pressures that have this pose and wrench. */
static void sample_from(const struct rig *r, const double pose[DOFS], const double wrench[DOFS], struct hal_sample *in) {
    double j[LEGS][DOFS], force_n[LEGS];
    ik_lengths(&r->kinematics, pose, in->length_m);
    ik_jacobian(&r->kinematics, pose, j);
    lin_solve_right(LEGS, 1, &j[0][0], wrench, force_n); /* f' J = F' */
    for (int leg = 0; leg < LEGS; leg++) {
        in->p2_pa[leg] = tank_pa;
        in->p1_pa[leg] = (force_n[leg] + r->areas.a2_m2 * tank_pa) / r->areas.a1_m2;
    }
}

static struct rig *rig_create(uint64_t seed, double duration_s) {
    static struct rig rig;
    struct rig *r = &rig;
    struct error error;
    config_default(&r->params);
    r->params.tests.duration_s = duration_s;
    r->params.tests.harmonics = HARMONICS;
    assert_int_equal(kinematics_init(&r->kinematics, &r->params, &error), 0);
    r->areas = cylinder_areas(&r->params.actuator);
    rig_motions(r, &seed);
    rig_matrices(r, &seed);
    r->samples = (int)lround(duration_s * RATE_HZ);
    assert_true(r->samples <= SAMPLES_MAX);
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < r->samples; i++) {
            double motion[3][DOFS], wrench[DOFS], t = r->params.tests.ramp_s + (double)i / RATE_HZ;
            r->cycle[d][i] = (struct cycle){.test = d, .dof = (enum dof)d, .phase = PHASE_EVALUATE, .test_time_s = t};
            rig_motion(r, d, t, motion);
            rig_wrench(r, t, motion, wrench);
            sample_from(r, motion[0], wrench, &r->cycle[d][i].in);
        }
    return r;
}

static struct ident *ident_create(const struct rig *r) {
    static struct ident ident;
    struct error error;
    assert_int_equal(ident_init(&ident, &r->params, &error), 0);
    return &ident;
}

static const struct cycle ramp_out = {.test = 0, .dof = DOF_X, .phase = PHASE_RAMP_OUT};

static bool feed_part(struct ident *id, const struct rig *r, int d, int from, int to) {
    bool ended = false;
    for (int i = from; i < to; i++) ended |= ident_feed(id, &r->cycle[d][i]);
    return ended;
}

static void feed_all(struct ident *id, const struct rig *r) {
    for (int d = 0; d < DOFS; d++) feed_part(id, r, d, 0, r->samples);
    ident_end(id);
}

static const struct test_result *last_result(const struct ident *id) { return &id->result.test[id->result.tests - 1]; }

static void method_a_recovers_inertia_and_damping_of_a_known_machine(void **unused) {
    (void)unused;
    struct rig *r = rig_create(1, 5);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_true(ident_solve(id));
    const struct method_result *a = &id->result.method_a;
    /* Forward kinematics stops at 1e-13 m of 4 mm, 2.5e-11, not averaged: times the largest entries, 10 N s/mm through w = 25. */
    assert_below(distance(&a->mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-9 * 272);
    assert_below(distance(&a->bt[0][0], &r->bt[0][0], DOFS * DOFS), 1e-9 * 272 * omega(r));
    for (int i = 0; i < DOFS; i++) assert_true(a->bt[i][i] > 0); /* the sign of Q */
    assert_true(a->condition_number > 1 && a->condition_number < 1.5);
}

static void fundamentals_are_those_of_the_motion(void **unused) {
    (void)unused;
    struct rig *r = rig_create(2, 5);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_int_equal(id->result.tests, DOFS);
    for (int d = 0; d < DOFS; d++) {
        const struct test_result *t = &id->result.test[d];
        const double *own = r->pose[d][d][0];
        assert_true(t->test == d && (int)t->dof == d && t->complete && t->samples == r->samples && t->excluded == 0);
        for (int i = 0; i < DOFS; i++) {
            double share = 100 * hypot(r->pose[d][i][0][0], r->pose[d][i][0][1]) / amplitude(r, i);
            assert_close(t->unwanted_pct[i], i == d ? 0 : share, 1e-7);
            assert_below(distance(t->pose[i], r->pose[d][i][0], 2), 1e-12);
        }
        assert_close(t->achieved_amplitude, hypot(own[0], own[1]), 1e-12);
        assert_close(t->phase_deg, deg_from_rad(atan2(own[1], own[0])), 1e-7);
        assert_true(t->amplitude == amplitude(r, d) && t->frequency_hz == 4);
    }
}

static void order_of_the_tests_changes_no_bit(void **unused) {
    (void)unused;
    static const int order[DOFS] = {4, 2, 0, 5, 1, 3};
    struct rig *r = rig_create(3, 1);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_true(ident_solve(id));
    struct identification first = id->result;
    id = ident_create(r);
    for (int d = 0; d < DOFS; d++) feed_part(id, r, order[d], 0, r->samples);
    assert_true(ident_end(id));
    assert_true(ident_solve(id));
    assert_int_equal(id->result.test[0].dof, DOF_THETA);
    assert_memory_equal(&id->result.method_a, &first.method_a, sizeof first.method_a);
    assert_memory_equal(&id->result.method_b, &first.method_b, sizeof first.method_b);
}

static void what_came_before_the_evaluated_part_changes_no_bit(void **unused) {
    (void)unused;
    struct rig *r = rig_create(4, 1);
    struct ident *id = ident_create(r);
    feed_part(id, r, 0, 0, r->samples);
    assert_true(ident_end(id));
    struct test_result alone = *last_result(id);
    id = ident_create(r);
    feed_part(id, r, 3, 0, 100);
    for (int i = 0; i < 50; i++) {
        struct cycle settling = r->cycle[5][i];
        settling.phase = i < 25 ? PHASE_SETTLE : PHASE_RAMP_IN;
        ident_feed(id, &settling);
    }
    feed_part(id, r, 0, 0, r->samples);
    assert_true(ident_feed(id, &ramp_out));
    assert_memory_equal(last_result(id), &alone, sizeof alone);
}

/* Flagged samples carry nonsense here: a single one that is used would show. */
static void excluded_samples_are_counted_and_never_used(void **unused) {
    (void)unused;
    static const uint32_t flags[] = {SAMPLE_STALE, SAMPLE_LATE, SAMPLE_DROPPED, SAMPLE_INVALID, SAMPLE_OVERRUN, SAMPLE_IO};
    struct rig *r = rig_create(5, 1);
    struct ident *id = ident_create(r);
    uint64_t state = 9;
    for (int d = 0; d < DOFS; d++) {
        int excluded = 0;
        for (int i = 0; i < r->samples; i++) {
            struct cycle *c = &r->cycle[d][i];
            int what = random_below(&state, 30);
            if (what < 6) c->in.flags = flags[what], c->in.length_m[what] += 0.001, c->in.p1_pa[what] *= 2;
            if (what == 6) c->in.length_m[d] = (double)NAN;
            if (what == 7) c->in.p2_pa[d] = (double)INFINITY;
            if (what == 8) c->in.length_m[d] = 9; /* no pose has it: forward kinematics does not converge */
            excluded += what <= 8;
            ident_feed(id, c);
        }
        ident_end(id);
        assert_true(excluded > 50);
        assert_int_equal(last_result(id)->excluded, excluded);
        assert_int_equal(last_result(id)->samples, r->samples - excluded);
        assert_true(last_result(id)->complete);
    }
    assert_true(ident_solve(id));
    assert_below(distance(&id->result.method_a.mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-9 * 272);
}

static void a_test_ends_with_its_evaluated_part(void **unused) {
    (void)unused;
    struct rig *r = rig_create(6, 1);
    struct ident *id = ident_create(r);
    assert_false(ident_end(id));
    assert_false(ident_feed(id, &ramp_out));
    assert_false(feed_part(id, r, 0, 0, r->samples));
    assert_true(ident_feed(id, &ramp_out));
    assert_false(ident_feed(id, &ramp_out));
    assert_false(feed_part(id, r, 1, 0, r->samples));
    assert_true(ident_feed(id, &r->cycle[2][0])); /* the next test with no pause between */
    assert_int_equal(id->result.tests, 2);
    assert_true(last_result(id)->complete);
}

static void a_test_cut_short_is_not_complete_and_no_method_uses_it(void **unused) {
    (void)unused;
    struct rig *r = rig_create(7, 1);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_true(ident_solve(id));
    feed_part(id, r, 2, 0, r->samples - 5);
    assert_true(ident_feed(id, &ramp_out));
    assert_false(last_result(id)->complete);
    assert_int_equal(last_result(id)->samples, r->samples - 5);
    assert_false(ident_solve(id));
    assert_false(id->result.method_a.evaluated || id->result.modified_a.evaluated || id->result.method_b.evaluated);
}

static void a_test_without_a_usable_sample_is_not_complete(void **unused) {
    (void)unused;
    struct rig *r = rig_create(8, 1);
    struct ident *id = ident_create(r);
    for (int i = 0; i < r->samples; i++) r->cycle[0][i].in.flags = SAMPLE_LATE;
    feed_part(id, r, 0, 0, r->samples);
    assert_true(ident_end(id));
    assert_false(last_result(id)->complete);
    assert_int_equal(last_result(id)->samples, 0);
    assert_true(isnan(last_result(id)->achieved_amplitude));
}

/* Data from elsewhere: every second sample, another rate than the configuration's. */
static void a_slower_rate_is_complete_too(void **unused) {
    (void)unused;
    struct rig *r = rig_create(9, 5);
    struct ident *id = ident_create(r);
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < r->samples; i += 2) ident_feed(id, &r->cycle[d][i]);
    ident_end(id);
    for (int d = 0; d < DOFS; d++) assert_true(id->result.test[d].complete);
    assert_true(ident_solve(id));
    assert_below(distance(&id->result.method_a.mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-9 * 272);
}

static void a_repeated_test_replaces_the_earlier_one(void **unused) {
    (void)unused;
    struct rig *r = rig_create(10, 1);
    struct ident *id = ident_create(r);
    for (int i = 0; i < r->samples; i++) { /* a first try of phi with a wrong amplitude */
        struct cycle wrong = r->cycle[0][i];
        wrong.test = 3;
        wrong.dof = DOF_PHI;
        ident_feed(id, &wrong);
    }
    feed_all(id, r);
    assert_int_equal(id->result.tests, DOFS);
    assert_int_equal(last_result(id)->dof, DOF_PSI);
    assert_true(ident_solve(id));
    assert_below(distance(&id->result.method_a.mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-9 * 272);
    feed_part(id, r, 0, 0, r->samples);
    ident_end(id);
    assert_int_equal(id->result.tests, DOFS);
    assert_int_equal(last_result(id)->dof, DOF_X);
}

static void without_all_six_axes_no_method_is_evaluated(void **unused) {
    (void)unused;
    struct rig *r = rig_create(11, 1);
    for (int missing = 0; missing < DOFS; missing++) {
        struct ident *id = ident_create(r);
        for (int d = 0; d < DOFS; d++)
            if (d != missing) feed_part(id, r, d, 0, r->samples);
        ident_end(id);
        assert_int_equal(id->result.tests, DOFS - 1);
        assert_false(ident_solve(id));
        assert_false(id->result.method_a.evaluated);
    }
}

static void modified_a_replaces_the_couplings_by_their_mean_with_the_nominal_signs(void **unused) {
    (void)unused;
    struct rig *r = rig_create(12, 1);
    struct ident *id = ident_create(r);
    feed_all(id, r);
    assert_true(ident_solve(id));
    const struct identification *i = &id->result;
    double m_qz = (fabs(i->method_a.mt[0][4]) + fabs(i->method_a.mt[3][1])) / 2;
    assert_true(i->modified_a.evaluated);
    assert_true(i->modified_a.mt[0][4] == m_qz && i->modified_a.mt[4][0] == m_qz);
    assert_true(i->modified_a.mt[1][3] == -m_qz && i->modified_a.mt[3][1] == -m_qz);
    for (int k = 0; k < DOFS * DOFS; k++) {
        int row = k / DOFS, column = k % DOFS;
        if ((row == 0 && column == 4) || (row == 4 && column == 0) || (row == 1 && column == 3) || (row == 3 && column == 1)) continue;
        assert_true(i->modified_a.mt[row][column] == i->method_a.mt[row][column]);
    }
}

/* Test results straight from matrices and motions: F = -w^2 M x + B xdot on the fundamental. */
static void exact_results(const struct rig *r, struct test_result result[DOFS]) {
    double w = omega(r);
    for (int d = 0; d < DOFS; d++) {
        struct test_result *t = &result[d];
        *t = (struct test_result){.dof = (enum dof)d, .frequency_hz = r->params.tests.frequency_hz, .amplitude = amplitude(r, d), .complete = true};
        for (int i = 0; i < DOFS; i++) memcpy(t->pose[i], r->pose[d][i][0], sizeof t->pose[i]);
        t->achieved_amplitude = hypot(t->pose[d][0], t->pose[d][1]);
        for (int i = 0; i < DOFS; i++)
            for (int k = 0; k < DOFS; k++) {
                t->wrench[i][0] -= w * w * r->mt[i][k] * t->pose[k][0] + w * r->bt[i][k] * t->pose[k][1];
                t->wrench[i][1] -= w * w * r->mt[i][k] * t->pose[k][1] - w * r->bt[i][k] * t->pose[k][0];
            }
    }
}

static void pointers(const struct test_result result[DOFS], const struct test_result *test[DOFS]) {
    for (int d = 0; d < DOFS; d++) test[d] = &result[d];
}

static void viscous_legs_have_the_damping_of_the_method(void **unused) {
    (void)unused;
    static const double neutral[DOFS] = {0}, diagonal[DOFS] = {1186, 1186, 9630, 1323, 1323, 552}; /* method.md, b = 2000 N s/m */
    struct rig *r = rig_create(19, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    double j[LEGS][DOFS];
    pointers(result, test);
    ik_jacobian(&r->kinematics, neutral, j);
    memset(r->bt, 0, sizeof r->bt);
    for (int k = 0; k < LEGS * DOFS * DOFS; k++) {
        int leg = k / (DOFS * DOFS), row = k / DOFS % DOFS, column = k % DOFS;
        r->bt[row][column] += 2000 * j[leg][row] * j[leg][column];
    }
    exact_results(r, result);
    struct method_result a = method_a(test);
    for (int i = 0; i < DOFS; i++) assert_below(fabs(a.bt[i][i] / diagonal[i] - 1), 1e-3); /* read off a simulation there */
}

static double complex phasor(const double coefficient[2]) { return CMPLX(coefficient[0], coefficient[1]); }

/* x = Im(X exp(i w t)): test d's fundamentals as columns, turned back by the phase of the tested axis. */
static void turned(const struct test_result result[DOFS], double complex x[DOFS][DOFS], double complex f[DOFS][DOFS]) {
    for (int d = 0; d < DOFS; d++) {
        double complex back = cexp(CMPLX(0, -carg(phasor(result[d].pose[d]))));
        for (int i = 0; i < DOFS; i++) {
            x[i][d] = back * phasor(result[d].pose[i]);
            f[i][d] = back * phasor(result[d].wrench[i]);
        }
    }
}

static void method_b_maps_acceleration_in_phase_to_wrench_in_phase(void **unused) {
    (void)unused;
    struct rig *r = rig_create(13, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    double complex x[DOFS][DOFS], f[DOFS][DOFS];
    double w = omega(r);
    pointers(result, test);
    exact_results(r, result);
    struct method_result b = method_b(test);
    assert_true(b.evaluated && b.condition_number < 1.5);
    turned(result, x, f);
    for (int i = 0; i < DOFS; i++)
        for (int d = 0; d < DOFS; d++) {
            double wrench = 0;
            for (int k = 0; k < DOFS; k++) wrench -= b.mt[i][k] * w * w * creal(x[k][d]);
            assert_close(wrench, creal(f[i][d]), 1e-10); /* roundings of 700 N */
        }
}

/* F = (-w^2 M + i w B)(P + i Q), in phase: -w^2 M P - w B Q. So method B is off by B Q P^-1 / w, Q: unwanted motion in quadrature. */
static void damping_biases_method_b_by_unwanted_motion_in_quadrature(void **unused) {
    (void)unused;
    struct rig *r = rig_create(13, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    double complex x[DOFS][DOFS], f[DOFS][DOFS];
    double w = omega(r), largest = 0;
    pointers(result, test);
    exact_results(r, result);
    struct method_result b = method_b(test);
    turned(result, x, f);
    for (int i = 0; i < DOFS; i++)
        for (int d = 0; d < DOFS; d++) {
            double bias = 0, predicted = 0;
            for (int k = 0; k < DOFS; k++) {
                bias += (b.mt[i][k] - r->mt[i][k]) * creal(x[k][d]);
                predicted += r->bt[i][k] * cimag(x[k][d]) / w;
            }
            assert_close(bias, predicted, 1e-14); /* roundings of 272 kg times 4 mm */
            largest = fmax(largest, fabs(predicted));
        }
    assert_true(largest > 1e-3); /* kg m; 0.1 % of 272 kg at 4 mm: there is something to predict */
}

static void without_damping_or_quadrature_method_b_is_exact(void **unused) {
    (void)unused;
    struct rig *r = rig_create(13, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    pointers(result, test);
    double own[DOFS][DOFS];
    memcpy(own, r->bt, sizeof own);
    memset(r->bt, 0, sizeof r->bt);
    exact_results(r, result);
    assert_below(distance(&method_b(test).mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-11); /* roundings of 272 */
    memcpy(r->bt, own, sizeof own);
    for (int d = 0; d < DOFS; d++)
        for (int i = 0; i < DOFS; i++) { /* every axis in step with the tested one, or against it */
            double *coefficient = r->pose[d][i][0], *tested = r->pose[d][d][0], share = (i + d) % 2 ? 0.05 : -0.05;
            if (i != d) coefficient[0] = share * tested[0], coefficient[1] = share * tested[1];
        }
    exact_results(r, result);
    assert_below(distance(&method_b(test).mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-11);
}

static void condition_is_one_for_perfect_tests_and_singular_ones_give_no_number(void **unused) {
    (void)unused;
    struct rig *r = rig_create(14, 1);
    struct test_result result[DOFS];
    const struct test_result *test[DOFS];
    pointers(result, test);
    memset(r->pose, 0, sizeof r->pose);
    for (int d = 0; d < DOFS; d++) r->pose[d][d][0][0] = amplitude(r, d);
    exact_results(r, result);
    assert_close(method_a(test).condition_number, 1, 1e-14);
    assert_close(method_b(test).condition_number, 1, 1e-14);
    test[DOF_Y] = &result[DOF_X]; /* the x test in place of the y test: nothing moved y */
    struct method_result singular[] = {method_a(test), method_b(test)};
    for (int m = 0; m < 2; m++) {
        assert_false(singular[m].evaluated);
        for (int i = 0; i < DOFS; i++)
            for (int k = 0; k < DOFS; k++) assert_true(isnan(singular[m].mt[i][k]) && isnan(singular[m].mt_std[i][k]));
    }
}

static void tests_of_different_frequencies_can_be_combined(void **unused) {
    (void)unused;
    struct rig *r = rig_create(15, 1);
    struct test_result result[DOFS], other[DOFS];
    const struct test_result *test[DOFS];
    pointers(result, test);
    exact_results(r, result);
    r->params.tests.frequency_hz = 7;
    exact_results(r, other);
    for (int d = 0; d < DOFS; d += 2) test[d] = &other[d];
    struct method_result a = method_a(test);
    assert_true(a.evaluated);
    assert_below(distance(&a.mt[0][0], &r->mt[0][0], DOFS * DOFS), 1e-11);
}

/* Ratio of observed to predicted variance, entry by entry. */
struct spread {
    double observed[DOFS * DOFS], predicted[DOFS * DOFS];
    int runs;
};

static void spread_add(struct spread *s, const double *value, const double *truth, const double *std) {
    for (int i = 0; i < DOFS * DOFS; i++) {
        s->observed[i] += pow(value[i] - truth[i], 2);
        s->predicted[i] += pow(std[i], 2);
    }
    s->runs++;
}

/* The relative spread of an observed variance is sqrt(2 / runs): five of them for the worst of 36 entries; the mean over all of them has at
 * least six independent ones, as rows are: four of theirs. */
static void assert_spread(const struct spread *s, const char *name) {
    double one = sqrt(2.0 / s->runs), mean = 0;
    for (int i = 0; i < DOFS * DOFS; i++) {
        double ratio = s->observed[i] / s->predicted[i];
        mean += ratio / (DOFS * DOFS);
        if (!(fabs(ratio - 1) < 5 * one)) fail_msg("%s[%d][%d]: variance %g of the predicted one", name, i / DOFS, i % DOFS, ratio);
    }
    if (!(fabs(mean - 1) < 4 * one / sqrt(6))) fail_msg("%s: mean variance %g of the predicted one", name, mean);
}

static void disturb(struct test_result *t, uint64_t *state) {
    for (int i = 0; i < DOFS; i++)
        for (int k = 0; k < 2; k++) {
            t->pose[i][k] += t->pose_std[i] * random_normal(state);
            t->wrench[i][k] += t->wrench_std[i] * random_normal(state);
        }
}

static void predicted_std_is_the_spread_over_noisy_coefficients(void **unused) {
    (void)unused;
    struct rig *r = rig_create(16, 1);
    struct spread mt = {0}, bt = {0}, b = {0};
    struct test_result exact[DOFS], noisy[DOFS];
    const struct test_result *test[DOFS];
    uint64_t state = 3;
    exact_results(r, exact);
    pointers(exact, test);
    struct method_result biased = method_b(test); /* method B's own expectation, with its bias */
    pointers(noisy, test);
    for (int run = 0; run < 4000; run++) {
        for (int d = 0; d < DOFS; d++) {
            noisy[d] = exact[d];
            for (int i = 0; i < DOFS; i++) {
                /* Alike in their effect: 0.1 % of the amplitude, and of the wrench that goes with it. */
                noisy[d].pose_std[i] = 1e-3 * amplitude(r, i);
                noisy[d].wrench_std[i] = 1e-3 * pow(omega(r), 2) * r->mt[i][i] * amplitude(r, i);
            }
            disturb(&noisy[d], &state);
        }
        struct method_result found = method_a(test), found_b = method_b(test);
        spread_add(&mt, &found.mt[0][0], &r->mt[0][0], &found.mt_std[0][0]);
        spread_add(&bt, &found.bt[0][0], &r->bt[0][0], &found.bt_std[0][0]);
        spread_add(&b, &found_b.mt[0][0], &biased.mt[0][0], &found_b.mt_std[0][0]);
    }
    assert_spread(&mt, "Mt");
    assert_spread(&bt, "Bt");
    assert_spread(&b, "Mt of method B");
}

/* The whole way, with white noise of the paper's sensors: 50 um / sqrt(12) on lengths, 20 kPa / sqrt(3) on pressures. */
static void predicted_std_is_the_spread_over_noisy_sensors(void **unused) {
    (void)unused;
    struct rig *r = rig_create(17, 0.5);
    struct ident *id = ident_create(r);
    struct spread mt = {0}, bt = {0};
    uint64_t state = 4;
    for (int run = 0; run < 400; run++) {
        for (int d = 0; d < DOFS; d++)
            for (int i = 0; i < r->samples; i++) {
                struct cycle c = r->cycle[d][i];
                for (int leg = 0; leg < LEGS; leg++) {
                    c.in.length_m[leg] += 14.4e-6 * random_normal(&state);
                    c.in.p1_pa[leg] += 11.5e3 * random_normal(&state);
                    c.in.p2_pa[leg] += 11.5e3 * random_normal(&state);
                }
                ident_feed(id, &c);
            }
        ident_end(id);
        assert_true(ident_solve(id));
        const struct method_result *a = &id->result.method_a;
        spread_add(&mt, &a->mt[0][0], &r->mt[0][0], &a->mt_std[0][0]);
        spread_add(&bt, &a->bt[0][0], &r->bt[0][0], &a->bt_std[0][0]);
    }
    assert_spread(&mt, "Mt");
    assert_spread(&bt, "Bt");
}

static void errors_in_percent_keep_their_sign_by_magnitude(void **unused) {
    (void)unused;
    struct identification id = {.nominal_mt = {[0][0] = 200, [1][3] = -10}};
    struct method_result m = {.mt = {[0][0] = 202, [1][3] = -5}};
    assert_close(ident_error_pct(&id, &m, &ident_entries[0]), 1, 1e-12);
    assert_string_equal(ident_entries[7].name, "Mt24");
    assert_close(ident_error_pct(&id, &m, &ident_entries[7]), -50, 1e-12);
}

static void cycles_of_no_axis_are_ignored(void **unused) {
    (void)unused;
    struct rig *r = rig_create(18, 1);
    struct ident *id = ident_create(r);
    struct cycle c = r->cycle[0][0];
    c.dof = DOF_NONE;
    assert_false(ident_feed(id, &c));
    c = r->cycle[0][0];
    c.test = -1;
    assert_false(ident_feed(id, &c));
    assert_false(ident_end(id));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(method_a_recovers_inertia_and_damping_of_a_known_machine),
        cmocka_unit_test(fundamentals_are_those_of_the_motion),
        cmocka_unit_test(order_of_the_tests_changes_no_bit),
        cmocka_unit_test(what_came_before_the_evaluated_part_changes_no_bit),
        cmocka_unit_test(excluded_samples_are_counted_and_never_used),
        cmocka_unit_test(a_test_ends_with_its_evaluated_part),
        cmocka_unit_test(a_test_cut_short_is_not_complete_and_no_method_uses_it),
        cmocka_unit_test(a_test_without_a_usable_sample_is_not_complete),
        cmocka_unit_test(a_slower_rate_is_complete_too),
        cmocka_unit_test(a_repeated_test_replaces_the_earlier_one),
        cmocka_unit_test(without_all_six_axes_no_method_is_evaluated),
        cmocka_unit_test(modified_a_replaces_the_couplings_by_their_mean_with_the_nominal_signs),
        cmocka_unit_test(viscous_legs_have_the_damping_of_the_method),
        cmocka_unit_test(method_b_maps_acceleration_in_phase_to_wrench_in_phase),
        cmocka_unit_test(damping_biases_method_b_by_unwanted_motion_in_quadrature),
        cmocka_unit_test(without_damping_or_quadrature_method_b_is_exact),
        cmocka_unit_test(condition_is_one_for_perfect_tests_and_singular_ones_give_no_number),
        cmocka_unit_test(tests_of_different_frequencies_can_be_combined),
        cmocka_unit_test(predicted_std_is_the_spread_over_noisy_coefficients),
        cmocka_unit_test(predicted_std_is_the_spread_over_noisy_sensors),
        cmocka_unit_test(errors_in_percent_keep_their_sign_by_magnitude),
        cmocka_unit_test(cycles_of_no_axis_are_ignored),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
