/* Kinematics: inverse against forward, Jacobian against differences, wrench against work, core
 * against the plant's own geometry. */
#include "support.h"

#include "engine.h"
#include "kinematics.h"
#include "plant.h"
#include "units.h"

enum { POSES = 20000 };

static const double neutral[DOFS] = {0};
/* Newton leaves at most its tolerance of 1e-13 m in the lengths, and J^-1 is below 5 wherever the
 * legs reach. */
static const double pose_tolerance = 1e-12;

static struct params defaults(void) {
    struct params params;
    config_default(&params);
    return params;
}

static struct kinematics rig(void) {
    struct params params = defaults();
    struct kinematics k;
    struct error error;
    assert_int_equal(kinematics_init(&k, &params, &error), STATUS_OK);
    return k;
}

static void random_pose(uint64_t *seed, double span_m, double span_rad, double pose[DOFS]) {
    for (int i = 0; i < DOFS; i++) pose[i] = random_unit(seed) * (i < DOF_PHI ? span_m : span_rad);
}

/* Runs Newton from `start` and checks the result; returns the iterations. */
static int recover(const struct kinematics *k, const double start[DOFS], const double pose[DOFS]) {
    double length[LEGS], found[DOFS], again[LEGS];
    ik_lengths(k, pose, length);
    memcpy(found, start, sizeof found);
    struct fk_result result = fk_solve(k, length, found);
    assert_true(result.converged);
    assert_below(distance(found, pose, DOFS), pose_tolerance);
    ik_lengths(k, found, again);
    /* the tolerance of Newton's iteration, plus rounding of 2 m */
    assert_below(distance(again, length, LEGS), 1e-13 + 1e-15);
    assert_below(result.residual_m, 1e-13 + 1e-15);
    return result.iterations;
}

static void fk_recovers_pose_from_ik_lengths_from_neutral(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    uint64_t seed = 1;
    int most = 0;
    for (int n = 0; n < POSES; n++) {
        double pose[DOFS];
        random_pose(&seed, 0.1, 0.2, pose);
        int iterations = recover(&k, neutral, pose);
        if (iterations > most) most = iterations;
    }
    print_message("# from neutral: at most %d iterations\n", most);
    assert_true(most < FK_ITERATIONS); /* convergence is quadratic, so at least one iteration is
                                        * left over */
}

static void fk_tracks_a_moving_platform_in_two_iterations(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    uint64_t seed = 2;
    int total = 0;
    for (int n = 0; n < POSES; n++) {
        double pose[DOFS], step[DOFS], next[DOFS];
        random_pose(&seed, 0.1, 0.2, pose);
        /* steps of one cycle of 2 ms at 0.1 m/s and 0.2 rad/s, the fastest motion of the tests */
        random_pose(&seed, 2e-4, 4e-4, step);
        for (int i = 0; i < DOFS; i++) next[i] = pose[i] + step[i];
        int iterations = recover(&k, pose, next);
        assert_true(iterations <= 3);
        total += iterations;
    }
    print_message("# tracking: %.3f iterations on average\n", (double)total / POSES);
    assert_below((double)total / POSES, 2.1);
}

static void fk_finds_every_pose_of_the_stroke_from_the_parked_one(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct kinematics k = rig();
    const double parked[DOFS] = {[DOF_Z] = params.motion.park_z_m};
    uint64_t seed = 3;
    int reached = 0, most = 0;
    recover(&k, parked, neutral);
    recover(&k, neutral, parked);
    while (reached < POSES) {
        double pose[DOFS], length[LEGS], half = params.actuator.stroke_m[0] / 2;
        bool inside = true;
        random_pose(&seed, 0.1, 0.2, pose);
        pose[DOF_Z] = 0.45 * random_unit(&seed);
        ik_lengths(&k, pose, length);
        for (int i = 0; i < LEGS; i++) inside = inside && fabs(length[i] - k.neutral_length_m[i]) <= half;
        if (!inside) continue;
        int iterations = recover(&k, parked, pose);
        if (iterations > most) most = iterations;
        reached++;
    }
    print_message("# from the parked pose: at most %d iterations\n", most);
}

/* Newton's method squares an error, to 2 e^2 / m, from 1 cm down to rounding; with a wrong Jacobian
 * the error would only shrink by a constant factor. */
static void fk_converges_quadratically_off_neutral(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    uint64_t seed = 4;
    for (int n = 0; n < 1000; n++) {
        double pose[DOFS], start[DOFS], offset[DOFS];
        random_pose(&seed, 0.1, 0.2, pose);
        random_pose(&seed, 1e-3, 1e-3, offset);
        for (int i = 0; i < DOFS; i++) start[i] = pose[i] + offset[i];
        assert_true(recover(&k, start, pose) <= 3); /* the errors are 1e-3, 1e-6 and 1e-12 */
    }
}

