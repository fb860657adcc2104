/* The closed-form engine: its equations against Lagrange's, its integrator against its own
 * refinement, its joints against geometry. */
#include "closed_form_rig.h"

#include "joint_axes.h"
#include "vec.h"

/* --- rigid bodies: an arbitrary smooth motion, its velocity and acceleration exact --- */

struct motion {
    double amplitude[DOFS], phase[DOFS];
};

static struct motion random_motion(uint64_t *seed) {
    struct motion m;
    for (int i = 0; i < DOFS; i++) m.amplitude[i] = 0.15 * random_unit(seed), m.phase[i] = PI * random_unit(seed);
    return m;
}

/* Computes the motion. derivative: 0 pose, 1 its rate, 2 its second rate. Each coordinate has its
 * own frequency. */
static void motion_at(const struct motion *m, double t, int derivative, double q[DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        double w = 2.0 + 0.7 * i;
        q[i] = m->amplitude[i] * pow(w, derivative) * sin(w * t + m->phase[i] + 0.5 * PI * derivative);
    }
}

/* Computes the columns of B in twist = B(pose) rate: the axes of psi (z), theta (y rotated by psi),
 * phi (x rotated by both). */
static void twist_columns(const double pose[DOFS], double b[DOFS][DOFS]) {
    double cy = cos(pose[4]), sy = sin(pose[4]), cz = cos(pose[5]), sz = sin(pose[5]);
    memset(b, 0, DOFS * sizeof b[0]);
    for (int i = 0; i < 3; i++) b[i][i] = 1.0;
    b[3][3] = cz * cy, b[4][3] = sz * cy, b[5][3] = -sy;
    b[3][4] = -sz, b[4][4] = cz;
    b[5][5] = 1.0;
}

static void apply(double b[DOFS][DOFS], const double x[DOFS], double y[DOFS]) {
    for (int i = 0; i < DOFS; i++) y[i] = dot6(b[i], x);
}

static struct rigid_state state_from(const double pose[DOFS], const double rate[DOFS]) {
    struct rigid_state s;
    double b[DOFS][DOFS];
    rigid_rest(&s, pose);
    twist_columns(pose, b);
    apply(b, rate, s.twist);
    return s;
}

static struct rigid_state state_at(const struct motion *m, double t) {
    double pose[DOFS], rate[DOFS];
    motion_at(m, t, 0, pose);
    motion_at(m, t, 1, rate);
    return state_from(pose, rate);
}

static void twist_rate_at(const struct motion *m, double t, double acceleration[DOFS]) {
    const double h = 1e-4;
    struct rigid_state a = state_at(m, t - 2 * h), b = state_at(m, t - h), c = state_at(m, t + h), d = state_at(m, t + 2 * h);
    for (int i = 0; i < DOFS; i++) acceleration[i] = (a.twist[i] - 8 * b.twist[i] + 8 * c.twist[i] - d.twist[i]) / (12 * h);
}

static double kinetic(const struct rigid_model *m, const double pose[DOFS], const double rate[DOFS]) {
    struct rigid_state s = state_from(pose, rate);
    double t, v;
    rigid_energy(m, &s, &t, &v);
    return t;
}

static double lagrangian(const struct rigid_model *m, const double pose[DOFS], const double rate[DOFS]) {
    struct rigid_state s = state_from(pose, rate);
    double t, v;
    rigid_energy(m, &s, &t, &v);
    return t - v;
}

/* Returns dT/d(rate_i). The difference is exact, because T is quadratic in the rates. */
static double momentum(const struct rigid_model *m, const double pose[DOFS], const double rate[DOFS], int i) {
    double up[DOFS], down[DOFS];
    memcpy(up, rate, sizeof up);
    memcpy(down, rate, sizeof down);
    up[i] += 1.0, down[i] -= 1.0;
    return 0.5 * (kinetic(m, pose, up) - kinetic(m, pose, down));
}

static double momentum_at(const struct rigid_model *m, const struct motion *motion, double t, int i) {
    double pose[DOFS], rate[DOFS];
    motion_at(motion, t, 0, pose);
    motion_at(motion, t, 1, rate);
    return momentum(m, pose, rate, i);
}

static double gradient(const struct rigid_model *m, const double pose[DOFS], const double rate[DOFS], int i) {
    const double h = 1e-3;
    double value[4], at[4] = {-2 * h, -h, h, 2 * h};
    for (int n = 0; n < 4; n++) {
        double moved[DOFS];
        memcpy(moved, pose, sizeof moved);
        moved[i] += at[n];
        value[n] = lagrangian(m, moved, rate);
    }
    return (value[0] - 8 * value[1] + 8 * value[2] - value[3]) / (12 * h);
}

