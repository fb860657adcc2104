/* Inverse dynamics of the controller against both engines of the simulation, with which it shares
 * no equation. */
#include "closed_form_rig.h"

#include "dynamics.h"

static double motion_of(double time_s, double size, double motion[MOTION_ORDERS][DOFS]) {
    double largest = 0.0;
    for (int i = 0; i < DOFS; i++) {
        double a = size * (i < 3 ? 0.08 : 0.1), w = 4.0 + 1.1 * i, phase = 0.7 * i;
        motion[MOTION_POSE][i] = a * (sin(w * time_s + phase) - sin(phase) - w * time_s * cos(phase) * exp(-4.0 * time_s));
        largest = fmax(largest, fabs(motion[MOTION_POSE][i]));
    }
    return largest;
}

/* Computes the pose of the motion, and its rate and acceleration by differences. */
static void motion_at(double time_s, double size, double motion[MOTION_ORDERS][DOFS]) {
    const double h = 1e-4;
    double before[MOTION_ORDERS][DOFS], after[MOTION_ORDERS][DOFS];
    motion_of(time_s, size, motion), motion_of(time_s - h, size, before), motion_of(time_s + h, size, after);
    for (int i = 0; i < DOFS; i++) {
        motion[MOTION_RATE][i] = (after[0][i] - before[0][i]) / (2.0 * h);
        motion[MOTION_ACCEL][i] = (after[0][i] + before[0][i] - 2.0 * motion[0][i]) / (h * h);
    }
}

static struct params lopsided(void) {
    struct params params = defaults();
    all_legs(params.hydraulics.viscous_n_s_per_m, 0.0);
    params.payload.inertia_xy_kg_m2 = 1.5, params.payload.inertia_xz_kg_m2 = -2.0, params.payload.inertia_yz_kg_m2 = 1.0;
    params.payload.inertia_xx_kg_m2 = 20.0;
    params.payload.center_x_m = 0.05, params.payload.center_y_m = -0.03;
    for (int leg = 0; leg < LEGS; leg++) params.actuator.upper_mass_kg[leg] *= 1.0 + 0.1 * leg;
    return params;
}

/* Adds what `hexid gap` may have found of the bodies: each key of these effects gets a part of its
 * typical value. */
static struct params with_found(struct params params) {
    static const char *const names[] = {"payload_mass", "payload_center_of_mass", "payload_rotational_inertia", "actuator_inertia",
                                        "base_tilt",    "external_stiffness"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        int effect = effect_find(names[i]);
        assert_true(effect >= 0);
        effect_at(effect_table[effect], 0.7 + 0.1 * (double)i, &params.effects[effect]);
        params.effects[effect].on = true;
    }
    return params;
}

/* Computes the twist that belongs to the rates of the Euler angles, by differences of the
 * simulation's rotation matrix. */
static void twist_of(double time_s, double size, double twist[DOFS]) {
    const double h = 1e-5;
    double pose[3][MOTION_ORDERS][DOFS], t[2][3][3];
    for (int k = 0; k < 2; k++) {
        motion_of(time_s + (k ? h : -h), size, pose[k]);
        rotation_from_angles(pose[k][0][3], pose[k][0][4], pose[k][0][5], t[k]);
    }
    for (int r = 0; r < 3; r++) twist[r] = (pose[1][0][r] - pose[0][0][r]) / (2.0 * h);
    /* w follows from the rotation matrices: T2 T1' = 1 + 2 h w~ */
    static const int up[3] = {2, 0, 1}, down[3] = {1, 2, 0};
    for (int r = 0; r < 3; r++) {
        double plus = 0.0, minus = 0.0;
        for (int k = 0; k < 3; k++) plus += t[1][up[r]][k] * t[0][down[r]][k], minus += t[1][down[r]][k] * t[0][up[r]][k];
        twist[3 + r] = (plus - minus) / (4.0 * h);
    }
}