static void hostile_lengths_never_converge_and_leave_the_pose_alone(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 0.0, -1.831, 1e-300, 1e3, 1e300, -1e300};
    const double start[DOFS] = {0.01, -0.02, 0.03, 0.01, -0.01, 0.02};
    for (unsigned b = 0; b < sizeof bad / sizeof *bad; b++)
        for (int set = 1; set < 1 << LEGS; set++) {
            double length[LEGS], pose[DOFS];
            memcpy(pose, start, sizeof pose);
            /* the other lengths match the pose from which the search starts */
            ik_lengths(&k, start, length);
            for (int i = 0; i < LEGS; i++)
                if (set & 1 << i) length[i] = bad[b];
            struct fk_result result = fk_solve(&k, length, pose);
            if (result.converged) fail_msg("converged with %g in legs %#x", bad[b], (unsigned)set);
            assert_memory_equal(pose, start, sizeof pose);
            assert_true(result.iterations <= FK_ITERATIONS);
        }
}

static void unreachable_lengths_do_not_converge(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    double length[LEGS], pose[DOFS] = {0};
    for (int i = 0; i < LEGS; i++)
        length[i] = 0.6; /* too short: the joint circles are 0.64 m apart
                                                     * in plan */
    assert_false(fk_solve(&k, length, pose).converged);
    /* leg 3 ends beyond its upper joint's reach */
    for (int i = 0; i < LEGS; i++) length[i] = k.neutral_length_m[i] + (i == 2 ? 1.5 : 0.0);
    assert_false(fk_solve(&k, length, pose).converged);
    assert_memory_equal(pose, neutral, sizeof pose);
}

/* Rotates T(pose) by a small rotation vector about axes of {B} and returns angles as in types.h. */
static void turned(const double pose[DOFS], const double vector[3], double out[DOFS]) {
    double t[3][3], r[3][3], angle = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    double c = cos(angle), s = sin(angle), n[3] = {0};
    for (int i = 0; i < 3 && angle > 0.0; i++) n[i] = vector[i] / angle;
    const double skew[3][3] = {{0, -n[2], n[1]}, {n[2], 0, -n[0]}, {-n[1], n[0], 0}};
    rotation_from_angles(pose[3], pose[4], pose[5], t);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            r[i][j] = 0.0;
            /* Rodrigues' formula */
            for (int k = 0; k < 3; k++) r[i][j] += (c * (i == k) + s * skew[i][k] + (1.0 - c) * n[i] * n[k]) * t[k][j];
        }
    memcpy(out, pose, 3 * sizeof *out);
    out[3] = atan2(r[2][1], r[2][2]);
    out[4] = -asin(r[2][0]);
    out[5] = atan2(r[1][0], r[0][0]);
}

/* Computes the pose after the twist has acted for `time`. */
static void displaced(const double pose[DOFS], const double twist[DOFS], double time, double out[DOFS]) {
    double vector[3];
    for (int i = 0; i < 3; i++) vector[i] = time * twist[3 + i];
    turned(pose, vector, out);
    for (int i = 0; i < 3; i++) out[i] += time * twist[i];
}

/* Computes the legs' rates along a twist, by a fourth-order difference of the lengths. */
static void rates_by_difference(const struct kinematics *k, const double pose[DOFS], const double twist[DOFS], double rate[LEGS]) {
    const double h = 1e-3, at[4] = {-2 * h, -h, h, 2 * h}, weight[4] = {1, -8, 8, -1};
    memset(rate, 0, LEGS * sizeof *rate);
    for (int n = 0; n < 4; n++) {
        double moved[DOFS], length[LEGS];
        displaced(pose, twist, at[n], moved);
        ik_lengths(k, moved, length);
        for (int i = 0; i < LEGS; i++) rate[i] += weight[n] * length[i] / (12 * h);
    }
}

static void jacobian_is_the_derivative_of_the_lengths_along_a_twist(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    uint64_t seed = 5;
    for (int n = 0; n < 500; n++) {
        double pose[DOFS], j[LEGS][DOFS], rate[LEGS];
        random_pose(&seed, 0.1, 0.2, pose);
        ik_jacobian(&k, pose, j);
        for (int d = 0; d < DOFS; d++) {
            double twist[DOFS] = {0};
            twist[d] = 1.0;
            rates_by_difference(&k, pose, twist, rate);
            /* tolerance: h^4 / 30 times a fifth derivative near 1, and rounding of 2 m over h, are
             * 1e-12 each */
            for (int i = 0; i < LEGS; i++) assert_close(j[i][d], rate[i], 1e-11);
        }
    }
}

