/* Readings at rest before the supply comes on are zero errors of the sensors. */
#include "support.h"

#include "rest.h"

static const double TANK_PA = 2e5;

static struct cycle resting(enum state state, double p1_pa, uint64_t *seed) {
    struct cycle c = {.test = -1, .dof = DOF_NONE, .state = state};
    for (int k = 0; k < LEGS; k++) {
        c.in.length_m[k] = 1.4 + 0.01 * k;
        c.in.p1_pa[k] = p1_pa + 1e4 * k + 2e4 * random_unit(seed);
        c.in.p2_pa[k] = TANK_PA;
    }
    return c;
}

static struct params machine(void) {
    struct params params;
    config_default(&params);
    params.hydraulics.tank_pa = TANK_PA;
    params.sensors.enabled = false;
    return params;
}

/* The tolerance follows from noise of 2e4 / sqrt(3) Pa rms over 400 samples. */
static void pressures_read_their_zeros(void **unused) {
    (void)unused;
    enum { SAMPLES = 400 };
    struct params params = machine();
    struct rest r = {0};
    uint64_t seed = 4;
    for (int i = 0; i < SAMPLES; i++) {
        struct cycle c = resting(i < 50 ? STATE_INIT : STATE_SETTLED, TANK_PA + 3e4, &seed);
        rest_take(&r, &c);
    }
    struct rest_found found = rest_find(&r, &params);
    double expected = 2e4 / sqrt(3.0) / sqrt(SAMPLES);
    assert_int_equal(found.samples, SAMPLES);
    for (int k = 0; k < LEGS; k++) {
        assert_close(found.zero_std_pa[0][k], expected, 0.1 * expected);
        assert_close(found.zero_pa[0][k], 3e4 + 1e4 * k, 4.0 * expected);
        assert_close(found.zero_pa[1][k], 0.0, 1e-6);
        assert_close(found.length_m[k], 1.4 + 0.01 * k, 1e-12);
    }
}

/* Once the supply has been on, chambers may be under pressure, whatever the state is. */
static void what_comes_after_the_supply_does_not_count(void **unused) {
    (void)unused;
    struct params params = machine();
    struct rest r = {0};
    uint64_t seed = 5;
    for (int i = 0; i < 300; i++) {
        struct cycle c = resting(i == 100 ? STATE_PRESSURISING : STATE_SETTLED, i < 100 ? TANK_PA : 5e6, &seed);
        if (i == 50) c.in.flags = SAMPLE_STALE;
        if (i == 51) c.in.p1_pa[2] = (double)NAN;
        rest_take(&r, &c);
    }
    assert_int_equal(rest_find(&r, &params).samples, 98);
}

/* A later part of a log may begin after a park, with chambers under pressure. */
static void a_log_that_begins_later_has_no_rest(void **unused) {
    (void)unused;
    struct params params = machine();
    struct rest r = {0};
    uint64_t seed = 7;
    for (int i = 0; i < 300; i++) {
        struct cycle c = resting(STATE_SETTLED, TANK_PA, &seed);
        c.seq = 70000 + (uint64_t)i;
        rest_take(&r, &c);
    }
    assert_int_equal(rest_find(&r, &params).samples, 0);
}

static void a_short_rest_finds_nothing(void **unused) {
    (void)unused;
    struct params params = machine();
    struct rest r = {0};
    uint64_t seed = 6;
    params.actuator.retracted_std_m = 1e-4;
    for (int i = 0; i < REST_LEAST - 1; i++) {
        struct cycle c = resting(STATE_SETTLED, TANK_PA, &seed);
        rest_take(&r, &c);
    }
    struct rest_found found = rest_find(&r, &params);
    rest_note_stops(&found, &params);
    assert_true(params.found.retracted_std_m == 0.0 && found.zero_std_pa[0][0] == 0.0);
}

/* Lengths at the stops are used if the configuration has the retracted lengths. */
static void legs_on_their_stops_read_their_zeros(void **unused) {
    (void)unused;
    struct params params = machine();
    struct rest_found found = {.samples = REST_LEAST};
    for (int k = 0; k < LEGS; k++) found.length_m[k] = 1.4 + 1e-3 * k, params.actuator.retracted_m[k] = 1.4;
    rest_note_stops(&found, &params);
    assert_true(params.found.retracted_std_m == 0.0);
    params.actuator.retracted_std_m = 3e-4, params.sensors.enabled = true, params.sensors.position_resolution_m = 4e-4 * sqrt(12.0);
    rest_note_stops(&found, &params);
    assert_close(params.found.retracted_std_m, 5e-4, 1e-12);
    for (int k = 0; k < LEGS; k++) assert_close(params.found.retracted_m[k], 1e-3 * k, 1e-12);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(pressures_read_their_zeros),
                                       cmocka_unit_test(what_comes_after_the_supply_does_not_count),
                                       cmocka_unit_test(a_log_that_begins_later_has_no_rest), cmocka_unit_test(a_short_rest_finds_nothing),
                                       cmocka_unit_test(legs_on_their_stops_read_their_zeros)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
