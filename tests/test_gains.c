/* Gains that may change while the controller runs: their keys, ranges and steps. */
#include "support.h"

#include "config.h"
#include "gains.h"

static struct gains gains_default(struct params *p) {
    config_default(p);
    return gains_of(&p->control);
}

/* The largest values are those of the key table, and each key is that of its gain. */
static void keys_and_ranges_are_those_of_the_configuration(void **unused) {
    (void)unused;
    for (int i = 0; i < LOOP_GAINS; i++) {
        struct params p;
        struct error error;
        char text[2][60];
        const char *const within = text[0], *const beyond = text[1];
        config_default(&p);
        snprintf(text[0], sizeof text[0], "%s=%.17g", gain_keys[i], gain_most[i]);
        snprintf(text[1], sizeof text[1], "%s=%.17g", gain_keys[i], 1.01 * gain_most[i]);
        assert_int_equal(config_override(&p, "it", &within, 1, &error), 0);
        assert_true(gains_of(&p.control).value[i] == gain_most[i]);
        assert_int_equal(config_override(&p, "it", &beyond, 1, &error), STATUS_USAGE);
    }
}

static void gains_come_back(void **unused) {
    (void)unused;
    struct params p;
    struct gains g = gains_default(&p);
    for (int i = 0; i < LOOP_GAINS; i++) g.value[i] += i + 1;
    gains_apply(&g, &p.control);
    struct gains again = gains_of(&p.control);
    assert_true(gains_equal(&g, &again));
    again.value[LOOP_GAINS - 1] += 1.0;
    assert_false(gains_equal(&g, &again));
}

static void a_step_is_a_factor_of_1_4_at_most(void **unused) {
    (void)unused;
    struct params p;
    struct gains from = gains_default(&p);
    static const struct {
        double from, to;
        bool may;
    } steps[] = {{40.0, 56.0, true}, {40.0, 56.1, false},  {40.0, 28.6, true},         {40.0, 28.5, false},
                 {40.0, 0.0, false}, {0.0, 0.0, true},     {0.0, 1e-9, false},         {40.0, -40.0, false},
                 {9e3, 1e4, true},   {9e3, 1.01e4, false}, {40.0, (double)NAN, false}, {40.0, (double)INFINITY, false}};
    for (unsigned i = 0; i < sizeof steps / sizeof *steps; i++) {
        struct gains to = from;
        from.value[GAIN_KP] = steps[i].from, to.value[GAIN_KP] = steps[i].to;
        assert_int_equal(gains_refused(&from, &to), steps[i].may ? LOOP_GAINS : GAIN_KP);
    }
}

/* Another machine has another digest; other gains, tests or a name have not. */
static void the_digest_is_that_of_the_loop_without_its_gains(void **unused) {
    (void)unused;
    struct params p, other;
    static const char *const same[] = {"control.kp=41", "control.kpf=1e-5", "tests.duration_s=3", "machine.name=rig", "motion.hold_s=3"};
    static const char *const differs[] = {"control.tp=0.06",
                                          "payload.mass_kg=180",
                                          "hydraulics.bulk_modulus_pa=1.1e9",
                                          "loop.period_s=0.001",
                                          "effects.command_delay.delay_s=0.001",
                                          "limits.following_m=0.011",
                                          "motion.engage_s=7",
                                          "tests.frequency_hz=3",
                                          "tests.amplitude_m=0.003"};
    enum { SAME = sizeof same / sizeof *same, DIFFERS = sizeof differs / sizeof *differs };
    struct error error;
    config_default(&p);
    for (int i = 0; i < SAME; i++) {
        config_default(&other);
        assert_int_equal(config_override(&other, "it", &same[i], 1, &error), 0);
        assert_true(config_digest(&other) == config_digest(&p));
    }
    for (int i = 0; i < DIFFERS; i++) {
        config_default(&other);
        assert_int_equal(config_override(&other, "it", &differs[i], 1, &error), 0);
        assert_true(config_digest(&other) != config_digest(&p));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_and_ranges_are_those_of_the_configuration),
        cmocka_unit_test(gains_come_back),
        cmocka_unit_test(a_step_is_a_factor_of_1_4_at_most),
        cmocka_unit_test(the_digest_is_that_of_the_loop_without_its_gains),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