static void wrench_does_the_work_of_the_legs(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    uint64_t seed = 6;
    for (int n = 0; n < 500; n++) {
        double pose[DOFS], force[LEGS], twist[DOFS], wrench[DOFS], rate[LEGS], legs_w = 0.0, platform_w = 0.0;
        random_pose(&seed, 0.1, 0.2, pose);
        for (int i = 0; i < LEGS; i++) force[i] = 1e4 * random_unit(&seed);
        for (int i = 0; i < DOFS; i++) twist[i] = random_unit(&seed);
        wrench_from_forces(&k, pose, force, wrench);
        rates_by_difference(&k, pose, twist, rate);
        for (int i = 0; i < LEGS; i++) legs_w += force[i] * rate[i], platform_w += wrench[i] * twist[i];
        /* tolerance: six legs, forces up to 1e4 N, the differences' error, and a twist up to
         * sqrt(6) */
        assert_close(legs_w, platform_w, 6 * 1e4 * 1e-11 * 4);
    }
}

static void legs_are_1_8310_m_at_neutral(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    double length[LEGS];
    ik_lengths(&k, neutral, length);
    for (int i = 0; i < LEGS; i++) {
        assert_close(length[i], k.neutral_length_m[i], 1e-15 * 4);
        assert_close(length[i], 1.8310, 0.5e-4); /* the value that docs/method.md, section 1,
                                                  * prints */
    }
}

static void rotation_is_orthonormal_and_right_handed(void **unused) {
    (void)unused;
    uint64_t seed = 7;
    for (int n = 0; n < 1000; n++) {
        double t[3][3];
        rotation_from_angles(PI * random_unit(&seed), PI * random_unit(&seed), PI * random_unit(&seed), t);
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) assert_close(t[0][a] * t[0][b] + t[1][a] * t[1][b] + t[2][a] * t[2][b], a == b ? 1.0 : 0.0, 1e-15);
        double volume = 0.0;
        for (int i = 0; i < 3; i++) volume += t[0][i] * (t[1][(i + 1) % 3] * t[2][(i + 2) % 3] - t[1][(i + 2) % 3] * t[2][(i + 1) % 3]);
        assert_close(volume, 1.0, 2e-15);
    }
}

/* Positive angles rotate the platform as their names say, with x forward, y right and z down: roll
 * to the right, nose up, heading to the right. */
static void rotation_is_yaw_then_pitch_then_roll(void **unused) {
    (void)unused;
    double t[3][3];
    rotation_from_angles(PI / 2, 0, 0, t);
    assert_close(t[2][1], 1.0, 1e-15); /* the right side goes down */
    rotation_from_angles(0, PI / 2, 0, t);
    assert_close(t[2][0], -1.0, 1e-15); /* the nose goes up */
    rotation_from_angles(0, 0, PI / 2, t);
    assert_close(t[1][0], 1.0, 1e-15); /* the nose goes right */
    rotation_from_angles(PI / 2, 0, PI / 2, t);
    /* roll is about the platform's own axis, so heading does not change it */
    assert_close(t[2][1], 1.0, 1e-15);
}

/* After a rotation by 120 degrees about z, leg i+2 has the length that leg i had before. */
static void a_third_of_a_turn_permutes_the_legs(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    uint64_t seed = 8;
    double third = 2 * PI / 3, c = cos(third), s = sin(third);
    for (int n = 0; n < 1000; n++) {
        double pose[DOFS], other[DOFS], here[LEGS], there[LEGS], t[3][3], r[3][3], q[3][3];
        random_pose(&seed, 0.1, 0.2, pose);
        rotation_from_angles(pose[3], pose[4], pose[5], t);
        const double z[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) r[i][j] = z[i][0] * t[0][j] + z[i][1] * t[1][j] + z[i][2] * t[2][j];
        for (int i = 0; i < 3; i++)            /* Z T Z' */
            for (int j = 0; j < 3; j++) q[i][j] = r[i][0] * z[j][0] + r[i][1] * z[j][1] + r[i][2] * z[j][2];
        other[0] = c * pose[0] - s * pose[1], other[1] = s * pose[0] + c * pose[1], other[2] = pose[2];
        other[3] = atan2(q[2][1], q[2][2]), other[4] = -asin(q[2][0]), other[5] = atan2(q[1][0], q[0][0]);
        ik_lengths(&k, pose, here);
        ik_lengths(&k, other, there);
        for (int i = 0; i < LEGS; i++) assert_close(there[(i + 2) % LEGS], here[i], 1e-14);
    }
}

