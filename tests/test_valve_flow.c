/* The flow equations of the controller invert the simulated cylinder's, and are compared with
 * them. */
#include "support.h"

#include "cylinder.h"
#include "kinematics.h"
#include "valve_flow.h"

/* Returns a machine with effects that the law takes into account, all different from neutral, with
 * another value on each leg. */
static struct params uneven(void) {
    struct params params;
    config_default(&params);
    set_effect(&params, "valve_flow_gain", 0, 0.8);
    set_effect(&params, "port_area_ratio", 0, 0.6);
    set_effect(&params, "internal_leakage", 0, 3.0);
    set_effect(&params, "valve_dead_band", 0, 0.03);
    set_effect(&params, "valve_null_bias", 0, -0.02);
    for (int leg = 0; leg < LEGS; leg++) {
        params.effects[effect_find("valve_flow_gain")].value[0][leg] *= 1.0 + 0.1 * leg;
        params.hydraulics.bulk_modulus_pa[leg] *= 1.0 - 0.1 * leg;
        params.hydraulics.dead_volume_difference_m3[leg] = 2e-5 * leg;
    }
    return params;
}

static struct oil_state random_state(const struct valve_flow *f, uint64_t *seed) {
    return (struct oil_state){.p1_pa = f->supply_pa * (0.5 + 0.45 * random_unit(seed)),
                              .p2_pa = f->supply_pa * (0.5 + 0.45 * random_unit(seed)),
                              .length_m = f->least_m + (f->most_m - f->least_m) * (0.5 + 0.49 * random_unit(seed)),
                              .rate_mps = 0.3 * random_unit(seed)};
}

static struct cylinder_state rates_of(const struct cylinder_model *m, int leg, const struct oil_state *oil, double opening) {
    struct mains mains = cylinder_mains(m);
    struct cylinder_state s = {.p1_pa = oil->p1_pa, .p2_pa = oil->p2_pa};
    return cylinder_derivative(m, leg, &mains, &s, opening, oil->length_m, oil->rate_mps, 0.0);
}

static void the_opening_makes_the_rate_of_force(void **unused) {
    (void)unused;
    struct params params = uneven();
    struct kinematics k;
    struct cylinder_model m;
    uint64_t seed = 11;
    int both[2] = {0};
    kinematics_place(&k, &params);
    cylinder_model_init(&m, &params);
    for (int n = 0; n < 3000; n++) {
        struct valve_flow f;
        int leg = n % LEGS;
        valve_flow_init(&f, leg, &params, &k);
        struct oil_state oil = random_state(&f, &seed);
        double wanted = 3e5 * random_unit(&seed), opening = valve_flow_opening(&f, &oil, wanted);
        if (fabs(opening) > 1.0) continue;
        both[opening > 0.0]++;
        struct cylinder_state rate = rates_of(&m, leg, &oil, opening);
        assert_close(f.area_m2[0] * rate.p1_pa - f.area_m2[1] * rate.p2_pa, wanted, 1e-6 * 3e6);
    }
    assert_true(both[0] > 500 && both[1] > 500);
}

/* Tolerance: an explicit step of 10 us has an error of 1e-4 of the change. */
static void pressures_advance_as_in_the_cylinder(void **unused) {
    (void)unused;
    struct params params = uneven();
    struct kinematics k;
    struct cylinder_model m;
    uint64_t seed = 12;
    kinematics_place(&k, &params);
    cylinder_model_init(&m, &params);
    for (int n = 0; n < 600; n++) {
        struct valve_flow f;
        int leg = n % LEGS;
        valve_flow_init(&f, leg, &params, &k);
        struct oil_state oil = random_state(&f, &seed), after = oil;
        double opening = 0.2 * random_unit(&seed);
        struct cylinder_state rate = rates_of(&m, leg, &oil, opening);
        valve_flow_advance(&f, &after, opening, 1e-6);
        assert_close(after.p1_pa - oil.p1_pa, 1e-6 * rate.p1_pa, 1e-3);
        assert_close(after.p2_pa - oil.p2_pa, 1e-6 * rate.p2_pa, 1e-3);
        valve_flow_advance(&f, &after, 5.0 * opening, 10.0);
        assert_true(after.p1_pa >= f.tank_pa && after.p1_pa <= f.supply_pa && after.p2_pa >= f.tank_pa && after.p2_pa <= f.supply_pa);
    }
}

/* No oil passes the valve, so the sum of both chambers' compressed volumes stays the same. */
static void a_load_moves_the_shut_piston(void **unused) {
    (void)unused;
    struct params params = uneven();
    struct kinematics k;
    struct valve_flow f;
    kinematics_place(&k, &params);
    valve_flow_init(&f, 0, &params, &k);
    struct oil_state oil = {.p1_pa = 4e6, .p2_pa = 6e6, .length_m = 1.7}, after = oil;
    double force_n = f.area_m2[0] * oil.p1_pa - f.area_m2[1] * oil.p2_pa + 500.0;
    valve_flow_load(&f, &after, force_n);
    assert_close(f.area_m2[0] * after.p1_pa - f.area_m2[1] * after.p2_pa, force_n, 1e-6);
    double rodless_m3 = f.dead_m3[0] + f.area_m2[0] * (1.7 - f.least_m), rod_m3 = f.dead_m3[1] + f.area_m2[1] * (f.most_m - 1.7);
    double way_1 = (after.p1_pa - oil.p1_pa) * rodless_m3 / f.area_m2[0], way_2 = (oil.p2_pa - after.p2_pa) * rod_m3 / f.area_m2[1];
    assert_close(way_1, way_2, 1e-9 * fabs(way_1));
}

static void the_command_passes_the_dead_band_and_the_null(void **unused) {
    (void)unused;
    struct params params = uneven();
    struct kinematics k;
    struct cylinder_model m;
    struct valve_flow f;
    kinematics_place(&k, &params);
    cylinder_model_init(&m, &params);
    valve_flow_init(&f, 3, &params, &k);
    for (double opening = -0.4; opening < 0.4; opening += 0.0107) {
        double spool = valve_flow_command(&f, opening) + m.machine.valve.bias[3];
        assert_close(machine_opening(&m.machine, 3, spool), opening, 1e-12);
        assert_close(valve_flow_opened(&f, valve_flow_command(&f, opening)), opening, 1e-12);
    }
    double before = valve_flow_command(&f, -0.003);
    for (double opening = -0.003; opening < 0.003; opening += 1e-5) {
        double command = valve_flow_command(&f, opening);
        assert_true(command >= before && command - before < 3e-4);
        before = command;
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_opening_makes_the_rate_of_force),
        cmocka_unit_test(pressures_advance_as_in_the_cylinder),
        cmocka_unit_test(a_load_moves_the_shut_piston),
        cmocka_unit_test(the_command_passes_the_dead_band_and_the_null),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
