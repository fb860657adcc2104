/* The nominal inertia matrix agrees with the paper, with the kinetic energy of the thirteen bodies,
 * and with its limits. */
#include "support.h"

#include "lin.h"
#include "nominal.h"
#include "units.h"

struct machine {
    struct params params;
    struct kinematics kinematics;
};

static struct machine machine_default(void) {
    struct machine m;
    struct error error;
    config_default(&m.params);
    assert_int_equal(kinematics_init(&m.kinematics, &m.params, &error), 0);
    return m;
}

static void random_pose(uint64_t *state, double pose[DOFS]) {
    for (int i = 0; i < DOFS; i++) pose[i] = 0.2 * random_unit(state);
}

static const double neutral[DOFS] = {0};

static void neutral_matrix_is_that_of_the_papers_tables(void **unused) {
    (void)unused;
    /* docs/method.md, section 3: Tables 1 and 2 inserted into (A1)-(A6) by another program, to
     * three decimals */
    const double expected[DOFS][DOFS] = {{272.009, 0, 0, 0, 14.915, 0}, {0, 272.009, 0, -14.915, 0, 0}, {0, 0, 272.392, 0, 0, 0},
                                         {0, -14.915, 0, 30.688, 0, 0}, {14.915, 0, 0, 0, 30.688, 0},   {0, 0, 0, 0, 0, 53.221}};
    struct machine m = machine_default();
    double mt[DOFS][DOFS];
    nominal_matrix(&m.params, &m.kinematics, neutral, mt);
    assert_below(distance(&mt[0][0], &expected[0][0], DOFS * DOFS), 0.0005001);
}

static void a_payload_3_mm_higher_gives_the_papers_printed_matrix(void **unused) {
    (void)unused;
    struct machine m = machine_default();
    /* the h that the paper prints is rounded (docs/method.md, section 3) */
    m.params.payload.center_height_m = 0.1632;
    struct error error;
    assert_int_equal(kinematics_init(&m.kinematics, &m.params, &error), 0);
    double mt[DOFS][DOFS], nominal;
    nominal_matrix(&m.params, &m.kinematics, neutral, mt);
    FILE *table = fopen("tests/data/table3_linear_friction.csv", "r");
    assert_non_null(table);
    int row, column, rows = 0;
    assert_int_equal(fscanf(table, "%*[^\n]"), 0);
    while (fscanf(table, " %*[^,],%d,%d,%*f,%*f,%*f,%*f,%lf,%*[^\n]", &row, &column, &nominal) == 3) {
        /* tolerance: the paper's Izz, which is independent of h, is off by 0.11 % */
        assert_below(fabs(mt[row - 1][column - 1] / nominal - 1), 1.2e-3);
        rows++;
    }
    fclose(table);
    assert_int_equal(rows, 10);
}

/* Computes a leg's length and direction from the geometry alone. */
static void leg_at(const struct kinematics *k, int leg, const double pose[DOFS], double *length_m, double n[3]) {
    double t[3][3], square = 0;
    rotation_from_angles(pose[3], pose[4], pose[5], t);
    for (int r = 0; r < 3; r++) {
        const double *a = k->upper[leg];
        n[r] = pose[r] + t[r][0] * a[0] + t[r][1] * a[1] + t[r][2] * a[2] - k->lower[leg][r];
        square += n[r] * n[r];
    }
    *length_m = sqrt(square);
    for (int r = 0; r < 3; r++) n[r] /= *length_m;
}

/* Returns the kinetic energy by differences of positions: payload m v^2/2 + w' I w / 2, leg ma
 * Ldot^2/2 + g(L) Omega^2/2. */
