/* The closed-form engine's dry friction against Gauss' principle and against physical bounds of
 * friction. */
#include "closed_form_rig.h"

#include "stick.h"
#include "vec.h"

static void friction_at_rest_satisfies_gauss_principle(void **unused) {
    (void)unused;
    uint64_t seed = 8;
    int slipping = 0, holding = 0;
    for (int trial = 0; trial < 500; trial++) {
        struct stick_coordinate c[30] = {0};
        double x[DOFS];
        int count = 1 + random_below(&seed, 30); /* most sets are linearly dependent */
        for (int i = 0; i < DOFS; i++) x[i] = random_unit(&seed);
        double start[DOFS];
        memcpy(start, x, sizeof x);
        for (int k = 0; k < count; k++) {
            for (int i = 0; i < DOFS; i++) c[k].row[i] = k > 0 && k % 3 == 0 ? -2.0 * c[k - 1].row[i] : 0.1 * random_unit(&seed);
            c[k].extend_limit = 5.0 * fabs(random_unit(&seed));
            c[k].retract_limit = k % 5 == 0 ? 0.0 : 5.0 * fabs(random_unit(&seed));
        }
        stick_resolve(c, count, start);
        for (int k = 0; k < count; k++) add6(c[k].force, c[k].row, x);
        for (int k = 0; k < count; k++) {
            double acceleration = dot6(c[k].row, x);
            assert_true(c[k].force >= -c[k].extend_limit - 1e-8 && c[k].force <= c[k].retract_limit + 1e-8);
            if (c[k].slip == 0) assert_below(fabs(acceleration), 2e-6);
            if (c[k].slip > 0) assert_true(acceleration > 0.0 && c[k].force < -c[k].extend_limit + 1e-5);
            if (c[k].slip < 0) assert_true(acceleration < 0.0 && c[k].force > c[k].retract_limit - 1e-5);
            slipping += c[k].slip != 0;
            holding += c[k].slip == 0;
        }
    }
    assert_true(slipping > 500 && holding > 500);
}

static void held_basis_stops_dependent_rows_too(void **unused) {
    (void)unused;
    uint64_t seed = 9;
    struct stick_basis basis = {0};
    double row[30][DOFS], common[4][DOFS], x[DOFS];
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < DOFS; i++) common[k][i] = random_unit(&seed);
    for (int k = 0; k < 30; k++) {
        memset(row[k], 0, sizeof row[k]);
        for (int i = 0; i < 4; i++) add6(random_unit(&seed), common[i], row[k]);
        stick_basis_add(&basis, row[k], 0.0);
    }
    assert_int_equal(basis.rank, 4);
    for (int i = 0; i < DOFS; i++) x[i] = random_unit(&seed);
    stick_hold(&basis, 1.0, x);
    for (int k = 0; k < 30; k++) assert_below(fabs(dot6(row[k], x)), 1e-12);
}

/* Returns the largest change of a leg's length in ten seconds under a load on every leg. */
static double creep(const struct params *params, double load_n) {
    const double pose[DOFS] = {0.02, -0.01, -0.05, 0.03, -0.02, 0.05};
    double force[LEGS];
    struct plant *plant = plant_at(params, pose);
    struct plant_truth start = truth_of(plant);
    holding_forces(params, pose, force);
    for (int k = 0; k < LEGS; k++) force[k] += load_n * (k % 2 ? 1.0 : 0.8);
    for (int i = 0; i < 40000; i++) plant_step_forced(plant, SUBSTEP_S, force);
    struct plant_truth end = truth_of(plant);
    plant_destroy(plant);
    return distance(start.length_m, end.length_m, LEGS);
}

