/* The closed-form engine: its equations against Lagrange's, its integrator against its own refinement, its dry friction against Gauss'
 * principle and against what friction cannot do. */
#include "support.h"

#include "engine.h"
#include "joint_axes.h"
#include "plant.h"
#include "rigid.h"
#include "stick.h"
#include "units.h"
#include "vec.h"

static const double SUBSTEP_S = 2.5e-4;

static struct params defaults(void) {
    struct params params;
    config_default(&params);
    params.sim.engine = ENGINE_CLOSED_FORM;
    params.sensors.enabled = false;
    return params;
}

static void set_effect(struct params *params, const char *name, int key, double value) {
    int place = effect_find(name);
    assert_true(place >= 0);
    params->effects[place].on = true;
    for (int leg = 0; leg < LEGS; leg++) params->effects[place].value[key][leg] = value;
}

static struct plant *plant_at(const struct params *params, const double pose[DOFS]) {
    struct error error;
    struct plant *plant = plant_create(params, 1, &error);
    if (!plant) fail_msg("%s", error.text);
    plant_place(plant, pose);
    return plant;
}

static struct plant_truth truth_of(const struct plant *plant) {
    struct plant_truth truth;
    plant_get_truth(plant, &truth);
    return truth;
}

static void holding_forces(const struct params *params, const double pose[DOFS], double force_n[LEGS]) {
    struct rigid_model m;
    rigid_model_init(&m, params);
    assert_true(rigid_holding_forces(&m, pose, force_n));
}

/* --- rigid bodies: an arbitrary smooth motion, its velocity and acceleration exact --- */

struct motion {
    double amplitude[DOFS], phase[DOFS];
};

static struct motion random_motion(uint64_t *seed) {
    struct motion m;
    for (int i = 0; i < DOFS; i++) m.amplitude[i] = 0.15 * random_unit(seed), m.phase[i] = PI * random_unit(seed);
    return m;
}

/* derivative: 0 pose, 1 its rate, 2 its second rate; each coordinate with its own frequency. */
static void motion_at(const struct motion *m, double t, int derivative, double q[DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        double w = 2.0 + 0.7 * i;
        q[i] = m->amplitude[i] * pow(w, derivative) * sin(w * t + m->phase[i] + 0.5 * PI * derivative);
    }
}

/* twist = B(pose) rate: columns are the axes of psi (z), theta (y turned by psi), phi (x turned by both). */
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

/* dT/d(rate_i), exact: T is quadratic in the rates. */
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
    for (int i = 0; i < DOFS; i++) assert_below(distance(mass[i], expected[i], DOFS), 5.1e-4); /* three printed decimals */
}

static void mass_matrix_is_the_curvature_of_the_kinetic_energy(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct rigid_model m;
    uint64_t seed = 1;
    params.payload.inertia_xx_kg_m2 = 9.0; /* no symmetry to hide behind */
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

/* d/dt dT/dq' - dL/dq = B' F, with F = mass acceleration - load whatever the acceleration. */
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
            /* thousands of newtons; differences round at 1e-13 of them over 1e-4 s */
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
        assert_below(distance(pose, back, DOFS), 1e-13); /* theta up to 1.5: cos 0.07 */
    }
}

static void without_legs_and_forces_the_platform_falls_freely(void **unused) {
    (void)unused;
    struct params params = defaults();
    params.actuator.upper_mass_kg = params.actuator.lower_mass_kg = 0.0;
    params.actuator.upper_inertia_kg_m2 = params.actuator.lower_inertia_kg_m2 = 0.0;
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
        assert_below(distance(truth_of(plant).pose, pose, DOFS), 1e-12); /* unstable without friction, but slower than 1/s */
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
        for (int k = 0; k < LEGS; k++) valve[k] = -0.1 - 0.05 * cos(2.0 * k); /* one sign: no port reverses */
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
    assert_below(distance(coarse, fine, DOFS), 1e-7); /* at the default substep the error is nothing that a sensor sees */
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
            assert_close(change, dot6(axes.row[k], acceleration) + axes.bias[k], 1e-8); /* h^4 of motions up to 6 rad/s */
        }
    }
}