static void full_mass(const struct rigid_model *m, const struct rigid_state *s, double mass[DOFS][DOFS], double load[DOFS]) {
    struct rigid_legs legs;
    rigid_legs(m, s, &legs);
    rigid_dynamics(m, s, &legs, mass, load);
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < i; j++) mass[j][i] = mass[i][j];
}

static void mass_matrix_at_neutral_is_that_of_the_method(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct rigid_model m;
    struct rigid_state s;
    double mass[DOFS][DOFS], load[DOFS];
    const double expected[DOFS][DOFS] = {
        {272.009, 0, 0, 0, 14.915, 0}, {0, 272.009, 0, -14.915, 0, 0}, {0, 0, 272.392, 0, 0, 0},
        {0, -14.915, 0, 30.688, 0, 0}, {14.915, 0, 0, 0, 30.688, 0},   {0, 0, 0, 0, 0, 53.221},
    };
    rigid_model_init(&m, &params);
    rigid_rest(&s, (const double[DOFS]){0});
    full_mass(&m, &s, mass, load);
    /* three printed decimals */
    for (int i = 0; i < DOFS; i++) assert_below(distance(mass[i], expected[i], DOFS), 5.1e-4);
}

static void mass_matrix_is_the_curvature_of_the_kinetic_energy(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct rigid_model m;
    uint64_t seed = 1;
    params.payload.inertia_xx_kg_m2 = 9.0; /* breaks the symmetry, which could hide errors */
    rigid_model_init(&m, &params);
    for (int n = 0; n < 200; n++) {
        double mass[DOFS][DOFS], load[DOFS], potential, energy;
        struct motion motion = random_motion(&seed);
        struct rigid_state s = state_at(&motion, 0.0);
        full_mass(&m, &s, mass, load);
        for (int i = 0; i < DOFS; i++) s.twist[i] = random_unit(&seed);
        double twice = 0.0;
        for (int i = 0; i < DOFS; i++) twice += s.twist[i] * dot6(mass[i], s.twist);
        rigid_energy(&m, &s, &energy, &potential);
        assert_close(0.5 * twice / energy, 1.0, 1e-13);
    }
}

/* d/dt dT/dq' - dL/dq = B' F, with F = mass acceleration - load, for any acceleration. */
static void equations_of_motion_are_lagranges(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct rigid_model m;
    uint64_t seed = 2;
    params.payload.inertia_xx_kg_m2 = 9.0;
    rigid_model_init(&m, &params);
    for (int n = 0; n < 100; n++) {
        const double t = 0.3, h = 1e-4;
        struct motion motion = random_motion(&seed);
        struct rigid_state s = state_at(&motion, t);
        double mass[DOFS][DOFS], load[DOFS], acceleration[DOFS], wrench[DOFS], pose[DOFS], rate[DOFS], b[DOFS][DOFS];
        full_mass(&m, &s, mass, load);
        twist_rate_at(&motion, t, acceleration);
        apply(mass, acceleration, wrench);
        add6(-1.0, load, wrench);
        motion_at(&motion, t, 0, pose);
        motion_at(&motion, t, 1, rate);
        twist_columns(pose, b);
        for (int i = 0; i < DOFS; i++) {
            double force = 0.0, change = momentum_at(&m, &motion, t - 2 * h, i) - 8 * momentum_at(&m, &motion, t - h, i) +
                                         8 * momentum_at(&m, &motion, t + h, i) - momentum_at(&m, &motion, t + 2 * h, i);
            for (int j = 0; j < DOFS; j++) force += b[j][i] * wrench[j];
            /* tolerance: forces are thousands of newtons, and rounding by 1e-13 is divided by 1e-4
             * s */
            assert_close(change / (12 * h) - gradient(&m, pose, rate, i), force, 1e-6);
        }
    }
}

static void pose_survives_the_quaternion(void **unused) {
    (void)unused;
    uint64_t seed = 3;
    for (int n = 0; n < 1000; n++) {
        double pose[DOFS], back[DOFS];
        struct rigid_state s;
        for (int i = 0; i < DOFS; i++) pose[i] = 1.5 * random_unit(&seed);
        rigid_rest(&s, pose);
        rigid_pose(&s, back);
        assert_below(distance(pose, back, DOFS), 1e-13); /* tolerance: theta goes up to 1.5, where
                                                          * its cosine is 0.07 */
    }
}