static double kinetic_energy(const struct machine *m, const double pose[DOFS], const double rate[DOFS]) {
    const double step = 1e-5;
    const struct payload_params *p = &m->params.payload;
    const struct actuator_params *a = &m->params.actuator;
    double before[DOFS], after[DOFS], t0[3][3], t1[3][3], t[3][3], spin[3][3], energy = 0;
    for (int i = 0; i < DOFS; i++) before[i] = pose[i] - step * rate[i], after[i] = pose[i] + step * rate[i];
    for (int r = 0; r < 3; r++) energy += p->mass_kg * rate[r] * rate[r] / 2;
    rotation_from_angles(before[3], before[4], before[5], t0);
    rotation_from_angles(after[3], after[4], after[5], t1);
    rotation_from_angles(pose[3], pose[4], pose[5], t);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            spin[r][c] = 0; /* T' Tdot: body rates as a skew matrix */
            for (int i = 0; i < 3; i++) spin[r][c] += t[i][r] * (t1[i][c] - t0[i][c]) / (2 * step);
        }
    double wx = spin[2][1], wy = spin[0][2], wz = spin[1][0];
    energy += (p->inertia_xx_kg_m2 * wx * wx + p->inertia_yy_kg_m2 * wy * wy + p->inertia_zz_kg_m2 * wz * wz) / 2;
    energy += p->inertia_xy_kg_m2 * wx * wy + p->inertia_xz_kg_m2 * wx * wz + p->inertia_yz_kg_m2 * wy * wz;
    for (int leg = 0; leg < LEGS; leg++) {
        double l0, l1, l, n0[3], n1[3], n[3], omega_square = 0;
        leg_at(&m->kinematics, leg, before, &l0, n0);
        leg_at(&m->kinematics, leg, after, &l1, n1);
        leg_at(&m->kinematics, leg, pose, &l, n);
        for (int r = 0; r < 3; r++) omega_square += pow((n1[r] - n0[r]) / (2 * step), 2);
        double g = a->upper_mass_kg[leg] * pow(l - a->upper_center_m[leg], 2) + a->lower_mass_kg[leg] * pow(a->lower_center_m[leg], 2) +
                   a->upper_inertia_kg_m2[leg] + a->lower_inertia_kg_m2[leg];
        energy += a->upper_mass_kg[leg] * pow((l1 - l0) / (2 * step), 2) / 2 + g * omega_square / 2;
    }
    return energy;
}

/* Computes the twist, velocity and angular velocity in {B}, from pose rates: omega = T P(b)
 * bdot. */
static void twist_from_rate(const double pose[DOFS], const double rate[DOFS], double twist[DOFS]) {
    double t[3][3], sp = sin(pose[3]), cp = cos(pose[3]), st = sin(pose[4]), ct = cos(pose[4]);
    const double body[3] = {rate[3] - st * rate[5], cp * rate[4] + ct * sp * rate[5], -sp * rate[4] + ct * cp * rate[5]};
    rotation_from_angles(pose[3], pose[4], pose[5], t);
    for (int r = 0; r < 3; r++) {
        twist[r] = rate[r];
        twist[3 + r] = t[r][0] * body[0] + t[r][1] * body[1] + t[r][2] * body[2];
    }
}

/* Returns an asymmetric machine, because symmetry could hide errors: joints near their circles, an
 * off-centre payload, six different legs. */
static struct machine machine_at_random(uint64_t *state) {
    struct machine m = machine_default();
    struct error error;
    struct geometry_params *g = &m.params.geometry;
    struct payload_params *p = &m.params.payload;
    struct actuator_params *a = &m.params.actuator;
    g->upper.given = g->lower.given = true;
    p->inertia_xy_kg_m2 = 1.0, p->inertia_xz_kg_m2 = -1.5, p->inertia_yz_kg_m2 = 0.7;
    for (int leg = 0; leg < LEGS; leg++) {
        double *of[] = {a->upper_mass_kg,       a->lower_mass_kg,  a->upper_inertia_kg_m2,
                        a->lower_inertia_kg_m2, a->upper_center_m, a->lower_center_m};
        for (int i = 0; i < 6; i++) of[i][leg] *= 1.0 + 0.3 * random_unit(state);
        for (int r = 0; r < 3; r++) {
            g->upper.leg[leg][r] = m.kinematics.upper[leg][r] - (r == 2 ? p->center_height_m : 0.0) + 0.05 * random_unit(state);
            g->lower.leg[leg][r] = m.kinematics.lower[leg][r] - (r == 2 ? p->center_height_m + g->height_m : 0.0) +
                                   0.05 * random_unit(state);
        }
    }
    p->center_x_m = 0.1 * random_unit(state), p->center_y_m = 0.1 * random_unit(state);
    assert_int_equal(kinematics_init(&m.kinematics, &m.params, &error), 0);
    return m;
}