static void compare_with_the_lagrangian(struct params params) {
    struct kinematics k;
    struct dynamics d;
    struct rigid_model rigid;
    kinematics_place(&k, &params);
    dynamics_init(&d, &params, &k);
    rigid_model_init(&rigid, &params);
    for (int n = 0; n < 40; n++) {
        double motion[MOTION_ORDERS][DOFS], mass[DOFS][DOFS], load[DOFS], twist[3][DOFS], time_s = 0.05 * n, h = 1e-4, largest = 0.0;
        struct rigid_state state;
        struct rigid_legs legs;
        struct leg_course course;
        motion_at(time_s, 1.0, motion);
        assert_true(dynamics_solve(&d, motion, &course));
        rigid_rest(&state, motion[MOTION_POSE]);
        for (int i = 0; i < 3; i++) twist_of(time_s + (i - 1) * h, 1.0, twist[i]);
        memcpy(state.twist, twist[1], sizeof state.twist);
        rigid_legs(&rigid, &state, &legs);
        rigid_dynamics(&rigid, &state, &legs, mass, load);
        rigid_push(&legs, course.force_n, load);
        for (int i = 0; i < DOFS; i++) {
            double needed = 0.0;
            for (int j = 0; j < DOFS; j++) needed += (j <= i ? mass[i][j] : mass[j][i]) * (twist[2][j] - twist[0][j]) / (2.0 * h);
            /* tolerance: differences are accurate to 1e-5 of 5 m/s^2, times 300 kg */
            assert_close(needed, load[i], 0.02);
            largest = fmax(largest, fabs(needed));
        }
        assert_true(n < 2 || largest > 50.0);
        assert_close(distance(course.length_m, legs.length, LEGS), 0.0, 1e-12);
        assert_close(distance(course.rate_mps, legs.rate, LEGS), 0.0, 1e-6);
    }
}

static void forces_are_those_of_the_lagrangian(void **unused) {
    (void)unused;
    compare_with_the_lagrangian(lopsided());
    compare_with_the_lagrangian(with_found(lopsided()));
}

/* The bodies alone, driven by these forces for half a second, follow the motion. An error of force
 * grows with the square of time: 1 N would be 0.5 mm. ODE's integrator is of first order. */
static void both_engines_follow_the_forces(void **unused) {
    (void)unused;
    for (int i = 0; i < 4; i++) {
        int engine = i % 2 ? ENGINE_ODE : ENGINE_CLOSED_FORM;
        struct params params = i / 2 ? with_found(lopsided()) : lopsided();
        struct kinematics k;
        struct dynamics d;
        params.sim.engine = (enum engine_kind)engine;
        kinematics_place(&k, &params);
        dynamics_init(&d, &params, &k);
        double motion[MOTION_ORDERS][DOFS], end[MOTION_ORDERS][DOFS], error = 0.0;
        motion_at(0.0, 1.0, motion);
        assert_close(distance(motion[MOTION_RATE], (const double[DOFS]){0}, DOFS), 0.0, 1e-4);
        struct plant *plant = plant_at(&params, motion[MOTION_POSE]);
        for (int n = 0; n < 2000; n++) {
            struct leg_course course;
            motion_at((n + 0.5) * SUBSTEP_S, 1.0, motion);
            assert_true(dynamics_solve(&d, motion, &course));
            plant_step_forced(plant, SUBSTEP_S, course.force_n);
        }
        struct plant_truth truth = truth_of(plant);
        assert_true(motion_of(2000 * SUBSTEP_S, 1.0, end) > 0.05);
        error = distance(truth.pose, end[MOTION_POSE], DOFS);
        print_message("# %s: %.2g m or rad off after half a second\n", engine == ENGINE_ODE ? "ode" : "closed form", error);
        assert_below(error, engine == ENGINE_ODE ? 5e-5 : 5e-6);
        plant_destroy(plant);
    }
}

static void what_is_singular_or_no_number_is_refused(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct kinematics k;
    struct dynamics d;
    struct leg_course course;
    double motion[MOTION_ORDERS][DOFS] = {{0}};
    kinematics_place(&k, &params);
    dynamics_init(&d, &params, &k);
    assert_true(dynamics_solve(&d, motion, &course));
    motion[MOTION_ACCEL][2] = (double)NAN;
    assert_false(dynamics_solve(&d, motion, &course));
    motion[MOTION_ACCEL][2] = 0.0;
    motion[MOTION_POSE][5] = 0.5 * PI; /* a symmetrical platform rotated by 90 degrees is
                                        * singular */
    assert_false(dynamics_solve(&d, motion, &course));
    motion[MOTION_POSE][5] = (double)INFINITY;
    assert_false(dynamics_solve(&d, motion, &course));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_are_those_of_the_lagrangian),
        cmocka_unit_test(both_engines_follow_the_forces),
        cmocka_unit_test(what_is_singular_or_no_number_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
