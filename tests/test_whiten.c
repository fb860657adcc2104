/* Residuals in units of the standard deviation of their noise. */
#include "support.h"

#include "inverse_dynamics.h"
#include "units.h"
#include "whiten.h"

enum { CYCLES = 10, SAMPLES = 125, UNSTEADY_LEG = 1, STEADY_LEG = 4 };
static const double PRESSURE_NOISE_PA = 1e4, LENGTH_M = 1.83;

/* Makes a test of six sinusoids with noise alone. */
static void make_test(struct residual_test *t) {
    static double cycle[PHASES * SPECTRUM_SIZE];
    *t = (struct residual_test){.legs = LEGS,
                                .pressures = true,
                                .chambers = true,
                                .harmonics = RESIDUAL_HARMONICS,
                                .measured = SAMPLES,
                                .fitted = SAMPLES,
                                .size = RESIDUAL_SIZE,
                                .phases = PHASES,
                                .cycle = cycle};
    for (int i = 0; i < PHASES; i++) spectrum_basis(2.0 * PI * i / PHASES, SPECTRUM_HARMONICS, cycle + i * SPECTRUM_SIZE);
    for (int a = 0; a < RESIDUAL_SIZE; a++)
        t->rate[a] = (a + 1) / 2 * 25.0, t->weight[a] = a ? 0.5 : 1.0, t->curve[a] = t->rate[a] * t->rate[a];
    t->spectrum = (struct spectrum){.omega = 25.0, .harmonics = SPECTRUM_HARMONICS, .cycles = CYCLES, .offsets = 1};
    for (int k = 0; k < LEGS; k++) {
        t->spectrum.mean[CHANNEL_LENGTH][k][0] = LENGTH_M, t->spectrum.mean[CHANNEL_LENGTH][k][1] = 4e-3;
        for (int ch = CHANNEL_P1; ch <= CHANNEL_P2; ch++) {
            t->spectrum.mean[ch][k][0] = 4e6, t->spectrum.mean[ch][k][1] = 1e5;
            t->spectrum.noise[ch][k] = PRESSURE_NOISE_PA;
            for (int a = 0; a < RESIDUAL_SIZE; a++)
                t->std[ch][k][a] = t->spectrum.std[ch][k][a] = PRESSURE_NOISE_PA * sqrt((a ? 2.0 : 1.0) / SAMPLES / CYCLES);
        }
    }
}

static double white_p2(const struct residual_test *t, int leg, double p2_pa) {
    struct params params;
    struct whitener w;
    residual_row row = {{{0}}};
    config_default(&params);
    whitener_init(&w, t, &params, 1e-3);
    row[leg][RESIDUAL_P2][0] = p2_pa;
    whiten(&w, row);
    return row[leg][RESIDUAL_P2][0];
}

/* The mean pressure of a chamber that slowly empties and fills behind a shut valve matches no
 * model's steady state. */
static void a_chamber_on_its_way_says_little(void **unused) {
    (void)unused;
    struct residual_test t;
    double scatter_pa = 2e6;
    make_test(&t);
    t.std[CHANNEL_P2][UNSTEADY_LEG][0] = t.spectrum.std[CHANNEL_P2][UNSTEADY_LEG][0] = scatter_pa / sqrt(CYCLES);
    /* the noise is 300 Pa and the model error 70 Pa, so 2 MPa are thousands of deviations */
    assert_true(fabs(white_p2(&t, STEADY_LEG, scatter_pa)) > 1000.0);
    /* the residual is one deviation of its own scatter */
    assert_close(fabs(white_p2(&t, UNSTEADY_LEG, scatter_pa)), 1.0, 0.01);
}

/* With few cycles, twice the expected spread of noise may be chance: a mean with twice the
 * deviation keeps at least half its weight. If it counted as drift, it would keep a fifth. */
static void cycles_of_noise_are_steady(void **unused) {
    (void)unused;
    struct residual_test t;
    double p2_pa = 1e4;
    make_test(&t);
    double steady = white_p2(&t, STEADY_LEG, p2_pa);
    t.std[CHANNEL_P2][UNSTEADY_LEG][0] *= 2.0, t.spectrum.std[CHANNEL_P2][UNSTEADY_LEG][0] *= 2.0;
    double weight = white_p2(&t, UNSTEADY_LEG, p2_pa) / steady;
    assert_true(weight > 0.5 && weight < 1.0);
}

/* The deviation of a force comes from white noise of both pressures, over the seventeen
 * coefficients of all that the samples contain, and from the leg's mass times the acceleration that
 * a wrong length implies. */
