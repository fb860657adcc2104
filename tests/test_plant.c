/* The simulated machine as a whole: start, placing, valves, sensors, seeds, and commands that no
 * controller should send. */
#include "support.h"

#include "cylinder.h"
#include "plant.h"
#include "units.h"

static const double VACUUM_PA = -101325.0;

static struct params defaults(void) {
    struct params params;
    config_default(&params);
    params.sim.engine = ENGINE_CLOSED_FORM;
    params.sensors.enabled = false;
    return params;
}

static struct plant *create(const struct params *params, uint64_t seed) {
    struct error error;
    struct plant *plant = plant_create(params, seed, &error);
    if (!plant) fail_msg("%s", error.text);
    return plant;
}

static struct plant_truth truth_of(const struct plant *plant) {
    struct plant_truth truth;
    plant_get_truth(plant, &truth);
    return truth;
}

static void starts_at_rest_on_the_lower_stops_without_a_jump(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct cylinder_model m;
    cylinder_model_init(&m, &params);
    struct plant *plant = create(&params, 1);
    struct plant_truth start = truth_of(plant);
    for (int k = 0; k < LEGS; k++) {
        assert_true(start.length_m[k] < m.leg[k].length_min_m);
        assert_close(start.length_m[k], m.leg[k].length_min_m, 1e-4);
        assert_true(start.p1_pa[k] == params.hydraulics.tank_pa && start.p2_pa[k] == params.hydraulics.tank_pa);
        assert_true(start.friction_n[k] > 0.0); /* friction_n includes the end stop's force */
    }
    for (int i = 0; i < 500; i++) plant_step(plant, (const double[LEGS]){0});
    struct plant_truth end = truth_of(plant);
    assert_below(distance(start.pose, end.pose, DOFS), 1e-12);
    assert_below(distance(start.p1_pa, end.p1_pa, LEGS), 0.1); /* tolerance: pressures are millions
                                                                * of Pa */
    assert_close(end.time_s, 1.0, 1e-12);
    plant_destroy(plant);
}

static void another_machine_settles_as_well(void **unused) {
    (void)unused;
    struct params params = defaults();
    params.geometry.upper_half_angle_rad = 0.5; /* another geometry, because nothing may be tuned to
                                                 * the first */
    all_legs(params.actuator.stroke_m, 0.5);
    params.hydraulics.tank_pa = 1e5;
    struct plant *plant = create(&params, 1);
    struct plant_truth start = truth_of(plant);
    for (int i = 0; i < 100; i++) plant_step(plant, (const double[LEGS]){0});
    assert_below(distance(start.pose, truth_of(plant).pose, DOFS), 1e-12);
    plant_destroy(plant);
}

static void an_impossible_machine_is_refused_by_name(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct error error = {0};
    all_legs(params.actuator.stroke_m, 3.2); /* the shortest leg is 0.23 m, but its joints are 1.8 m
                                              * apart */
    assert_null(plant_create(&params, 1, &error));
    assert_int_equal(error.status, STATUS_USAGE);
    assert_non_null(strstr(error.text, "actuator.stroke_m"));
    params = defaults();
    params.hydraulics.tank_pa = 1e6; /* this tank pressure lifts the platform without any command */
    assert_null(plant_create(&params, 1, &error));
    assert_non_null(strstr(error.text, "hydraulics.tank_pa"));
}

static void placed_it_rests_on_its_pressures(void **unused) {
    (void)unused;
    struct params params = defaults();
    uint64_t seed = 1;
    memset(params.hydraulics.leakage_m3_per_s_pa, 0, sizeof params.hydraulics.leakage_m3_per_s_pa);
    struct plant *plant = create(&params, 1);
    for (int n = 0; n < 20; n++) {
        double pose[DOFS];
        for (int i = 0; i < DOFS; i++) pose[i] = 0.1 * random_unit(&seed);
        plant_place(plant, pose);
        struct plant_truth start = truth_of(plant);
        for (int k = 0; k < LEGS; k++) {
            assert_true(start.p2_pa[k] >= params.hydraulics.tank_pa && start.p2_pa[k] <= params.hydraulics.supply_pa);
            assert_true(start.p1_pa[k] >= params.hydraulics.tank_pa && start.p1_pa[k] <= params.hydraulics.supply_pa);
            assert_true(start.spool[k] == 0.0);
        }
        for (int i = 0; i < 500; i++) plant_step(plant, (const double[LEGS]){0});
        struct plant_truth end = truth_of(plant);
        assert_below(distance(pose, end.pose, DOFS), 1e-11);
        assert_below(end.kinetic_j, 1e-18);
    }
    plant_destroy(plant);
}

