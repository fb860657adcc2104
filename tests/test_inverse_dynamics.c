/* Friction of a leg that may stick: the part of the force balance that exceeds the noise is taken
 * for friction. */
#include "support.h"

#include <string.h>

#include "inverse_dynamics.h"

enum { DRAWS = 2000 };
static const double DRY_N = 100.0;

/* Makes an axis on a level rail. At rest, friction or noise accounts for every force. */
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

/* If the forces are only noise, a model with too much friction removes little of it. */
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
    assert_true(after > 0.8 * before); /* clipping at the friction's limits alone would leave 0.35
                                        * of `before` */
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

static void a_leg_that_slides_heeds_no_balance(void **unused) {
    (void)unused;
    struct params params;
    struct inverse_dynamics d;
    make_axis(&params, &d, DRY_N, 0.0);
    d.slides = true;
    assert_close(friction_of(&d, 0.4 * DRY_N), 0.0, 1e-9);
    double viscous = params.hydraulics.viscous_n_s_per_m[0] * 1e-3;
    assert_close(moving(&d, 1e-3, -2.0 * DRY_N), viscous + DRY_N, 1e-9);
}

/* The estimate is sliding friction plus the share F^2 / 3 / (F^2 / 3 + noise^2) of the balance
 * beyond it, within the friction's limit in that direction. */
static void a_balance_is_believed_as_far_as_it_is_sure(void **unused) {
    (void)unused;
    struct params params;
    struct inverse_dynamics d;
    /* with this noise the share is a quarter */
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
    d.force_std_n[0] = 0.75 * DRY_N; /* with this noise the mean force of both directions gives a
                                      * share of a quarter, counted from the middle */
    assert_close(friction_of(&d, 1.25 * DRY_N), 0.5 * DRY_N, 1e-9);
    coulomb->on = false;
    inverse_dynamics_init(&d, &params, 1e-3, 0.0);
    assert_close(friction_of(&d, DRY_N), 0.0, 1e-9);
}

/* Friction at rest can be any force within its limit, and is measured with noise: the estimate is
 * nearer to the truth than clipping at the limits. */
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

enum { INSTANTS = 128 };

/* Returns the mean deflection of seals, integrated in small steps, while a rod moves to and fro at
 * 1 Hz by 2 mm either way. */
static double seal_by_steps(double from_s, double until_s, double distance_m, double *deflection) {
    enum { STEPS = 2000 };
    double mean = 0.0, dt_s = (until_s - from_s) / STEPS;
    for (int i = 0; i < STEPS; i++) {
        double way_m = 2e-3 * (cos(2.0 * PI * (from_s + (i + 1) * dt_s)) - cos(2.0 * PI * (from_s + i * dt_s)));
        double to = way_m > 0.0 ? 1.0 : -1.0;
        mean += *deflection / STEPS;
        *deflection += (to - *deflection) * fabs(way_m) / distance_m;
    }
    return mean;
}

static void move_to_and_fro(struct inverse_dynamics_input in[INSTANTS]) {
    memset(in, 0, INSTANTS * sizeof *in);
    for (int i = 0; i < INSTANTS; i++) {
        double phase = 2.0 * PI * i / INSTANTS, w = 2.0 * PI;
        in[i].leg[0][1] = -2e-3 * w * sin(phase), in[i].leg[0][2] = -2e-3 * w * w * cos(phase);
    }
}

/* Returns the rms difference between the deflection and the one integrated in small steps, which
 * the force contains; a segment starts halfway. */
static double deflection_error(struct inverse_dynamics *d, bool cycle, double distance_m, double extend_n, double retract_n, double dry_n) {
    static struct inverse_dynamics_input in[INSTANTS];
    double deflection = cycle ? 0.0 : -0.5, square = 0.0, mean[INSTANTS];
    move_to_and_fro(in);
    for (int i = cycle ? -20 * INSTANTS : 0; i < INSTANTS; i++) {
        double here = seal_by_steps((i - 0.5) / INSTANTS, (i + 0.5) / INSTANTS, distance_m, &deflection);
        if (i < 0) continue;
        mean[i] = here;
        in[i].push_n[0] = (here > 0.0 ? extend_n : retract_n) * here + d->params->axis.mass_kg * in[i].leg[0][2];
        in[i].push_n[0] += d->params->hydraulics.viscous_n_s_per_m[0] * in[i].leg[0][1] + copysign(dry_n, in[i].leg[0][1]);
    }
    assert_true(inverse_dynamics_seals(d, INSTANTS, cycle, in));
    for (int i = 0; i < INSTANTS; i++) square += pow(in[i].deflection[0] - mean[i], 2.0) / INSTANTS;
    return sqrt(square);
}

/* Covers Dahl distances from a tenth of the travel between two instants up to the stroke, also with
 * a different force in each direction and beside friction that may hold the leg. The speed between
 * instants is taken as constant. */