static void a_force_is_as_sure_as_its_pressures(void **unused) {
    (void)unused;
    struct residual_test t;
    struct params params;
    double std_n[LEGS], mass[LEGS][LEGS], length_m = 1e-6;
    config_default(&params);
    make_test(&t);
    struct cylinder_model cylinder;
    cylinder_model_init(&cylinder, &params);
    double pressures_n = hypot(cylinder.leg[0].a1_m2, cylinder.leg[0].a2_m2) * PRESSURE_NOISE_PA *
                         sqrt((double)RESIDUAL_SIZE / SAMPLES / CYCLES);
    params.sensors.enabled = false;
    whiten_force_std(&t, &params, std_n);
    for (int k = 0; k < LEGS; k++) assert_close(std_n[k], pressures_n, 1e-9 * pressures_n);

    mechanism_stewart.leg_mass(&params, mass);
    t.std[CHANNEL_LENGTH][STEADY_LEG][RESIDUAL_SIZE - 1] = length_m;
    double inertia_n = mass[STEADY_LEG][STEADY_LEG] * pow(RESIDUAL_HARMONICS * 25.0, 2.0) * length_m;
    whiten_force_std(&t, &params, std_n);
    assert_close(std_n[STEADY_LEG], sqrt(pressures_n * pressures_n + 0.5 * inertia_n * inertia_n), 1e-6);
}

/* Returns the sum of white squares of the residuals that an error of a leg's length causes in a
 * harmonic: the force lacks the mass times the acceleration, and the shut chambers are stiff. The
 * rodless side's is multiplied by `way`. */
static double white_square(const struct residual_test *t, double length_m, int a, double way) {
    struct params params;
    struct whitener w;
    struct cylinder_model m;
    residual_row row = {{{0}}};
    double mass[LEGS][LEGS], sum = 0.0;
    config_default(&params);
    memset(params.hydraulics.leakage_m3_per_s_pa, 0, sizeof params.hydraulics.leakage_m3_per_s_pa);
    cylinder_model_init(&m, &params);
    mechanism_stewart.leg_mass(&params, mass);
    const struct cylinder_leg *leg = &m.leg[STEADY_LEG];
    double one_m3 = leg->dead_volume_m3[PORT_A] + leg->a1_m2 * (LENGTH_M - leg->length_min_m);
    double other_m3 = leg->dead_volume_m3[PORT_B] + leg->a2_m2 * (leg->length_max_m - LENGTH_M);
    row[STEADY_LEG][RESIDUAL_FORCE][a] = mass[STEADY_LEG][STEADY_LEG] * t->curve[a] * length_m;
    row[STEADY_LEG][RESIDUAL_P1][a] = way * leg->bulk_modulus_pa * leg->a1_m2 / one_m3 * length_m;
    row[STEADY_LEG][RESIDUAL_P2][a] = -leg->bulk_modulus_pa * leg->a2_m2 / other_m3 * length_m;
    whitener_init(&w, t, &params, 1e-3);
    whiten(&w, row);
    for (int i = 0; i < RESIDUALS; i++) sum += row[STEADY_LEG][i][a] * row[STEADY_LEG][i][a];
    return sum;
}

/* An error of a length is one error, however many residuals show it. */
static void a_wrong_length_moves_three_residuals_together(void **unused) {
    (void)unused;
    struct residual_test t;
    double length_m = 10e-6;
    int a = 2 * 4; /* a cosine */
    make_test(&t);
    t.std[CHANNEL_LENGTH][STEADY_LEG][a] = length_m;
    assert_close(white_square(&t, length_m, a, 1.0), 1.0, 0.2);
    assert_true(white_square(&t, length_m, a, -1.0) > 100.0);
}

/* Behind an open valve a chamber's pressure lags, so that an error of a length's sine shows in the
 * cosine of the pressures, too. */
static void an_open_valve_turns_the_phase(void **unused) {
    (void)unused;
    struct residual_test t;
    double length_m = 10e-6, shut, open;
    int sine = 1, cosine = 2;
    make_test(&t);
    t.std[CHANNEL_LENGTH][STEADY_LEG][sine] = length_m;
    shut = white_square(&t, length_m, cosine, 1.0);
    t.spectrum.mean[CHANNEL_VALVE][STEADY_LEG][0] = 0.1;
    open = white_square(&t, length_m, cosine, 1.0);
    assert_true(open < 0.5 * shut);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_chamber_on_its_way_says_little),    cmocka_unit_test(cycles_of_noise_are_steady),
        cmocka_unit_test(a_force_is_as_sure_as_its_pressures), cmocka_unit_test(a_wrong_length_moves_three_residuals_together),
        cmocka_unit_test(an_open_valve_turns_the_phase),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