static void light_loads_get_half_the_supply_in_the_rodless_side(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct plant *plant = create(&params, 1);
    plant_place(plant, (const double[DOFS]){0});
    struct plant_truth truth = truth_of(plant);
    for (int k = 0; k < LEGS; k++) assert_close(truth.p1_pa[k], 0.5 * params.hydraulics.supply_pa, 1e-6);
    plant_destroy(plant);
}

static void positive_valves_extend_and_raise(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct plant *plant = create(&params, 1);
    plant_place(plant, (const double[DOFS]){0});
    struct plant_truth start = truth_of(plant);
    for (int i = 0; i < 100; i++) plant_step(plant, (const double[LEGS]){0.3, 0.3, 0.3, 0.3, 0.3, 0.3});
    struct plant_truth up = truth_of(plant);
    assert_below(up.pose[DOF_Z], start.pose[DOF_Z] - 0.01); /* z is down */
    for (int k = 0; k < LEGS; k++) assert_below(start.length_m[k] + 0.01, up.length_m[k]);
    for (int i = 0; i < 300; i++) plant_step(plant, (const double[LEGS]){-0.3, -0.3, -0.3, -0.3, -0.3, -0.3});
    assert_below(up.pose[DOF_Z] + 0.01, truth_of(plant).pose[DOF_Z]);
    plant_destroy(plant);
}

/* At steady rest the valve replaces the leakage: P1 = Ps - P2 (equal ports), and A1 P1 - A2 P2 is
 * the load (docs/method.md, section 5: -0.075). */
static void at_rest_the_valve_feeds_the_leakage(void **unused) {
    (void)unused;
    struct params params = defaults();
    const struct hydraulics_params *h = &params.hydraulics;
    double integral[LEGS] = {0}, valve[LEGS];
    struct plant *plant = create(&params, 1);
    plant_place(plant, (const double[DOFS]){0});
    struct plant_truth goal = truth_of(plant), now = goal;
    for (int i = 0; i < 5000; i++) {
        for (int k = 0; k < LEGS; k++) {
            integral[k] += 100.0 * params.loop.period_s * (goal.length_m[k] - now.length_m[k]);
            valve[k] = integral[k] + 20.0 * (goal.length_m[k] - now.length_m[k]);
        }
        plant_step(plant, valve);
        now = truth_of(plant);
    }
    struct cylinder_model m;
    cylinder_model_init(&m, &params);
    for (int k = 0; k < LEGS; k++) {
        double p1 = (goal.hydraulic_n[k] + m.leg[k].a2_m2 * h->supply_pa) / (m.leg[k].a1_m2 + m.leg[k].a2_m2), p2 = h->supply_pa - p1;
        double spool = -h->leakage_m3_per_s_pa[k] * (p2 - p1) / (h->valve_flow_m3_per_s[k] * sqrt(p1 / h->valve_drop_pa));
        assert_close(now.length_m[k], goal.length_m[k], 1e-6);
        assert_close(now.p1_pa[k], p1, 1e-4 * p1);
        assert_close(now.spool[k], spool, 1e-4 * fabs(spool));
        assert_close(now.spool[k], -0.075, 1e-3);
    }
    plant_destroy(plant);
}

/* Random full-scale commands, some of them NaN or infinite, for 40 s: everything stays finite,
 * within the stops and above vacuum. */
