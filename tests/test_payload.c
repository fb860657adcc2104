/* The payload's ten parameters from known matrices. */
#include "support.h"

#include "nominal.h"
#include "payload.h"
#include "rigid.h"

struct given {
    struct params params;
    struct kinematics kinematics;
    double entry[MATRIX_ENTRIES], covariance[MATRIX_ENTRIES][MATRIX_ENTRIES];
};

/* Makes the matrix of the configured legs and a body with these values; it is uncertain by one part
 * in a thousand. */
static void machine_with(struct given *g, const double value[PAYLOAD_VALUES]) {
    static const double neutral[DOFS] = {0};
    static const int inertia[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    double mt[DOFS][DOFS], mass = value[PAYLOAD_MASS];
    const double *c = value + PAYLOAD_CENTER;
    struct error error;
    memset(g, 0, sizeof *g);
    config_default(&g->params);
    g->params.model.tolerance.mass = 0.0;
    assert_int_equal(kinematics_init(&g->kinematics, &g->params, &error), 0);
    struct params legs = g->params;
    legs.payload.mass_kg = legs.payload.inertia_xx_kg_m2 = legs.payload.inertia_yy_kg_m2 = legs.payload.inertia_zz_kg_m2 = 0.0;
    nominal_matrix(&legs, &g->kinematics, neutral, mt);
    const double skew[3][3] = {{0, -c[2], c[1]}, {c[2], 0, -c[0]}, {-c[1], c[0], 0}};
    for (int i = 0; i < 3; i++) {
        mt[i][i] += mass;
        for (int j = 0; j < 3; j++) {
            mt[i][3 + j] -= mass * skew[i][j];
            mt[3 + i][3 + j] += value[PAYLOAD_INERTIA + inertia[i][j]];
            for (int k = 0; k < 3; k++) mt[3 + i][3 + j] -= mass * skew[i][k] * skew[k][j];
        }
    }
    for (int i = 0, n = 0; i < DOFS; i++)
        for (int j = i; j < DOFS; j++, n++) {
            g->entry[n] = mt[i][j];
            g->covariance[n][n] = 1e-6 * mt[i][i] * mt[j][j];
        }
}

static void a_body_off_the_centre_is_found_again(void **unused) {
    (void)unused;
    static const double body[PAYLOAD_VALUES] = {143, 0.02, -0.035, 0.05, 17, 12, 21, -1.5, 0.7, 2.1};
    struct given g;
    machine_with(&g, body);
    struct payload p = payload_find(&g.params, &g.kinematics, g.entry, g.covariance);
    assert_true(p.evaluated && p.possible);
    for (int i = 0; i < PAYLOAD_VALUES; i++) {
        assert_close(p.value[i], body[i], 1e-9 * (1.0 + fabs(body[i])));
        assert_true(p.nearest[i] == p.value[i] && p.std[i] > 0.0);
    }
    assert_below(p.misfit, 1e-6);
}

static void the_stated_deviations_are_those_of_the_errors(void **unused) {
    (void)unused;
    enum { TRIALS = 400 };
    static const double body[PAYLOAD_VALUES] = {143, 0.02, -0.035, 0.05, 17, 12, 21, -1.5, 0.7, 2.1};
    uint64_t seed = 3;
    double square[PAYLOAD_VALUES] = {0}, misfit = 0.0;
    for (int trial = 0; trial < TRIALS; trial++) {
        struct given g;
        machine_with(&g, body);
        for (int i = 0; i < MATRIX_ENTRIES; i++) g.entry[i] += sqrt(3.0 * g.covariance[i][i]) * random_unit(&seed);
        struct payload p = payload_find(&g.params, &g.kinematics, g.entry, g.covariance);
        for (int i = 0; i < PAYLOAD_VALUES; i++) square[i] += pow((p.value[i] - body[i]) / p.std[i], 2.0) / TRIALS;
        misfit += p.misfit * p.misfit / TRIALS;
    }
    for (int i = 0; i < PAYLOAD_VALUES; i++) assert_close(square[i], 1.0, 0.25);
    assert_close(misfit, 1.0, 0.15);
}

static void what_no_body_can_have_is_said_and_the_nearest_given(void **unused) {
    (void)unused;
    /* the inertia zz is above xx + yy */
    static const double impossible[PAYLOAD_VALUES] = {143, 0.0, 0.0, 0.0, 2, 2, 9, 0, 0, 0};
    struct given g;
    machine_with(&g, impossible);
    struct payload p = payload_find(&g.params, &g.kinematics, g.entry, g.covariance);
    const double *near = p.nearest + PAYLOAD_INERTIA;
    assert_true(p.evaluated && !p.possible);
    assert_close(p.value[PAYLOAD_INERTIA + 2], 9.0, 1e-6);
    assert_true(near[0] > 0.0 && near[0] + near[1] >= near[2] * (1.0 - 1e-9));
    assert_close(near[0] + near[1], near[2], 1e-3);  /* the nearest body is as flat as a body can
                                                      * be */
    assert_below(near[2], 9.0);
    assert_close(p.nearest[PAYLOAD_MASS], 143.0, 1.0);
}

static void a_mass_that_nothing_determines_is_no_result(void **unused) {
    (void)unused;
    static const double body[PAYLOAD_VALUES] = {143, 0.0, 0.0, 0.0, 17, 12, 21, 0, 0, 0};
    struct given g;
    machine_with(&g, body);
    for (int i = 0; i < MATRIX_ENTRIES; i++) g.covariance[i][i] *= 1e6;
    assert_false(payload_find(&g.params, &g.kinematics, g.entry, g.covariance).evaluated);
}

/* The matrix agrees with the simulation's bodies for a changed payload; {M} stays at the configured
 * centre. */
static void the_matrix_in_any_pose_is_that_of_the_simulated_bodies(void **unused) {
    (void)unused;
    static const char *const of_center[3] = {"x_m", "y_m", "z_m"};
    struct params params, real;
    struct kinematics k;
    struct error error;
    struct rigid_model m;
    uint64_t seed = 5;
    const double shift[3] = {0.03, -0.02, 0.05};
    struct payload p = {.value = {208.6, shift[0], shift[1], shift[2], 15.6, 16.6, 27.92, 0.9, -1.1, 0.4}};
    config_default(&params);
    assert_int_equal(kinematics_init(&k, &params, &error), 0);
    real = params;
    real.payload.mass_kg = 208.6;
    real.payload.inertia_xx_kg_m2 = 15.6, real.payload.inertia_yy_kg_m2 = 16.6, real.payload.inertia_zz_kg_m2 = 27.92;
    real.payload.inertia_xy_kg_m2 = 0.9, real.payload.inertia_xz_kg_m2 = -1.1, real.payload.inertia_yz_kg_m2 = 0.4;
    for (int i = 0; i < 3; i++) {
        assert_string_equal(effect_table[effect_find("payload_center_of_mass")]->keys[i].name, of_center[i]);
        set_effect(&real, "payload_center_of_mass", i, shift[i]);
    }
    rigid_model_init(&m, &real);
    for (int n = 0; n < 20; n++) {
        double pose[DOFS], mass[DOFS][DOFS], load[DOFS], mt[DOFS][DOFS];
        struct rigid_state s;
        struct rigid_legs legs;
        for (int i = 0; i < DOFS; i++) pose[i] = 0.15 * random_unit(&seed);
        rigid_rest(&s, pose);
        rigid_legs(&m, &s, &legs);
        rigid_dynamics(&m, &s, &legs, mass, load);
        payload_matrix(&p, &params, &k, pose, mt);
        for (int i = 0; i < DOFS; i++)
            for (int j = 0; j <= i; j++) {
                assert_close(mt[i][j], mass[i][j], 1e-12 * sqrt(mt[i][i] * mt[j][j]));
                assert_close(mt[i][j], mt[j][i], 1e-12 * sqrt(mt[i][i] * mt[j][j]));
            }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_body_off_the_centre_is_found_again),
                                       cmocka_unit_test(the_stated_deviations_are_those_of_the_errors),
                                       cmocka_unit_test(the_matrix_in_any_pose_is_that_of_the_simulated_bodies),
                                       cmocka_unit_test(what_no_body_can_have_is_said_and_the_nearest_given),
                                       cmocka_unit_test(a_mass_that_nothing_determines_is_no_result)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
