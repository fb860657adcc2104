/* Claims that are true for one machine are true for others: the three of config/ and random ones
 * with six different joints, legs and axes of inertia. */
#include "closed_form_rig.h"

#include "kinematics.h"
#include "lin.h"
#include "nominal.h"
#include "workspace.h"

enum { FILES = 3, MACHINES = 20 };
static const char *const files[FILES] = {"config/tian2015.yaml", "config/desktop.yaml", "config/simulator.yaml"};

static struct params machine_of(const char *file) {
    struct params params;
    struct error error;
    if (config_load(&params, file, NULL, 0, &error)) fail_msg("%s", error.text);
    params.sensors.enabled = false;
    return params;
}

/* Returns a file's machine with every number slightly off: joints by 3 % of the upper ones'
 * distance, the legs' values by 20 %. */
static struct params machine_at_random(const char *file, uint64_t *seed) {
    struct params p = machine_of(file);
    struct kinematics k;
    struct actuator_params *a = &p.actuator;
    kinematics_place(&k, &p);
    double h = p.payload.center_height_m, product = 0.1 * p.payload.inertia_xx_kg_m2;
    p.geometry.upper.given = p.geometry.lower.given = true;
    for (int leg = 0; leg < LEGS; leg++) {
        double *of[] = {a->upper_mass_kg,  a->lower_mass_kg,  a->upper_inertia_kg_m2, a->lower_inertia_kg_m2,
                        a->upper_center_m, a->lower_center_m, a->piston_diameter_m};
        for (size_t i = 0; i < sizeof of / sizeof *of; i++) of[i][leg] *= 1.0 + 0.2 * random_unit(seed);
        for (int r = 0; r < 3; r++) {
            p.geometry.upper.leg[leg][r] = k.upper[leg][r] - (r == 2 ? h : 0.0) + 0.03 * k.arm_m * random_unit(seed);
            p.geometry.lower.leg[leg][r] = k.lower[leg][r] - (r == 2 ? h + p.geometry.height_m : 0.0) + 0.03 * k.arm_m * random_unit(seed);
        }
    }
    p.payload.center_x_m = 0.1 * k.arm_m * random_unit(seed), p.payload.center_y_m = 0.1 * k.arm_m * random_unit(seed);
    p.payload.inertia_xy_kg_m2 = product * random_unit(seed), p.payload.inertia_xz_kg_m2 = product * random_unit(seed);
    p.payload.inertia_yz_kg_m2 = product * random_unit(seed);
    return p;
}

static struct params next(int i, uint64_t *seed) { return i < FILES ? machine_of(files[i]) : machine_at_random(files[i % FILES], seed); }

static struct kinematics kinematics_of(const struct params *p) {
    struct kinematics k;
    struct error error;
    if (kinematics_init(&k, p, &error)) fail_msg("%s", error.text);
    return k;
}

/* Draws a pose within a tenth of the upper joints' distance and 0.1 rad. */
static void pose_near(const struct kinematics *k, uint64_t *seed, double pose[DOFS]) {
    for (int i = 0; i < DOFS; i++) pose[i] = (i < 3 ? 0.1 * k->arm_m : 0.1) * random_unit(seed);
}

static void core_and_plant_have_the_joints_where_the_drawing_has_them(void **unused) {
    (void)unused;
    uint64_t seed = 1;
    for (int i = 0; i < MACHINES; i++) {
        struct params p = next(i, &seed);
        struct kinematics k = kinematics_of(&p);
        struct sim_geometry g;
        const double center[3] = {p.payload.center_x_m, p.payload.center_y_m, -p.payload.center_height_m};
        sim_geometry_init(&g, &p);
        for (int leg = 0; leg < LEGS; leg++) {
            double square = 0.0;
            assert_below(distance(g.upper[leg], k.upper[leg], 3), 1e-14);
            assert_below(distance(g.lower[leg], k.lower[leg], 3), 1e-14);
            assert_close(g.neutral_length_m[leg], k.neutral_length_m[leg], 1e-14);
            for (int r = 0; r < 3 && p.geometry.upper.given; r++) {
                double up = p.geometry.upper.leg[leg][r], low = p.geometry.lower.leg[leg][r] + (r == 2 ? p.geometry.height_m : 0.0);
                assert_close(k.upper[leg][r], up - center[r], 1e-15 * 8);
                assert_close(k.lower[leg][r], low - center[r], 1e-15 * 8);
                square += (up - low) * (up - low);
            }
            if (p.geometry.upper.given) assert_close(k.neutral_length_m[leg], sqrt(square), 1e-14);
        }
    }
}