static void seals_are_deflected_as_by_small_steps(void **unused) {
    (void)unused;
    numbers_case();
    struct params params;
    struct inverse_dynamics d;
    struct effect_values *dahl = &params.effects[effect_find("cylinder_dahl_friction")];
    for (int i = 0; i < 4; i++) {
        double extend_n = i % 2 ? 1.5 * DRY_N : DRY_N, retract_n = i % 2 ? 0.5 * DRY_N : DRY_N, dry_n = i / 2 ? DRY_N : 0.0;
        make_axis(&params, &d, dry_n, 0.0);
        dahl->on = true;
        for (double distance_m = dry_n > 0.0 ? 1e-4 : 1e-5; distance_m < 5e-3; distance_m *= 2.0) {
            dahl->value[0][0] = extend_n, dahl->value[1][0] = retract_n, dahl->value[2][0] = distance_m;
            inverse_dynamics_init(&d, &params, 1.0 / INSTANTS, 0.0);
            assert_below(deflection_error(&d, true, distance_m, extend_n, retract_n, dry_n), 0.01);
            assert_below(deflection_error(&d, false, distance_m, extend_n, retract_n, dry_n), 0.01);
        }
    }
}

static void noise_deflects_no_seals(void **unused) {
    (void)unused;
    static struct inverse_dynamics_input in[INSTANTS];
    struct params params;
    struct inverse_dynamics d;
    struct effect_values *dahl = &params.effects[effect_find("cylinder_dahl_friction")];
    uint64_t seed = 5;
    double square = 0.0;
    make_axis(&params, &d, 0.0, 0.0);
    dahl->on = true;
    dahl->value[0][0] = dahl->value[1][0] = DRY_N, dahl->value[2][0] = 1e-4;
    inverse_dynamics_init(&d, &params, 1.0 / INSTANTS, 0.0);
    d.force_std_n[0] = 10.0 * DRY_N;
    for (int i = 0; i < DRAWS; i++) {
        memset(in, 0, sizeof in);
        in[0].leg[0][0] = params.axis.middle_m, in[0].push_n[0] = d.force_std_n[0] * random_normal(&seed);
        assert_true(inverse_dynamics_seals(&d, 1, false, in));
        square += pow(in[0].deflection[0], 2.0) / DRAWS;
    }
    assert_below(square, 0.02); /* clipping at the limits alone would leave 0.9 */
}

/* The force of deflected seals depends on the deflection, not on the speed. */
static void deflected_seals_push_back(void **unused) {
    (void)unused;
    struct params params;
    struct inverse_dynamics d;
    struct inverse_dynamics_input in = {.deflection = {-0.5}};
    double force_n[LEGS];
    make_axis(&params, &d, 0.0, 0.0);
    struct effect_values *dahl = &params.effects[effect_find("cylinder_dahl_friction")];
    dahl->on = true;
    dahl->value[0][0] = DRY_N, dahl->value[1][0] = 3.0 * DRY_N, dahl->value[2][0] = 1e-4;
    inverse_dynamics_init(&d, &params, 1e-3, 0.0);
    in.leg[0][0] = d.params->axis.middle_m;
    assert_true(inverse_dynamics_step(&d, &in, force_n));
    assert_close(force_n[0], -1.5 * DRY_N, 1e-9);
    in.deflection[0] = 0.25, in.leg[0][1] = -0.1;
    assert_true(inverse_dynamics_step(&d, &in, force_n));
    assert_close(force_n[0], 0.25 * DRY_N - 0.1 * params.hydraulics.viscous_n_s_per_m[0], 1e-9);
}

/* A leg at rest is held or about to slide, each as likely; a leg above twice the slow speed slides.
 * */
static void only_a_slow_leg_has_uncertain_friction(void **unused) {
    (void)unused;
    struct params params;
    struct inverse_dynamics d;
    struct inverse_dynamics_input in = {0};
    make_axis(&params, &d, DRY_N, 5.0);
    assert_close(inverse_dynamics_held_variance(&d, 0, &in), 2.0 / 3.0 * DRY_N * DRY_N, 1e-9);
    in.leg[0][1] = -1.5 * INVERSE_DYNAMICS_SLOW_MPS;
    assert_close(inverse_dynamics_held_variance(&d, 0, &in), 0.25 * 2.0 / 3.0 * DRY_N * DRY_N, 1e-9);
    in.leg[0][1] = 2.0 * INVERSE_DYNAMICS_SLOW_MPS;
    assert_close(inverse_dynamics_held_variance(&d, 0, &in), 0.0, 1e-12);
    make_axis(&params, &d, 0.0, 5.0);
    in.leg[0][1] = 0.0;
    assert_close(inverse_dynamics_held_variance(&d, 0, &in), 0.0, 1e-12);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_is_no_friction),
        cmocka_unit_test(what_is_sure_is_held),
        cmocka_unit_test(a_leg_that_slides_heeds_no_balance),
        cmocka_unit_test(seals_are_deflected_as_by_small_steps),
        cmocka_unit_test(noise_deflects_no_seals),
        cmocka_unit_test(deflected_seals_push_back),
        cmocka_unit_test(a_balance_is_believed_as_far_as_it_is_sure),
        cmocka_unit_test(friction_is_found_through_noise),
        cmocka_unit_test(only_a_slow_leg_has_uncertain_friction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