/* Mirrored left to right, legs 1 and 2, 3 and 6, 4 and 5 change places. */
static void a_mirror_swaps_left_and_right_legs(void **unused) {
    (void)unused;
    static const int partner[LEGS] = {1, 0, 5, 4, 3, 2};
    struct kinematics k = rig();
    uint64_t seed = 9;
    for (int n = 0; n < 1000; n++) {
        double pose[DOFS], here[LEGS], there[LEGS];
        random_pose(&seed, 0.1, 0.2, pose);
        ik_lengths(&k, pose, here);
        pose[DOF_Y] = -pose[DOF_Y], pose[DOF_PHI] = -pose[DOF_PHI], pose[DOF_PSI] = -pose[DOF_PSI];
        ik_lengths(&k, pose, there);
        for (int i = 0; i < LEGS; i++) assert_close(there[partner[i]], here[i], 1e-14);
    }
}

static void joints_are_where_the_plant_has_them(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct kinematics k = rig();
    struct sim_geometry g;
    sim_geometry_init(&g, &params);
    for (int i = 0; i < LEGS; i++) {
        assert_close(g.neutral_length_m[i], k.neutral_length_m[i], 1e-14);
        assert_below(distance(g.upper[i], k.upper[i], 3), 1e-14);
        assert_below(distance(g.lower[i], k.lower[i], 3), 1e-14);
    }
}

static void lengths_and_rates_agree_with_both_engines(void **unused) {
    (void)unused;
    struct kinematics k = rig();
    static const enum engine_kind engines[] = {ENGINE_ODE, ENGINE_CLOSED_FORM};
    for (int e = 0; e < 2; e++) {
        struct params params = defaults();
        struct error error;
        uint64_t seed = 10;
        params.sim.engine = engines[e];
        struct plant *plant = plant_create(&params, 1, &error);
        assert_non_null(plant);
        for (int n = 0; n < 300; n++) {
            static const double push[LEGS] = {4000, -3000, 2000, 3000, -1000, 2000};
            double pose[DOFS], found[DOFS] = {0}, length[LEGS], j[LEGS][DOFS];
            struct plant_truth truth;
            random_pose(&seed, 0.1, 0.2, pose);
            plant_place(plant, pose);
            plant_get_truth(plant, &truth);
            ik_lengths(&k, pose, length);
            assert_below(distance(truth.length_m, length, LEGS), 1e-12);
            assert_below(distance(truth.pose, pose, DOFS), 1e-12);
            assert_true(fk_solve(&k, truth.length_m, found).converged);
            assert_below(distance(found, pose, DOFS), 2e-12);
            plant_step_forced(plant, 1e-4, push);
            plant_get_truth(plant, &truth);
            ik_jacobian(&k, truth.pose, j);
            for (int i = 0; i < LEGS; i++) {
                double rate = 0.0;
                for (int d = 0; d < DOFS; d++) rate += j[i][d] * truth.twist[d];
                /* a fall with 10 g for 0.1 ms: the platform moves, but slowly */
                assert_below(fabs(truth.rate_mps[i]), 0.1);
                /* ODE's CFM lets a joint yield by 1e-10 m/s per newton; a few joints under a
                 * kilonewton give 1e-6 */
                assert_close(rate, truth.rate_mps[i], engines[e] == ENGINE_ODE ? 1e-5 : 1e-13);
            }
        }
        plant_destroy(plant);
    }
}

static void refused(struct params params, const char *key) {
    struct kinematics k;
    struct error error = {0};
    assert_int_equal(kinematics_init(&k, &params, &error), STATUS_USAGE);
    if (!strstr(error.text, key)) fail_msg("no %s in: %s", key, error.text);
}

/* Turned about by a mirror in its horizontal plane, a platform that stands is one that hangs: legs
 * are as long in the mirrored pose. */
static void a_platform_that_hangs_is_one_that_stands_in_a_mirror(void **unused) {
    (void)unused;
    static const double mirror[DOFS] = {1, 1, -1, -1, -1, 1};
    struct params params = defaults();
    struct kinematics stands, hangs;
    kinematics_place(&stands, &params);
    params.geometry.height_m = -params.geometry.height_m;
    params.payload.center_height_m = -params.payload.center_height_m;
    kinematics_place(&hangs, &params);
    uint64_t state = 3;
    for (int round = 0; round < 100; round++) {
        double pose[DOFS], mirrored[DOFS], length_m[LEGS], other_m[LEGS];
        random_pose(&state, 0.2, 0.3, pose);
        for (int i = 0; i < DOFS; i++) mirrored[i] = mirror[i] * pose[i];
        ik_lengths(&stands, pose, length_m);
        ik_lengths(&hangs, mirrored, other_m);
        for (int i = 0; i < LEGS; i++) assert_true(fabs(length_m[i] - other_m[i]) < 1e-14);
    }
}