/* A geometry given by circles, and the same geometry given by its points, have the same lengths to
 * the last bit. */
static void circles_and_their_points_are_one_machine(void **unused) {
    (void)unused;
    for (int i = 0; i < FILES; i++) {
        struct params p = machine_of(files[i]), listed = p;
        struct kinematics k = kinematics_of(&p);
        listed.geometry.upper.given = listed.geometry.lower.given = true;
        for (int leg = 0; leg < LEGS; leg++)
            for (int r = 0; r < 3; r++) {
                double center = r == 0 ? p.payload.center_x_m : r == 1 ? p.payload.center_y_m : -p.payload.center_height_m;
                listed.geometry.upper.leg[leg][r] = k.upper[leg][r] + center;
                listed.geometry.lower.leg[leg][r] = k.lower[leg][r] + center - (r == 2 ? p.geometry.height_m : 0.0);
            }
        struct kinematics same = kinematics_of(&listed);
        assert_below(distance(same.neutral_length_m, k.neutral_length_m, LEGS), 1e-14);
        assert_close(same.arm_m, k.arm_m, 1e-14);
    }
}

static void lengths_give_the_pose_back(void **unused) {
    (void)unused;
    uint64_t seed = 2;
    for (int i = 0; i < MACHINES; i++) {
        struct params p = next(i, &seed);
        struct kinematics k = kinematics_of(&p);
        for (int n = 0; n < 50; n++) {
            double pose[DOFS], found[DOFS] = {0}, length_m[LEGS];
            pose_near(&k, &seed, pose);
            ik_lengths(&k, pose, length_m);
            assert_true(fk_solve(&k, length_m, found).converged);
            assert_below(distance(pose, found, DOFS), 1e-11);
        }
    }
}

/* Two derivations of the 13 bodies' mass matrix agree: the closed form (A1)-(A6) and the
 * simulation's. */
static void the_nominal_matrix_is_that_of_the_simulated_bodies(void **unused) {
    (void)unused;
    uint64_t seed = 3;
    for (int i = 0; i < MACHINES; i++) {
        struct params p = next(i, &seed);
        struct kinematics k = kinematics_of(&p);
        struct rigid_model m;
        rigid_model_init(&m, &p);
        for (int n = 0; n < 10; n++) {
            double pose[DOFS], mass[DOFS][DOFS], load[DOFS], nominal[DOFS][DOFS];
            struct rigid_state s;
            struct rigid_legs legs;
            pose_near(&k, &seed, pose);
            rigid_rest(&s, pose);
            rigid_legs(&m, &s, &legs);
            rigid_dynamics(&m, &s, &legs, mass, load);
            nominal_matrix(&p, &k, pose, nominal);
            for (int r = 0; r < DOFS; r++)
                for (int c = 0; c <= r; c++) assert_close(mass[r][c], nominal[r][c], 1e-12 * sqrt(nominal[r][r] * nominal[c][c]));
        }
    }
}

/* Returns the state after 0.2 s from rest, under the holding forces plus a tenth of them at 4 Hz,
 * with another phase on every leg. */
static struct plant_truth shaken(const struct engine_ops *ops, const struct params *params) {
    static const struct hydraulics_state empty;
    static const double neutral[DOFS], dt_s = 6.25e-5;
    struct plant_truth truth = {0};
    struct error error;
    double weight_n[LEGS], force_n[LEGS];
    struct engine *e = ops->create(params, &error);
    assert_non_null(e);
    ops->place(e, neutral, (const double[LEGS]){0});
    holding_forces(params, neutral, weight_n);
    for (int i = 0; i < 3200; i++) {
        for (int k = 0; k < LEGS; k++) force_n[k] = weight_n[k] * (1.0 + 0.1 * cos(2.0 * PI * 4.0 * i * dt_s + 2.1 * k));
        ops->forced(e, dt_s, force_n);
    }
    ops->truth(e, &empty, &truth);
    ops->destroy(e);
    return truth;
}