static void hostile_commands_break_nothing(void **unused) {
    (void)unused;
    slow_case();
    struct params params = defaults();
    struct cylinder_model m;
    uint64_t seed = 2;
    int place = effect_find("cylinder_coulomb_friction");
    cylinder_model_init(&m, &params);
    for (int friction = 0; friction < 2; friction++) {
        params.effects[place].on = friction;
        for (int leg = 0; leg < LEGS; leg++) params.effects[place].value[0][leg] = params.effects[place].value[1][leg] = 200.0;
        struct plant *plant = create(&params, 1);
        const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1e300, -1.0, 1.0};
        double valve[LEGS] = {0};
        for (int i = 0; i < 20000; i++) {
            if (i % 50 == 0)
                for (int k = 0; k < LEGS; k++) valve[k] = bad[random_below(&seed, 6)];
            plant_step(plant, valve);
            struct plant_truth now = truth_of(plant);
            for (int k = 0; k < LEGS; k++) {
                /* tolerance: 272 kg at 2 m/s compress one stop of 2e7 N/m by 7 mm */
                assert_true(now.length_m[k] > m.leg[k].length_min_m - 0.01 && now.length_m[k] < m.leg[k].length_max_m + 0.01);
                assert_true(now.p1_pa[k] >= VACUUM_PA && now.p2_pa[k] >= VACUUM_PA);
                assert_true(now.p1_pa[k] < 1e8 && now.p2_pa[k] < 1e8);
                assert_true(fabs(now.spool[k]) <= 1.0);
            }
            for (int j = 0; j < DOFS; j++) assert_true(isfinite(now.pose[j]) && isfinite(now.twist[j]));
        }
        plant_destroy(plant);
    }
}

static void a_nan_command_centres_the_valve(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct plant *a = create(&params, 1), *b = create(&params, 1);
    plant_place(a, (const double[DOFS]){0});
    plant_place(b, (const double[DOFS]){0});
    const double bad[LEGS] = {(double)NAN, 0.1, 2.0, -(double)NAN, -7.0, 0.0}, good[LEGS] = {0.0, 0.1, 1.0, 0.0, -1.0, 0.0};
    for (int i = 0; i < 20; i++) plant_step(a, bad), plant_step(b, good);
    struct plant_truth ta = truth_of(a), tb = truth_of(b);
    assert_memory_equal(&ta.pose, &tb.pose, sizeof ta.pose);
    plant_destroy(a);
    plant_destroy(b);
}

/* Runs a noisy feedback loop: the sensors affect the motion, so every bit depends on the seed. */
static struct plant_truth noisy_run(uint64_t seed, struct hal_sample *last) {
    struct params params = defaults();
    params.sensors.enabled = true;
    struct plant *plant = create(&params, seed);
    plant_place(plant, (const double[DOFS]){0});
    for (int i = 0; i < 200; i++) {
        double valve[LEGS];
        plant_measure(plant, last);
        for (int k = 0; k < LEGS; k++) valve[k] = 20.0 * (1.831 - last->length_m[k]) + 1e-8 * (last->p2_pa[k] - last->p1_pa[k]);
        plant_step(plant, valve);
    }
    struct plant_truth truth = truth_of(plant);
    plant_destroy(plant);
    return truth;
}

static void the_same_seed_gives_the_same_bits_and_another_does_not(void **unused) {
    (void)unused;
    struct hal_sample s1 = {0}, s2 = {0}, s3 = {0};
    struct plant_truth a = noisy_run(7, &s1), b = noisy_run(7, &s2), c = noisy_run(8, &s3);
    assert_memory_equal(&a.pose, &b.pose, sizeof a.pose);
    assert_memory_equal(&s1, &s2, sizeof s1);
    assert_memory_not_equal(&a.pose, &c.pose, sizeof a.pose);
}

static void disabled_sensors_tell_the_truth(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct hal_sample sample;
    struct plant *plant = create(&params, 1);
    plant_place(plant, (const double[DOFS]){0.01, 0.02, 0.03, 0.04, 0.05, 0.06});
    plant_measure(plant, &sample);
    struct plant_truth truth = truth_of(plant);
    assert_memory_equal(sample.length_m, truth.length_m, sizeof truth.length_m);
    assert_memory_equal(sample.p1_pa, truth.p1_pa, sizeof truth.p1_pa);
    assert_memory_equal(sample.p2_pa, truth.p2_pa, sizeof truth.p2_pa);
    plant_destroy(plant);
}

static void lengths_come_in_steps_of_the_encoder(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct hal_sample sample;
    uint64_t seed = 3;
    params.sensors.enabled = true;
    struct plant *plant = create(&params, 1);
    for (int n = 0; n < 200; n++) {
        double pose[DOFS];
        for (int i = 0; i < DOFS; i++) pose[i] = 0.1 * random_unit(&seed);
        plant_place(plant, pose);
        plant_measure(plant, &sample);
        struct plant_truth truth = truth_of(plant);
        for (int k = 0; k < LEGS; k++) {
            double steps = sample.length_m[k] / params.sensors.position_resolution_m;
            assert_close(steps, round(steps), 1e-9);
            assert_close(sample.length_m[k], truth.length_m[k], 0.5 * params.sensors.position_resolution_m + 1e-12);
        }
    }
    plant_destroy(plant);
}