static void legs_below_their_capacity_do_not_creep(void **unused) {
    (void)unused;
    slow_case();
    struct params params = defaults();
    set_effect(&params, "cylinder_coulomb_friction", 0, 300.0);
    set_effect(&params, "cylinder_coulomb_friction", 1, 100.0);
    /* the legs do not move at all, although 1 um would be accepted */
    assert_below(creep(&params, 295.0), 1e-12);
    assert_below(creep(&params, -95.0), 1e-12);
}

static void joints_below_their_capacity_do_not_creep(void **unused) {
    (void)unused;
    slow_case();
    struct params params = defaults();
    set_effect(&params, "passive_joint_friction", 0, 5.0);
    assert_below(creep(&params, 2.0), 1e-12);
    assert_below(0.01, creep(&params, 4.0)); /* 24 axes of 5 N m withstand about 20 N at the
                                              * platform */
}

/* All legs carry the same load at neutral, so the platform can only rise or sink. Returns its
 * upward acceleration. */
static double rise(const struct params *params, double load_n) {
    double force[LEGS];
    struct plant *plant = plant_at(params, (const double[DOFS]){0});
    holding_forces(params, (const double[DOFS]){0}, force);
    for (int k = 0; k < LEGS; k++) force[k] += load_n;
    for (int i = 0; i < 40; i++) plant_step_forced(plant, SUBSTEP_S, force);
    struct plant_truth end = truth_of(plant);
    for (int k = 0; k < LEGS; k++) assert_true(end.stuck[k] == (end.rate_mps[k] == 0.0 || fabs(end.rate_mps[k]) < 1e-12));
    plant_destroy(plant);
    return -end.twist[DOF_Z] / 0.01;
}

static void slip_starts_at_the_capacity_of_each_direction(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct sim_geometry g;
    set_effect(&params, "cylinder_coulomb_friction", 0, 300.0);
    set_effect(&params, "cylinder_coulomb_friction", 1, 100.0);
    sim_geometry_init(&g, &params);
    /* the value of mz in docs/method.md, section 3 */
    double per_newton = LEGS * params.geometry.height_m / g.neutral_length_m[0] / 272.392;
    assert_below(fabs(rise(&params, 299.9)), 1e-12);
    assert_below(fabs(rise(&params, -99.9)), 1e-12);
    /* tolerance: the legs rotate a little in 10 ms */
    assert_close(rise(&params, 310.0), 10.0 * per_newton, 1e-4 * 10.0 * per_newton);
    assert_close(rise(&params, -110.0), -10.0 * per_newton, 1e-4 * 10.0 * per_newton);
}

/* Applies forces that make every leg reverse repeatedly; they are constant over 1 ms, so that the
 * substep does not matter. */
static void shaken(const struct params *params, double dt, double scale, struct plant_truth *end, double *work, double path[LEGS]) {
    double hold[LEGS], force[LEGS], last[LEGS];
    int per_ms = (int)round(1e-3 / dt);
    struct plant *plant = plant_at(params, (const double[DOFS]){0});
    holding_forces(params, (const double[DOFS]){0}, hold);
    struct plant_truth now = truth_of(plant);
    *work = 0.0;
    memset(path, 0, LEGS * sizeof *path);
    for (int ms = 0; ms < 500; ms++) {
        for (int k = 0; k < LEGS; k++) force[k] = hold[k] + scale * sin(2 * PI * 8 * 1e-3 * ms + 0.9 * k);
        for (int i = 0; i < per_ms; i++) {
            memcpy(last, now.length_m, sizeof last);
            plant_step_forced(plant, dt, force);
            now = truth_of(plant);
            for (int k = 0; k < LEGS; k++) {
                *work += force[k] * (now.length_m[k] - last[k]);
                path[k] += fabs(now.length_m[k] - last[k]);
            }
        }
    }
    *end = now;
    plant_destroy(plant);
}