static void without_legs_and_forces_the_platform_falls_freely(void **unused) {
    (void)unused;
    struct params params = defaults();
    all_legs(params.actuator.upper_mass_kg, 0.0), all_legs(params.actuator.lower_mass_kg, 0.0);
    all_legs(params.actuator.upper_inertia_kg_m2, 0.0), all_legs(params.actuator.lower_inertia_kg_m2, 0.0);
    struct plant *plant = plant_at(&params, (const double[DOFS]){0.01, 0.02, -0.1, 0.05, -0.03, 0.1});
    double z = truth_of(plant).pose[DOF_Z];
    for (int i = 0; i < 800; i++) plant_step_forced(plant, SUBSTEP_S, (const double[LEGS]){0});
    struct plant_truth end = truth_of(plant);
    assert_close(end.pose[DOF_Z] - z, 0.5 * params.payload.gravity_mps2 * 0.2 * 0.2, 1e-13);
    const double rest[3] = {0.05, -0.03, 0.1};
    assert_below(distance(end.pose + 3, rest, 3), 1e-14);
    plant_destroy(plant);
}

static void without_gravity_nothing_moves_by_itself(void **unused) {
    (void)unused;
    struct params params = defaults();
    const double pose[DOFS] = {0.05, -0.03, -0.1, 0.1, -0.08, 0.2};
    params.payload.gravity_mps2 = 0.0;
    struct plant *plant = plant_at(&params, pose);
    for (int i = 0; i < 4000; i++) plant_step_forced(plant, SUBSTEP_S, (const double[LEGS]){0});
    struct plant_truth end = truth_of(plant);
    assert_below(distance(end.pose, pose, DOFS), 1e-14);
    assert_true(end.kinetic_j == 0.0);
    plant_destroy(plant);
}

static void holding_forces_hold(void **unused) {
    (void)unused;
    struct params params = defaults();
    uint64_t seed = 4;
    for (int n = 0; n < 10; n++) {
        double pose[DOFS], force[LEGS];
        for (int i = 0; i < DOFS; i++) pose[i] = 0.15 * random_unit(&seed);
        struct plant *plant = plant_at(&params, pose);
        holding_forces(&params, pose, force);
        for (int i = 0; i < 400; i++) plant_step_forced(plant, SUBSTEP_S, force);
        /* the equilibrium is unstable without friction, but an error grows more slowly than e^t */
        assert_below(distance(truth_of(plant).pose, pose, DOFS), 1e-12);
        plant_destroy(plant);
    }
}

/* --- the integrator --- */

static void constant_forces_do_as_much_work_as_the_energy_grows(void **unused) {
    (void)unused;
    struct params params = defaults();
    uint64_t seed = 5;
    for (int n = 0; n < 5; n++) {
        double force[LEGS], work = 0.0;
        holding_forces(&params, (const double[DOFS]){0}, force);
        for (int k = 0; k < LEGS; k++) force[k] += 150.0 * random_unit(&seed);
        struct plant *plant = plant_at(&params, (const double[DOFS]){0});
        struct plant_truth start = truth_of(plant);
        for (int i = 0; i < 1600; i++) plant_step_forced(plant, SUBSTEP_S, force);
        struct plant_truth end = truth_of(plant);
        for (int k = 0; k < LEGS; k++) work += force[k] * (end.length_m[k] - start.length_m[k]);
        double gain = end.kinetic_j - start.kinetic_j + end.potential_j - start.potential_j;
        assert_true(end.kinetic_j > 0.5);
        assert_close(gain, work, 1e-8 * (end.kinetic_j + fabs(work)));
        plant_destroy(plant);
    }
}

static void run_forced(double dt, double pose[DOFS]) {
    struct params params = defaults();
    double force[LEGS];
    holding_forces(&params, (const double[DOFS]){0}, force);
    for (int k = 0; k < LEGS; k++) force[k] += 900.0 * cos(2.0 * k);
    struct plant *plant = plant_at(&params, (const double[DOFS]){0});
    for (int i = 0; i < (int)round(0.32 / dt); i++) plant_step_forced(plant, dt, force);
    memcpy(pose, truth_of(plant).pose, DOFS * sizeof *pose);
    plant_destroy(plant);
}

static void run_hydraulic(int substeps, double pose[DOFS]) {
    struct params params = defaults();
    params.sim.substeps = substeps;
    struct plant *plant = plant_at(&params, (const double[DOFS]){0});
    for (int i = 0; i < 160; i++) {
        double valve[LEGS];
        /* equal signs, so no port reverses */
        for (int k = 0; k < LEGS; k++) valve[k] = -0.1 - 0.05 * cos(2.0 * k);
        plant_step(plant, valve);
    }
    memcpy(pose, truth_of(plant).pose, DOFS * sizeof *pose);
    plant_destroy(plant);
}

static double order_of(const double coarse[DOFS], const double middle[DOFS], const double fine[DOFS]) {
    return log2(distance(coarse, middle, DOFS) / distance(middle, fine, DOFS));
}

static void rigid_bodies_converge_with_fourth_order(void **unused) {
    (void)unused;
    double coarse[DOFS], middle[DOFS], fine[DOFS];
    run_forced(1.6e-2, coarse);
    run_forced(8e-3, middle);
    run_forced(4e-3, fine);
    assert_close(order_of(coarse, middle, fine), 4.0, 0.3);
}

