/* The ODE engine alone: bodies, joints, memory, threads. test_engines.c compares it with the closed
 * form. */
#include <ode/ode.h>
#include <pthread.h>
#include <stdlib.h>

#include "engine.h"
#include "support.h"
#include "units.h"

static const double DT_S = 2.5e-4;
enum { BODIES_AND_JOINTS = 13 + 18 };

static long heap_calls;
#if !SANITIZED
/* Counts every allocation of the process, including ODE's. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *malloc(size_t size) { return heap_calls++, __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return heap_calls++, __libc_calloc(count, size); }
void *realloc(void *old, size_t size) { return heap_calls++, __libc_realloc(old, size); }
#endif

static struct engine *engine_at(const struct params *p, const double pose[DOFS]) {
    struct error error;
    struct engine *e = engine_ode.create(p, &error);
    assert_non_null(e);
    e->ops->place(e, pose, (const double[LEGS]){0});
    return e;
}

static const struct hydraulics_state EMPTY;
static const double NEUTRAL[DOFS] = {0};
static const double TILTED[DOFS] = {0.05, -0.08, -0.06, 0.11, -0.09, 0.17};

static const double WEIGHT_N = 528.4; /* a leg's share of the weight at neutral */

/* The forces differ from leg to leg, so that the platform moves in all six axes. */
static void uneven_forces(double time_s, double force_n[LEGS]) {
    for (int i = 0; i < LEGS; i++) force_n[i] = WEIGHT_N + 100.0 * sin(2.0 * PI * 4.0 * time_s + i);
}

/* Returns the length of a leg, computed from the platform's pose alone. */
static double length_of_pose(const struct sim_geometry *g, const double pose[DOFS], int leg) {
    dMatrix3 x, y, z, zy, rotation;
    dRFromAxisAndAngle(x, 1, 0, 0, pose[DOF_PHI]);
    dRFromAxisAndAngle(y, 0, 1, 0, pose[DOF_THETA]);
    dRFromAxisAndAngle(z, 0, 0, 1, pose[DOF_PSI]);
    dMultiply0_333(zy, z, y);
    dMultiply0_333(rotation, zy, x);
    dVector3 a;
    dMultiply0_331(a, rotation, g->upper[leg]);
    for (int k = 0; k < 3; k++) a[k] += pose[k] - g->lower[leg][k];
    return sqrt(dCalcVectorDot3(a, a));
}

static void place_puts_every_body_where_the_pose_says(void **state) {
    (void)state;
    struct params p;
    struct sim_geometry g;
    struct plant_truth t;
    config_default(&p);
    sim_geometry_init(&g, &p);
    struct engine *e = engine_at(&p, TILTED);
    e->ops->truth(e, &EMPTY, &t);
    assert_below(distance(t.pose, TILTED, DOFS), 1e-14); /* tolerance for rounding */
    for (int k = 0; k < DOFS; k++) {
        assert_close(t.length_m[k], length_of_pose(&g, TILTED, k), 1e-14);
        assert_true(t.twist[k] == 0.0);
        assert_true(t.rate_mps[k] == 0.0);
    }
    assert_true(t.kinetic_j == 0.0);
    e->ops->place(e, NEUTRAL, (const double[LEGS]){0});
    e->ops->truth(e, &EMPTY, &t);
    assert_below(fabs(t.potential_j), 1e-10); /* tolerance: rounding of 5 kJ */
    e->ops->destroy(e);
}

/* The integrator is of second order: the relative error is about (dt / duration)^2 = 1e-6. A wrong
 * inertia, force or sign shows in the first digits. */
static void energy_balance_closes_under_constant_forces(void **state) {
    (void)state;
    const double force_n[LEGS] = {700, 640, 650, 690, 660, 680};
    struct params p;
    struct plant_truth start, t;
    config_default(&p);
    struct engine *e = engine_at(&p, NEUTRAL);
    e->ops->truth(e, &EMPTY, &start);
    for (int i = 1; i <= 1200; i++) {
        double work_j = 0.0;
        e->ops->forced(e, DT_S, force_n);
        e->ops->truth(e, &EMPTY, &t);
        for (int k = 0; k < LEGS; k++) work_j += force_n[k] * (t.length_m[k] - start.length_m[k]);
        if (i >= 200) assert_close(t.kinetic_j + t.potential_j, work_j, 1e-4 * t.kinetic_j);
    }
    assert_below(50.0, t.kinetic_j); /* it did move */
    e->ops->destroy(e);
}

/* A step is a straight line, so joints that move round each other at speed v separate by (v
 * dt)^2/2r, and each step removes a fifth of the separation. The smallest radius is the platform's,
 * 0.58 m. */