static void dry_friction_takes_force_times_path(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct plant_truth end;
    double work, path[LEGS], heat = 0.0;
    set_effect(&params, "cylinder_coulomb_friction", 0, 60.0);
    set_effect(&params, "cylinder_coulomb_friction", 1, 60.0);
    shaken(&params, SUBSTEP_S / 4, 300.0, &end, &work, path);
    for (int k = 0; k < LEGS; k++) heat += 60.0 * path[k];
    assert_true(heat > 1.0);
    /* tolerance: the path lacks each leg's return within the substep of its reversal, 1 nm at 5
     * m/s^2, 50 times, times 60 N */
    assert_close(end.kinetic_j + end.potential_j + heat, work, 1e-5);
}

static void reversals_fall_where_they_must_whatever_the_substep(void **unused) {
    (void)unused;
    for (int joints = 0; joints < 2; joints++) {
        struct params params = defaults();
        struct plant_truth coarse, fine;
        double work, path[LEGS];
        set_effect(&params, joints ? "passive_joint_friction" : "cylinder_coulomb_friction", 0, joints ? 8.0 : 60.0);
        if (!joints) set_effect(&params, "cylinder_coulomb_friction", 1, 90.0);
        shaken(&params, SUBSTEP_S, 300.0, &coarse, &work, path);
        shaken(&params, SUBSTEP_S / 4, 300.0, &fine, &work, path);
        /* Tolerance: a leg is released at the start of a substep, when the forces change too; a
         * stop is located to 1 nm/s, some hundred times. */
        assert_below(distance(coarse.pose, fine.pose, DOFS), 2e-8);
    }
}

/* All 24 axes reverse at once in a vertical motion: none may stay held, because it would lock the
 * others. */
static void axes_that_stop_together_are_let_go_together(void **unused) {
    (void)unused;
    struct params params = defaults();
    double height[2];
    set_effect(&params, "passive_joint_friction", 0, 5.0);
    for (int n = 0; n < 2; n++) {
        double dt = n ? SUBSTEP_S / 4 : SUBSTEP_S, hold[LEGS], force[LEGS];
        struct plant *plant = plant_at(&params, (const double[DOFS]){0});
        holding_forces(&params, (const double[DOFS]){0}, hold);
        for (int ms = 0; ms < 600; ms++) {
            for (int k = 0; k < LEGS; k++) force[k] = hold[k] + 150.0 * sin(2 * PI * 4e-3 * ms);
            for (int i = 0; i < (n ? 16 : 4); i++) plant_step_forced(plant, dt, force);
        }
        height[n] = truth_of(plant).pose[DOF_Z];
        plant_destroy(plant);
    }
    assert_close(height[0], height[1], 2e-8); /* as above */
}

static void a_stuck_leg_carries_the_difference_of_pressure_and_load(void **unused) {
    (void)unused;
    slow_case();
    struct params params = defaults();
    double hold[LEGS], start[LEGS];
    set_effect(&params, "cylinder_coulomb_friction", 0, 500.0);
    set_effect(&params, "cylinder_coulomb_friction", 1, 500.0);
    /* pressures stay constant */
    memset(params.hydraulics.leakage_m3_per_s_pa, 0, sizeof params.hydraulics.leakage_m3_per_s_pa);
    struct plant *plant = plant_at(&params, (const double[DOFS]){0});
    holding_forces(&params, (const double[DOFS]){0}, hold);
    memcpy(start, truth_of(plant).length_m, sizeof start);
    for (int i = 0; i < 2; i++) plant_step(plant, (const double[LEGS]){2e-3, -2e-3, 3e-3, -3e-3, 1e-3, 0.0});
    for (int i = 0; i < 5000; i++) plant_step(plant, (const double[LEGS]){0});
    struct plant_truth end = truth_of(plant);
    for (int k = 0; k < LEGS; k++) {
        assert_true(end.stuck[k]);
        assert_close(end.hydraulic_n[k] + end.friction_n[k], hold[k], 1e-5);
    }
    assert_below(10.0, fabs(end.friction_n[0]));
    assert_below(distance(end.length_m, start, LEGS), 1e-12);
    plant_destroy(plant);
}