/* The rates about the two axes make up the leg's turning against base or platform, but for spin about the leg itself. */
static void joint_rates_add_up_to_the_relative_rotation(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct rigid_model m;
    uint64_t seed = 7;
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
            double n[3], across[3], first[3], second[3], rest[3], spin[3];
            for (int i = 0; i < 3; i++) {
                n[i] = legs.n[i][leg], across[i] = legs.across[i][leg] / legs.length[leg];
                first[i] = upper ? dot3(legs.rotation[i], m.upper_axis[leg]) : m.lower_axis[leg][i];
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

/* --- dry friction --- */

static void friction_at_rest_satisfies_gauss_principle(void **unused) {
    (void)unused;
    uint64_t seed = 8;
    int slipping = 0, holding = 0;
    for (int trial = 0; trial < 500; trial++) {
        struct stick_coordinate c[30] = {0};
        double x[DOFS];
        int count = 1 + random_below(&seed, 30); /* most sets depend on each other */
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

/* Ten seconds under a load on every leg; returns the largest change of a leg's length. */
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
    struct params params = defaults();
    set_effect(&params, "cylinder_coulomb_friction", 0, 300.0);
    set_effect(&params, "cylinder_coulomb_friction", 1, 100.0);
    assert_below(creep(&params, 295.0), 1e-12);  /* held exactly, not to the 1 um that is asked for */
    assert_below(creep(&params, -95.0), 1e-12);
}

static void joints_below_their_capacity_do_not_creep(void **unused) {
    (void)unused;
    struct params params = defaults();
    set_effect(&params, "passive_joint_friction", 0, 5.0);
    assert_below(creep(&params, 2.0), 1e-12);
    assert_below(0.01, creep(&params, 4.0)); /* 24 axes of 5 N m hold some 20 N at the platform */
}

/* All legs loaded alike at neutral: the platform can only rise or sink. Returns its acceleration, up. */
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
    double per_newton = LEGS * params.geometry.height_m / g.neutral_length_m / 272.392; /* mz of method.md */
    assert_below(fabs(rise(&params, 299.9)), 1e-12);
    assert_below(fabs(rise(&params, -99.9)), 1e-12);
    assert_close(rise(&params, 310.0), 10.0 * per_newton, 1e-4 * 10.0 * per_newton); /* the legs turn a little in 10 ms */
    assert_close(rise(&params, -110.0), -10.0 * per_newton, 1e-4 * 10.0 * per_newton);
}

/* Forces that make every leg reverse again and again, stepwise constant over 1 ms so that the substep does not matter. */
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
    /* path misses what a leg goes back within the substep of its reversal: 1 nm at 5 m/s^2, 50 times, times 60 N */
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
        /* Releases fall on a substep's start, with the forces; a stop is found to 1 nm/s, some hundred times. */
        assert_below(distance(coarse.pose, fine.pose, DOFS), 2e-8);
    }
}

/* All 24 axes reverse at one instant in a vertical motion: none of them may be left behind and lock the others. */
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
    struct params params = defaults();
    double hold[LEGS], start[LEGS];
    set_effect(&params, "cylinder_coulomb_friction", 0, 500.0);
    set_effect(&params, "cylinder_coulomb_friction", 1, 500.0);
    params.hydraulics.leakage_m3_per_s_pa = 0.0; /* pressures stay */
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
    assert_below(distance(rested.length_m, end.length_m, LEGS), 1e-14); /* the stop is found to 1 nm/s; none of that may be left */
    plant_destroy(plant);
}

/* One leg or its joints blocked, the others swinging freely: the constraint must hold through every velocity term. */
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
        assert_below(fabs(now.rate_mps[2]), 1e-9); /* what one RK4 step leaves, until the next */
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
        if (n) set_effect(&params, "passive_joint_friction", n - 1, n == 1 ? 5.0 : 20.0); /* dry, then viscous */
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
        cmocka_unit_test(friction_at_rest_satisfies_gauss_principle),
        cmocka_unit_test(held_basis_stops_dependent_rows_too),
        cmocka_unit_test(legs_below_their_capacity_do_not_creep),
        cmocka_unit_test(joints_below_their_capacity_do_not_creep),
        cmocka_unit_test(slip_starts_at_the_capacity_of_each_direction),
        cmocka_unit_test(dry_friction_takes_force_times_path),
        cmocka_unit_test(reversals_fall_where_they_must_whatever_the_substep),
        cmocka_unit_test(axes_that_stop_together_are_let_go_together),
        cmocka_unit_test(a_stuck_leg_carries_the_difference_of_pressure_and_load),
        cmocka_unit_test(legs_that_have_come_to_rest_stay_there),
        cmocka_unit_test(a_held_leg_keeps_its_length_while_the_others_move),
        cmocka_unit_test(held_joints_keep_their_leg_straight_while_it_moves),
        cmocka_unit_test(joint_friction_alone_slows_a_falling_platform),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