static void joints_drift_apart_by_no_more_than_the_steps_curvature(void **state) {
    (void)state;
    struct params p;
    struct sim_geometry g;
    struct plant_truth t;
    double drift_m = 0.0, speed_mps = 0.0;
    config_default(&p);
    sim_geometry_init(&g, &p);
    struct engine *e = engine_at(&p, NEUTRAL);
    for (int i = 0; i < 2000; i++) {
        double force_n[LEGS];
        uneven_forces(i * DT_S, force_n);
        e->ops->forced(e, DT_S, force_n);
        e->ops->truth(e, &EMPTY, &t);
        speed_mps = fmax(speed_mps, sqrt(dCalcVectorDot3(t.twist, t.twist)) + 0.58 * sqrt(dCalcVectorDot3(t.twist + 3, t.twist + 3)));
        for (int k = 0; k < LEGS; k++) {
            assert_true(isfinite(t.length_m[k]));
            drift_m = fmax(drift_m, fabs(t.length_m[k] - length_of_pose(&g, t.pose, k)));
        }
    }
    print_message("%.2g m at %.2g m/s\n", drift_m, speed_mps);
    assert_below(0.1, speed_mps); /* it did move */
    assert_below(drift_m, 5.0 * speed_mps * DT_S * speed_mps * DT_S / (2.0 * 0.58));
    e->ops->destroy(e);
}

/* Returns the creep of the legs in 10 s under a load that friction withstands: constant for 5 s,
 * then oscillating. The requirement is 1 um. */
static double creep_m(const struct params *p, double load_n) {
    struct plant_truth start, t;
    double creep = 0.0;
    struct engine *e = engine_at(p, NEUTRAL);
    e->ops->truth(e, &EMPTY, &start);
    for (int i = 0; i < 40000; i++) {
        double force_n[LEGS], swing = i < 20000 ? 1.0 : cos(2.0 * PI * 4.0 * i * DT_S);
        for (int k = 0; k < LEGS; k++) force_n[k] = WEIGHT_N + (k % 2 ? load_n : -load_n) * swing;
        e->ops->forced(e, DT_S, force_n);
        if (i % 100 < 99) continue;
        e->ops->truth(e, &EMPTY, &t);
        assert_below(distance(t.length_m, start.length_m, LEGS), 1e-6);
        creep = fmax(creep, distance(t.length_m, start.length_m, LEGS));
    }
    e->ops->destroy(e);
    return creep;
}

static void legs_below_their_capacity_do_not_creep(void **state) {
    (void)state;
    slow_case();
    struct params p;
    config_default(&p);
    set_effect(&p, "cylinder_coulomb_friction", 0, 200.0);
    set_effect(&p, "cylinder_coulomb_friction", 1, 200.0);
    print_message("%.2g m\n", creep_m(&p, 198.0));
}

/* 20 N m about each of 24 axes withstand a twist of 8 N per leg. */
static void joints_below_their_capacity_do_not_creep(void **state) {
    (void)state;
    numbers_case();
    struct params p;
    config_default(&p);
    set_effect(&p, "passive_joint_friction", 0, 20.0);
    print_message("%.2g m\n", creep_m(&p, 8.0));
}

/* Friction dissipates exactly force times path. The path is the sum of length changes in each
 * substep, which cuts off a thousandth at most at reversals. */
static void sliding_takes_force_times_path(void **state) {
    (void)state;
    const double extend_n = 60.0, retract_n = 40.0;
    struct params p;
    struct plant_truth before, t;
    config_default(&p);
    set_effect(&p, "cylinder_coulomb_friction", 0, extend_n);
    set_effect(&p, "cylinder_coulomb_friction", 1, retract_n);
    struct engine *e = engine_at(&p, NEUTRAL);
    double work_j = 0.0, lost_j = 0.0;
    e->ops->truth(e, &EMPTY, &before);
    for (int i = 0; i < 4000; i++) {
        double force_n[LEGS];
        uneven_forces(i * DT_S, force_n);
        e->ops->forced(e, DT_S, force_n);
        e->ops->truth(e, &EMPTY, &t);
        for (int k = 0; k < LEGS; k++) {
            double step_m = t.length_m[k] - before.length_m[k];
            work_j += force_n[k] * step_m;
            lost_j += step_m > 0.0 ? extend_n * step_m : -retract_n * step_m;
        }
        before = t;
    }
    print_message("lost %.4f J of %.4f J\n", work_j - t.kinetic_j - t.potential_j, lost_j);
    assert_below(0.1, lost_j);
    assert_close(work_j - t.kinetic_j - t.potential_j, lost_j, 0.001 * lost_j);
    e->ops->destroy(e);
}

static void joint_friction_only_takes_energy(void **state) {
    (void)state;
    const double nothing[LEGS] = {0};
    struct params p;
    struct plant_truth t;
    config_default(&p);
    set_effect(&p, "passive_joint_friction", 0, 10.0);
    set_effect(&p, "passive_joint_friction", 1, 10.0);
    struct engine *e = engine_at(&p, TILTED);
    e->ops->truth(e, &EMPTY, &t);
    double start_j = t.potential_j, energy_j = start_j;
    for (int i = 0; i < 400; i++) {
        e->ops->forced(e, DT_S, nothing);
        e->ops->truth(e, &EMPTY, &t);
        /* tolerance: energy is tens of J, and the kinetic energy is of second order in the step */
        assert_below(t.kinetic_j + t.potential_j, energy_j + 1e-4);
        energy_j = t.kinetic_j + t.potential_j;
    }
    assert_below(1.0, t.kinetic_j); /* it does fall */
    assert_below(energy_j, start_j - 1.0);
    e->ops->destroy(e);
}