/* In either engine, with and without backlash, the force of deflected seals adds to the holding
 * force. */
static void a_stuck_leg_carries_its_seals_too(void **unused) {
    (void)unused;
    slow_case();
    for (int i = 0; i < 4; i++) {
        struct params params = defaults();
        double hold[LEGS];
        params.sim.engine = i % 2 ? ENGINE_ODE : ENGINE_CLOSED_FORM;
        for (int key = 0; key < 2; key++) set_effect(&params, "cylinder_coulomb_friction", key, 50.0);
        for (int key = 0; key < 2; key++) set_effect(&params, "cylinder_dahl_friction", key, 150.0);
        set_effect(&params, "cylinder_dahl_friction", 2, 2e-4);
        if (i / 2) set_effect(&params, "joint_backlash", 0, 5e-4);
        memset(params.hydraulics.leakage_m3_per_s_pa, 0, sizeof params.hydraulics.leakage_m3_per_s_pa);
        struct plant *plant = plant_at(&params, (const double[DOFS]){0});
        for (int n = 0; n < 20; n++) plant_step(plant, (const double[LEGS]){0.05, 0.05, 0.05, 0.05, 0.05, 0.05});
        for (int n = 0; n < 1000; n++) plant_step(plant, (const double[LEGS]){0});
        struct plant_truth end = truth_of(plant);
        holding_forces(&params, end.pose, hold);
        for (int k = 0; k < LEGS; k++) {
            assert_true(end.stuck[k] && fabs(end.rate_mps[k]) < 1e-6);
            assert_close(end.hydraulic_n[k] + end.friction_n[k], hold[k], 1.0);
            assert_below(10.0, fabs(end.friction_n[k]));
        }
        plant_destroy(plant);
    }
}

static void legs_that_have_come_to_rest_stay_there(void **unused) {
    (void)unused;
    struct params params = defaults();
    double hold[LEGS], force[LEGS];
    set_effect(&params, "cylinder_coulomb_friction", 0, 100.0);
    set_effect(&params, "cylinder_coulomb_friction", 1, 100.0);
    struct plant *plant = plant_at(&params, (const double[DOFS]){0});
    struct plant_truth start = truth_of(plant), rested, end;
    holding_forces(&params, (const double[DOFS]){0}, hold);
    for (int i = 0; i < 4200; i++) {
        for (int k = 0; k < LEGS; k++) force[k] = hold[k] + (i < 80 ? 150.0 + 20.0 * k : 30.0);
        plant_step_forced(plant, SUBSTEP_S, force);
        if (i == 600) rested = truth_of(plant);
    }
    end = truth_of(plant);
    assert_below(1e-4, distance(start.length_m, rested.length_m, LEGS));
    for (int k = 0; k < LEGS; k++) assert_true(rested.stuck[k]);
    /* the stop is located to 1 nm/s, and afterwards nothing may drift */
    assert_below(distance(rested.length_m, end.length_m, LEGS), 1e-14);
    plant_destroy(plant);
}

/* One leg or its joints are blocked while the others swing freely. All terms with velocities must
 * be right to keep the constraint. */
static void a_held_leg_keeps_its_length_while_the_others_move(void **unused) {
    (void)unused;
    struct params params = defaults();
    int place = effect_find("cylinder_coulomb_friction");
    params.effects[place].on = true;
    params.effects[place].value[0][2] = params.effects[place].value[1][2] = 2e4;
    struct plant *plant = plant_at(&params, (const double[DOFS]){0});
    struct plant_truth start = truth_of(plant), now = start;
    double hold[LEGS], force[LEGS], path = 0.0;
    holding_forces(&params, (const double[DOFS]){0}, hold);
    for (int i = 0; i < 4000; i++) {
        for (int k = 0; k < LEGS; k++) force[k] = hold[k] + 60.0 * cos(2 * PI * 2 * i * SUBSTEP_S + (k == 5 ? 1.0 : 0.0));
        plant_step_forced(plant, SUBSTEP_S, force);
        now = truth_of(plant);
        assert_true(now.stuck[2] && !now.stuck[0]);
        assert_below(fabs(now.rate_mps[2]), 1e-9); /* tolerance: error of one RK4 step */
        path += SUBSTEP_S * fabs(now.rate_mps[0]);
    }
    assert_true(path > 0.1);
    assert_close(now.length_m[2], start.length_m[2], 1e-11);
    plant_destroy(plant);
}