static void bodies_and_hydraulics_together_converge_with_fourth_order(void **unused) {
    (void)unused;
    double coarse[DOFS], middle[DOFS], fine[DOFS];
    run_hydraulic(8, coarse);
    run_hydraulic(16, middle);
    run_hydraulic(32, fine);
    /* at the default substep the error is below any sensor's resolution */
    assert_below(distance(coarse, fine, DOFS), 1e-7);
    assert_close(order_of(coarse, middle, fine), 4.0, 0.5);
}

/* --- universal joints --- */

static void joint_axes_at(const struct rigid_model *m, const struct motion *motion, double t, struct joint_axes *axes,
                          double rate[JOINT_AXES], struct rigid_legs *legs) {
    struct rigid_state s = state_at(motion, t);
    rigid_legs(m, &s, legs);
    joint_axes(m, &s, legs, axes);
    for (int k = 0; k < JOINT_AXES; k++) rate[k] = dot6(axes->row[k], s.twist);
}

static void joint_rates_change_as_row_and_bias_say(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct rigid_model m;
    uint64_t seed = 6;
    set_joint_axes(&params);
    rigid_model_init(&m, &params);
    for (int n = 0; n < 100; n++) {
        const double t = 0.2, h = 1e-3;
        struct motion motion = random_motion(&seed);
        struct rigid_legs legs;
        struct joint_axes axes, other;
        double rate[5][JOINT_AXES], acceleration[DOFS];
        for (int i = 0; i < 5; i++) joint_axes_at(&m, &motion, t + (i - 2) * h, i == 2 ? &axes : &other, rate[i], &legs);
        twist_rate_at(&motion, t, acceleration);
        for (int k = 0; k < JOINT_AXES; k++) {
            double change = (rate[0][k] - 8 * rate[1][k] + 8 * rate[3][k] - rate[4][k]) / (12 * h);
            /* tolerance: differences have errors of h^4, at motions up to 6 rad/s */
            assert_close(change, dot6(axes.row[k], acceleration) + axes.bias[k], 1e-8);
        }
    }
}

/* Except for the spin about the leg itself, the rates about the two axes add up to the leg's
 * rotation relative to base or platform. */
static void joint_rates_add_up_to_the_relative_rotation(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct rigid_model m;
    uint64_t seed = 7;
    set_joint_axes(&params);
    rigid_model_init(&m, &params);
    for (int trial = 0; trial < 100; trial++) {
        struct motion motion = random_motion(&seed);
        struct rigid_state s = state_at(&motion, 0.1);
        struct rigid_legs legs;
        struct joint_axes axes;
        double rate[JOINT_AXES];
        joint_axes_at(&m, &motion, 0.1, &axes, rate, &legs);
        for (int end = 0; end < JOINT_AXES / 2; end++) {
            int leg = end / 2, upper = end % 2;
            const double *axis = upper ? params.geometry.upper_axis.leg[leg] : params.geometry.lower_axis.leg[leg];
            double n[3], across[3], first[3], second[3], rest[3], spin[3], length = sqrt(dot3(axis, axis));
            for (int i = 0; i < 3; i++) {
                n[i] = legs.n[i][leg], across[i] = legs.across[i][leg] / legs.length[leg];
                first[i] = (upper ? dot3(legs.rotation[i], axis) : axis[i]) / length;
            }
            cross3(first, n, second);
            double scale = 1.0 / sqrt(dot3(second, second));
            cross3(n, across, rest);
            for (int i = 0; i < 3; i++)
                rest[i] -= (upper ? s.twist[3 + i] : 0.0) + rate[2 * end] * first[i] + rate[2 * end + 1] * scale * second[i];
            cross3(rest, n, spin);
            assert_below(sqrt(dot3(spin, spin)), 1e-13);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mass_matrix_at_neutral_is_that_of_the_method),
        cmocka_unit_test(mass_matrix_is_the_curvature_of_the_kinetic_energy),
        cmocka_unit_test(equations_of_motion_are_lagranges),
        cmocka_unit_test(pose_survives_the_quaternion),
        cmocka_unit_test(without_legs_and_forces_the_platform_falls_freely),
        cmocka_unit_test(without_gravity_nothing_moves_by_itself),
        cmocka_unit_test(holding_forces_hold),
        cmocka_unit_test(constant_forces_do_as_much_work_as_the_energy_grows),
        cmocka_unit_test(rigid_bodies_converge_with_fourth_order),
        cmocka_unit_test(bodies_and_hydraulics_together_converge_with_fourth_order),
        cmocka_unit_test(joint_rates_change_as_row_and_bias_say),
        cmocka_unit_test(joint_rates_add_up_to_the_relative_rotation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