/* ODE has joints and 13 bodies, the closed form 6 equations. They differ by 1e-7 of the motion,
 * because of the step's order and the parts' inertia about the leg. */
static void both_engines_move_alike(void **unused) {
    (void)unused;
    slow_case();
    uint64_t seed = 4;
    for (int i = 0; i < 6; i++) {
        struct params p = next(i, &seed);
        double arm_m = kinematics_of(&p).arm_m;
        struct plant_truth a = shaken(&engine_ode, &p), b = shaken(&engine_closed_form, &p);
        double moved = distance(b.pose, (double[DOFS]){0}, 3) / arm_m;
        print_message("moved by %.2g of the arm; apart by %.1e of that, %.1e rad\n", moved, distance(a.pose, b.pose, 3) / arm_m / moved,
                      distance(a.pose + 3, b.pose + 3, 3));
        assert_below(1e-3, moved);
        assert_below(distance(a.pose, b.pose, 3) / arm_m, 1e-6 * moved);
        assert_below(distance(a.pose + 3, b.pose + 3, 3), 1e-7);
        assert_close(a.kinetic_j, b.kinetic_j, 1e-4 * b.kinetic_j);
    }
}

/* The worst pose is within the strokes and is as bad as reported. Legs that lie nearly in planes
 * through z withstand hardly any yaw moment. */
static void the_workspace_says_how_well_the_legs_hold(void **unused) {
    (void)unused;
    struct params p = machine_of("config/simulator.yaml");
    struct kinematics k = kinematics_of(&p);
    struct workspace w = workspace_find(&k, &p);
    double j[LEGS][DOFS], value[DOFS], length_m[LEGS];
    assert_int_equal(w.reached, w.corners);
    assert_true(w.nearest == 1.0 && w.worst_condition >= w.neutral_condition);
    ik_lengths(&k, w.worst_pose, length_m);
    for (int i = 0; i < LEGS; i++) /* the pose is within the strokes */
        assert_true(length_m[i] > p.limits.length_min_m[i] - 1e-6 && length_m[i] < p.limits.length_max_m[i] + 1e-6);
    ik_jacobian(&k, w.worst_pose, j);
    for (int i = 0; i < LEGS; i++)
        for (int r = 3; r < DOFS; r++) j[i][r] /= k.arm_m;
    assert_int_equal(lin_singular_values(LEGS, DOFS, j[0], value), 0);
    assert_close(value[0] / value[DOFS - 1], w.worst_condition, 1e-9 * w.worst_condition);

    p.geometry.upper_half_angle_rad = PI / 3 - p.geometry.lower_half_angle_rad - 0.05;
    k = kinematics_of(&p);
    w = workspace_find(&k, &p);
    assert_true(w.reached < w.corners && w.nearest < 0.5);
    ik_jacobian(&k, w.nearest_pose, j);
    for (int i = 0; i < LEGS; i++)
        for (int r = 3; r < DOFS; r++) j[i][r] /= k.arm_m;
    assert_int_equal(lin_singular_values(LEGS, DOFS, j[0], value), 0);
    /* in the pose where the search ended, the legs withstand hardly any yaw moment */
    assert_below(value[DOFS - 1] / value[0], 0.02);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(core_and_plant_have_the_joints_where_the_drawing_has_them),
        cmocka_unit_test(circles_and_their_points_are_one_machine),
        cmocka_unit_test(lengths_give_the_pose_back),
        cmocka_unit_test(the_nominal_matrix_is_that_of_the_simulated_bodies),
        cmocka_unit_test(both_engines_move_alike),
        cmocka_unit_test(the_workspace_says_how_well_the_legs_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
