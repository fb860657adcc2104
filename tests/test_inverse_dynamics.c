/* Friction of a leg that may be held: what the balance of its forces asks for is believed as far as
 * that is more than noise. */
#include "support.h"

#include "inverse_dynamics.h"

enum { DRAWS = 2000 };
static const double DRY_N = 100.0;

/* An axis at rest on a level way: all that moves it is taken by friction, or is noise. */
static void make_axis(struct params *params, struct inverse_dynamics *d, double dry_n, double noise_n) {
    config_default(params);
    params->mechanism = MECHANISM_AXIS;
    params->axis.gravity_mps2 = 0.0;
    struct effect_values *coulomb = &params->effects[effect_find("cylinder_coulomb_friction")];
    coulomb->on = true;
    for (int k = 0; k < LEGS; k++) coulomb->value[0][k] = coulomb->value[1][k] = dry_n;
    inverse_dynamics_init(d, params, 1e-3, 0.0);
    d->force_std_n[0] = noise_n;
}

static double moving(struct inverse_dynamics *d, double speed_mps, double push_n) {
    struct inverse_dynamics_input in = {.push_n = {push_n}};
    double force_n[LEGS];
    in.leg[0][0] = d->params->axis.middle_m;
    in.leg[0][1] = speed_mps;
    assert_true(inverse_dynamics_step(d, &in, force_n));
    return force_n[0];
}

static double friction_of(struct inverse_dynamics *d, double push_n) { return moving(d, 0.0, push_n); }

/* Friction that a model has too much of takes away little of what is only noise. */
static void noise_is_no_friction(void **unused) {
    (void)unused;
    struct params params;
    struct inverse_dynamics d;
    uint64_t seed = 3;
    double noise_n = 2.0 * DRY_N, before = 0.0, after = 0.0;
    make_axis(&params, &d, DRY_N, noise_n);
    for (int i = 0; i < DRAWS; i++) {
        double push_n = noise_n * random_normal(&seed), left_n = push_n - friction_of(&d, push_n);
        before += push_n * push_n, after += left_n * left_n;
    }
    assert_true(after > 0.8 * before); /* limits alone leave 0.35 */
}

static void what_is_sure_is_held(void **unused) {
    (void)unused;
    struct params params;
    struct inverse_dynamics d;
    make_axis(&params, &d, DRY_N, 0.0);
    assert_close(friction_of(&d, 0.4 * DRY_N), 0.4 * DRY_N, 1e-9);
    assert_true(friction_of(&d, 10.0 * DRY_N) < 1.2 * DRY_N && friction_of(&d, 10.0 * DRY_N) > 1.1 * DRY_N);
    make_axis(&params, &d, DRY_N, 0.05 * DRY_N);
    assert_close(friction_of(&d, -0.4 * DRY_N), -0.4 * DRY_N, 0.01 * DRY_N);
}

/* Of a balance beyond sliding a share of F^2 / 3 over that and the noise's square, as far as
 * friction reaches in that direction. */
static void a_balance_is_believed_as_far_as_it_is_sure(void **unused) {
    (void)unused;
    struct params params;
    struct inverse_dynamics d;
    /* a quarter */
    make_axis(&params, &d, DRY_N, DRY_N);
    assert_close(friction_of(&d, 2.0 * DRY_N), 0.5 * DRY_N, 1e-9);
    double viscous = params.hydraulics.viscous_n_s_per_m[0] * 1e-3;
    assert_close(moving(&d, 1e-3, viscous), viscous + 0.75 * DRY_N, 1e-9);
    assert_close(moving(&d, -1e-3, -viscous), -viscous - 0.75 * DRY_N, 1e-9);

    make_axis(&params, &d, DRY_N, 1e6 * DRY_N);
    assert_close(moving(&d, 1e-3, -2.0 * DRY_N), viscous + DRY_N, 1e-6);
    assert_close(moving(&d, -1e-3, 2.0 * DRY_N), -viscous - DRY_N, 1e-6);

    make_axis(&params, &d, DRY_N, 0.0);
    struct effect_values *coulomb = &params.effects[effect_find("cylinder_coulomb_friction")];
    coulomb->value[1][0] = 0.5 * DRY_N;
    inverse_dynamics_init(&d, &params, 1e-3, 0.0);
    assert_close(friction_of(&d, 5.0 * DRY_N), 2.0 * -friction_of(&d, -5.0 * DRY_N), 1e-9);
    d.force_std_n[0] = 0.75 * DRY_N; /* as their mean: from the middle on, a quarter */
    assert_close(friction_of(&d, 1.25 * DRY_N), 0.5 * DRY_N, 1e-9);
    coulomb->on = false;
    inverse_dynamics_init(&d, &params, 1e-3, 0.0);
    assert_close(friction_of(&d, DRY_N), 0.0, 1e-9);
}

/* Held by anything within its reach, seen with noise: nearer to the truth than by limits alone. */
static void friction_is_found_through_noise(void **unused) {
    (void)unused;
    struct params params;
    struct inverse_dynamics sure, d;
    uint64_t seed = 4;
    for (double noise_n = 0.3 * DRY_N; noise_n < 4.0 * DRY_N; noise_n *= 2.0) {
        double error = 0.0, limits = 0.0;
        make_axis(&params, &sure, DRY_N, 0.0);
        make_axis(&params, &d, DRY_N, noise_n);
        for (int i = 0; i < DRAWS; i++) {
            double held_n = DRY_N * random_unit(&seed), push_n = held_n + noise_n * random_normal(&seed);
            error += pow(friction_of(&d, push_n) - held_n, 2.0), limits += pow(friction_of(&sure, push_n) - held_n, 2.0);
        }
        assert_true(error < limits);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_is_no_friction),
        cmocka_unit_test(what_is_sure_is_held),
        cmocka_unit_test(a_balance_is_believed_as_far_as_it_is_sure),
        cmocka_unit_test(friction_is_found_through_noise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