/* Sets dry friction in legs and joints, with which the engine has the most rows. */
static void all_frictions(struct params *p) {
    config_default(p);
    set_effect(p, "cylinder_coulomb_friction", 0, 150.0);
    set_effect(p, "cylinder_coulomb_friction", 1, 100.0);
    set_effect(p, "passive_joint_friction", 0, 3.0);
    set_effect(p, "passive_joint_friction", 1, 5.0);
}

struct run {
    struct engine *engine;
    int substeps;
    struct plant_truth end;
};

static void *run(void *argument) {
    struct run *r = argument;
    double valve[LEGS];
    struct hydraulics_state hydraulics = {0};
    for (int k = 0; k < LEGS; k++) hydraulics.cylinder[k] = (struct cylinder_state){.p1_pa = 5e6, .p2_pa = 9.8e6};
    memset(&r->end, 0, sizeof r->end);
    for (int i = 0; i < r->substeps; i++) {
        for (int k = 0; k < LEGS; k++) valve[k] = -0.075 + 0.05 * sin(2.0 * PI * 4.0 * i * DT_S + k);
        r->engine->ops->substep(r->engine, DT_S, valve, &hydraulics);
        r->engine->ops->truth(r->engine, &hydraulics, &r->end);
    }
    return NULL;
}

static void no_heap_after_create(void **state) {
    (void)state;
    struct params p;
    all_frictions(&p);
    long before = heap_calls;
    struct run r = {.engine = engine_at(&p, NEUTRAL), .substeps = 400};
    /* a sanitizer's allocator hides ODE's allocations */
    if (!SANITIZED) assert_true(heap_calls - before > BODIES_AND_JOINTS);
    before = heap_calls;
    run(&r);
    r.engine->ops->place(r.engine, TILTED, (const double[LEGS]){0});
    run(&r);
    assert_int_equal(heap_calls - before, 0);
    r.engine->ops->destroy(r.engine);
}

static void same_run_gives_the_same_bits_in_any_thread(void **state) {
    (void)state;
    struct params p;
    all_frictions(&p);
    struct run first = {.engine = engine_at(&p, TILTED), .substeps = 400}, second = first;
    struct engine *bystander = engine_at(&p, NEUTRAL);
    run(&first);
    bystander->ops->destroy(bystander);

    /* the engine is created in this thread and stepped in the other, after a use that place() must
     * undo */
    pthread_t thread;
    second.engine = engine_at(&p, NEUTRAL);
    run(&second);
    second.engine->ops->place(second.engine, TILTED, (const double[LEGS]){0});
    assert_int_equal(pthread_create(&thread, NULL, run, &second), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_true(isfinite(first.end.pose[0]));
    assert_memory_equal(&first.end, &second.end, sizeof first.end);
    first.engine->ops->destroy(first.engine);
    second.engine->ops->destroy(second.engine);
}

static int solver_messages;
static void count_message(int number, const char *format, va_list args) {
    (void)number;
    (void)format;
    (void)args;
    solver_messages++;
}

/* ODE's solver reports a step that it gives up only by a message (no_message). The test counts
 * these messages while friction slides and sticks, with all rows present. */
static void solver_never_gives_up_a_step(void **state) {
    (void)state;
    struct params p;
    all_frictions(&p);
    struct engine *e = engine_at(&p, NEUTRAL);
    dSetMessageHandler(count_message);
    for (int i = 0; i < 4000; i++) {
        double force_n[LEGS];
        for (int k = 0; k < LEGS; k++) force_n[k] = WEIGHT_N + 600.0 * sin(2.0 * PI * 2.0 * i * DT_S) * sin(2.0 * PI * 4.0 * i * DT_S + k);
        e->ops->forced(e, DT_S, force_n);
    }
    assert_int_equal(solver_messages, 0);
    e->ops->destroy(e);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(place_puts_every_body_where_the_pose_says),
        cmocka_unit_test(energy_balance_closes_under_constant_forces),
        cmocka_unit_test(joints_drift_apart_by_no_more_than_the_steps_curvature),
        cmocka_unit_test(legs_below_their_capacity_do_not_creep),
        cmocka_unit_test(joints_below_their_capacity_do_not_creep),
        cmocka_unit_test(sliding_takes_force_times_path),
        cmocka_unit_test(joint_friction_only_takes_energy),
        cmocka_unit_test(no_heap_after_create),
        cmocka_unit_test(same_run_gives_the_same_bits_in_any_thread),
        cmocka_unit_test(solver_never_gives_up_a_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