static void matrix_gives_the_kinetic_energy_of_all_bodies_in_any_pose(void **unused) {
    (void)unused;
    uint64_t state = 1;
    for (int run = 0; run < 100; run++) {
        struct machine m = run < 50 ? machine_default() : machine_at_random(&state);
        double pose[DOFS], rate[DOFS], twist[DOFS], mt[DOFS][DOFS], energy = 0;
        random_pose(&state, pose);
        for (int i = 0; i < DOFS; i++) rate[i] = random_unit(&state);
        twist_from_rate(pose, rate, twist);
        nominal_matrix(&m.params, &m.kinematics, pose, mt);
        for (int r = 0; r < DOFS; r++)
            for (int c = 0; c < DOFS; c++) energy += twist[r] * mt[r][c] * twist[c] / 2;
        /* tolerance: central differences over 1e-5 s have a truncation of 1e-10 and a rounding of
         * 1e-11 */
        assert_below(fabs(energy / kinetic_energy(&m, pose, rate) - 1), 1e-8);
    }
}

static void matrix_is_symmetric_and_positive_definite_in_any_pose(void **unused) {
    (void)unused;
    struct machine m = machine_default();
    uint64_t state = 2;
    for (int run = 0; run < 1000; run++) {
        double pose[DOFS], mt[DOFS][DOFS], eigenvalues[DOFS];
        random_pose(&state, pose);
        nominal_matrix(&m.params, &m.kinematics, pose, mt);
        for (int r = 0; r < DOFS; r++)
            for (int c = 0; c < r; c++) assert_close(mt[r][c], mt[c][r], 1e-12);
        assert_int_equal(lin_eigenvalues(DOFS, &mt[0][0], eigenvalues), 0);
        assert_true(eigenvalues[0] > 0);
    }
}

static void without_legs_the_payload_alone_is_left(void **unused) {
    (void)unused;
    struct machine m = machine_default();
    struct actuator_params *a = &m.params.actuator;
    all_legs(a->upper_mass_kg, 0.0), all_legs(a->lower_mass_kg, 0.0);
    all_legs(a->upper_inertia_kg_m2, 0.0), all_legs(a->lower_inertia_kg_m2, 0.0);
    const double pose[DOFS] = {0.1, -0.2, 0.05, 0.2, -0.1, 0.3};
    double mt[DOFS][DOFS], t[3][3];
    const double inertia[3] = {m.params.payload.inertia_xx_kg_m2, m.params.payload.inertia_yy_kg_m2, m.params.payload.inertia_zz_kg_m2};
    rotation_from_angles(pose[3], pose[4], pose[5], t);
    nominal_matrix(&m.params, &m.kinematics, pose, mt);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            double rotated = 0;
            for (int i = 0; i < 3; i++) rotated += t[r][i] * inertia[i] * t[c][i];
            assert_true(mt[r][c] == (r == c ? m.params.payload.mass_kg : 0) && mt[r][3 + c] == 0 && mt[3 + r][c] == 0);
            assert_close(mt[3 + r][3 + c], rotated, 1e-13);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(neutral_matrix_is_that_of_the_papers_tables),
        cmocka_unit_test(a_payload_3_mm_higher_gives_the_papers_printed_matrix),
        cmocka_unit_test(matrix_gives_the_kinetic_energy_of_all_bodies_in_any_pose),
        cmocka_unit_test(matrix_is_symmetric_and_positive_definite_in_any_pose),
        cmocka_unit_test(without_legs_the_payload_alone_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