static void held_joints_keep_their_leg_straight_while_it_moves(void **unused) {
    (void)unused;
    struct params params = defaults();
    const double pose[DOFS] = {0.03, -0.05, -0.1, 0.1, -0.08, 0.1};
    int place = effect_find("passive_joint_friction");
    params.effects[place].on = true;
    params.effects[place].value[0][1] = 1e4;
    struct plant *plant = plant_at(&params, pose);
    struct rigid_model m;
    struct rigid_state s;
    struct rigid_legs before, after;
    double hold[LEGS], force[LEGS];
    rigid_model_init(&m, &params);
    rigid_rest(&s, pose);
    rigid_legs(&m, &s, &before);
    holding_forces(&params, pose, hold);
    for (int i = 0; i < 2000; i++) {
        for (int k = 0; k < LEGS; k++) force[k] = hold[k] + 300.0 * sin(2 * PI * 2 * i * SUBSTEP_S);
        plant_step_forced(plant, SUBSTEP_S, force);
    }
    struct plant_truth end = truth_of(plant);
    rigid_rest(&s, end.pose);
    rigid_legs(&m, &s, &after);
    assert_below(0.01, fabs(after.length[1] - before.length[1]));
    for (int i = 0; i < 3; i++) assert_close(after.n[i][1], before.n[i][1], 1e-11);
    plant_destroy(plant);
}

static void joint_friction_alone_slows_a_falling_platform(void **unused) {
    (void)unused;
    double speed[3];
    for (int n = 0; n < 3; n++) {
        struct params params = defaults();
        /* dry, then viscous */
        if (n) set_effect(&params, "passive_joint_friction", n - 1, n == 1 ? 5.0 : 20.0);
        struct plant *plant = plant_at(&params, (const double[DOFS]){0});
        for (int i = 0; i < 400; i++) plant_step_forced(plant, SUBSTEP_S, (const double[LEGS]){0});
        speed[n] = truth_of(plant).twist[DOF_Z];
        plant_destroy(plant);
    }
    assert_true(speed[1] > 0.0 && speed[1] < speed[0]);
    assert_true(speed[2] > 0.0 && speed[2] < speed[0]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(friction_at_rest_satisfies_gauss_principle),
        cmocka_unit_test(held_basis_stops_dependent_rows_too),
        cmocka_unit_test(legs_below_their_capacity_do_not_creep),
        cmocka_unit_test(joints_below_their_capacity_do_not_creep),
        cmocka_unit_test(slip_starts_at_the_capacity_of_each_direction),
        cmocka_unit_test(dry_friction_takes_force_times_path),
        cmocka_unit_test(reversals_fall_where_they_must_whatever_the_substep),
        cmocka_unit_test(axes_that_stop_together_are_let_go_together),
        cmocka_unit_test(a_stuck_leg_carries_the_difference_of_pressure_and_load),
        cmocka_unit_test(a_stuck_leg_carries_its_seals_too),
        cmocka_unit_test(legs_that_have_come_to_rest_stay_there),
        cmocka_unit_test(a_held_leg_keeps_its_length_while_the_others_move),
        cmocka_unit_test(held_joints_keep_their_leg_straight_while_it_moves),
        cmocka_unit_test(joint_friction_alone_slows_a_falling_platform),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