/* The noise is 25 mV peak to peak at 16 MPa per 10 V, before 12 bits over +-10 V: uniform noise of
 * 40 kPa, steps of 7.8 kPa. */
static void pressures_have_the_noise_and_the_codes_of_the_rig(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct hal_sample sample;
    params.sensors.enabled = true;
    const double code = 32e6 / 4096, noise = 25e-3 * 1.6e6;
    struct plant *plant = create(&params, 1);
    plant_place(plant, (const double[DOFS]){0});
    double truth = truth_of(plant).p1_pa[0], sum = 0.0, square = 0.0, last = 0.0, product = 0.0;
    const int count = 20000;
    for (int n = 0; n < count; n++) {
        plant_measure(plant, &sample);
        double error = sample.p1_pa[0] - truth;
        assert_close(sample.p1_pa[0] / code, round(sample.p1_pa[0] / code), 1e-9);
        assert_below(fabs(error), 0.5 * noise + 0.5 * code + 1e-6);
        sum += error, square += error * error, product += error * last;
        last = error;
    }
    /* exact moments: each code has the probability of the noise that rounds to it */
    double mean = 0.0, variance = 0.0;
    for (double c = floor((truth - noise) / code); c * code < truth + noise; c++) {
        double share = fmax(0.0, fmin((c + 0.5) * code, truth + noise / 2) - fmax((c - 0.5) * code, truth - noise / 2)) / noise;
        mean += share * (c * code - truth), variance += share * (c * code - truth) * (c * code - truth);
    }
    /* tolerance: four standard deviations of each estimate */
    assert_close(sum / count, mean, 4 * sqrt(variance / count));
    assert_close(square / count / variance, 1.0, 4 * 0.9 / sqrt(count));
    assert_close((product / count - mean * mean) / variance, 0.0, 4 / sqrt(count));
    plant_destroy(plant);
}

static void the_converter_saturates_at_its_range(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct hal_sample sample;
    params.sensors.enabled = true;
    params.sensors.pressure_full_scale_pa = 4e6; /* less than the 5 MPa that plant_place() sets */
    struct plant *plant = create(&params, 1);
    plant_place(plant, (const double[DOFS]){0});
    plant_measure(plant, &sample);
    for (int k = 0; k < LEGS; k++) assert_close(sample.p1_pa[k], 4e6 * (1 - 2.0 / 4096), 1e-6);
    plant_destroy(plant);
}

static void a_measurement_does_not_move_the_machine(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct hal_sample sample;
    struct plant *a = create(&params, 1), *b = create(&params, 1);
    for (int i = 0; i < 50; i++) {
        const double valve[LEGS] = {0.2, 0.1, 0.3, 0.2, 0.1, 0.3};
        plant_measure(a, &sample);
        plant_step(a, valve);
        plant_step(b, valve);
    }
    struct plant_truth ta = truth_of(a), tb = truth_of(b);
    assert_memory_equal(ta.pose, tb.pose, sizeof ta.pose);
    plant_destroy(a);
    plant_destroy(b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(starts_at_rest_on_the_lower_stops_without_a_jump),
        cmocka_unit_test(another_machine_settles_as_well),
        cmocka_unit_test(an_impossible_machine_is_refused_by_name),
        cmocka_unit_test(placed_it_rests_on_its_pressures),
        cmocka_unit_test(light_loads_get_half_the_supply_in_the_rodless_side),
        cmocka_unit_test(positive_valves_extend_and_raise),
        cmocka_unit_test(at_rest_the_valve_feeds_the_leakage),
        cmocka_unit_test(hostile_commands_break_nothing),
        cmocka_unit_test(a_nan_command_centres_the_valve),
        cmocka_unit_test(the_same_seed_gives_the_same_bits_and_another_does_not),
        cmocka_unit_test(disabled_sensors_tell_the_truth),
        cmocka_unit_test(lengths_come_in_steps_of_the_encoder),
        cmocka_unit_test(pressures_have_the_noise_and_the_codes_of_the_rig),
        cmocka_unit_test(the_converter_saturates_at_its_range),
        cmocka_unit_test(a_measurement_does_not_move_the_machine),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