static void geometry_that_cannot_exist_is_refused(void **unused) {
    (void)unused;
    struct params params = defaults();
    all_legs(params.actuator.stroke_m, 4.0); /* half of the stroke is longer than the leg */
    refused(params, "actuator.stroke_m");
    params = defaults();
    params.geometry.height_m = (double)NAN;
    refused(params, "geometry.height_m");
    params = defaults();
    params.geometry.lower_radius_m = (double)INFINITY;
    refused(params, "geometry.lower_radius_m");
    params = defaults();
    /* every leg lies in a plane through z, so yaw is free */
    params.geometry.upper_half_angle_rad = PI / 3 - params.geometry.lower_half_angle_rad;
    refused(params, "geometry.upper_half_angle_rad");
    params = defaults();
    params.geometry.upper_radius_m = 0.0; /* all legs meet in a point */
    refused(params, "geometry.upper_radius_m");
}

/* A first axis at 19 degrees from the leg is refused, one at 21 degrees is not. */
static void a_joints_first_axis_lies_across_its_leg(void **unused) {
    (void)unused;
    struct params params = defaults(), wrong;
    struct kinematics k;
    struct error error;
    set_joint_axes(&params);
    if (kinematics_init(&k, &params, &error)) fail_msg("%s", error.text);
    wrong = params;
    memset(wrong.geometry.upper_axis.leg[3], 0, sizeof wrong.geometry.upper_axis.leg[3]);
    refused(wrong, "geometry.upper_joint_axes: leg 4");
    refused(wrong, "no direction");
    memcpy(wrong.geometry.upper_axis.leg[3], (double[3]){0.0, 0.0, 1e-160}, sizeof wrong.geometry.upper_axis.leg[3]);
    refused(wrong, "geometry.upper_joint_axes: leg 4");
    refused(wrong, "no direction");
    for (int degrees = 19; degrees <= 21; degrees += 2) {
        double leg[3], across[3];
        wrong = params;
        for (int i = 0; i < 3; i++) leg[i] = (k.upper[1][i] - k.lower[1][i]) / k.neutral_length_m[1];
        double level = hypot(leg[0], leg[1]);
        across[0] = -leg[1] / level, across[1] = leg[0] / level, across[2] = 0.0;
        for (int i = 0; i < 3; i++)
            wrong.geometry.lower_axis.leg[1][i] = 30.0 * (sin(degrees * PI / 180.0) * across[i] - cos(degrees * PI / 180.0) * leg[i]);
        if (degrees == 19) {
            refused(wrong, "geometry.lower_joint_axes: leg 2");
            refused(wrong, "within 20 degrees");
        } else {
            assert_int_equal(kinematics_init(&k, &wrong, &error), STATUS_OK);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fk_recovers_pose_from_ik_lengths_from_neutral),
        cmocka_unit_test(fk_tracks_a_moving_platform_in_two_iterations),
        cmocka_unit_test(fk_finds_every_pose_of_the_stroke_from_the_parked_one),
        cmocka_unit_test(fk_converges_quadratically_off_neutral),
        cmocka_unit_test(hostile_lengths_never_converge_and_leave_the_pose_alone),
        cmocka_unit_test(unreachable_lengths_do_not_converge),
        cmocka_unit_test(jacobian_is_the_derivative_of_the_lengths_along_a_twist),
        cmocka_unit_test(wrench_does_the_work_of_the_legs),
        cmocka_unit_test(legs_are_1_8310_m_at_neutral),
        cmocka_unit_test(rotation_is_orthonormal_and_right_handed),
        cmocka_unit_test(rotation_is_yaw_then_pitch_then_roll),
        cmocka_unit_test(a_third_of_a_turn_permutes_the_legs),
        cmocka_unit_test(a_mirror_swaps_left_and_right_legs),
        cmocka_unit_test(joints_are_where_the_plant_has_them),
        cmocka_unit_test(lengths_and_rates_agree_with_both_engines),
        cmocka_unit_test(a_platform_that_hangs_is_one_that_stands_in_a_mirror),
        cmocka_unit_test(geometry_that_cannot_exist_is_refused),
        cmocka_unit_test(a_joints_first_axis_lies_across_its_leg),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
