/* The gains that hexid tune finds, and their margins against the nonlinear machine. Arguments are
 * configuration files; then only their margins are measured. */
#include "support.h"

#include <complex.h>
#include <stdio.h>
#include <stdlib.h>

#include "loop_rig.h"
#include "loop_tune.h"

static const double neutral[DOFS] = {0};
static const double GAIN_DB = 3.0, PHASE_DEG = 10.0; /* tolerance of a measured margin */
static const double END_DEG = 15.0; /* tolerance at the ends of the strokes, where the legs differ
                                     * and their modes mix; 20 machines had at most 11 degrees */

static struct params load(const char *path, const char *setting) {
    struct params p;
    struct error error;
    if (config_load(&p, path, &setting, setting != NULL, &error)) fail_msg("%s", error.text);
    p.sensors.enabled = false; /* noise would hide a sine of a thousandth of the opening */
    p.sim.engine = ENGINE_CLOSED_FORM;
    return p;
}

static struct loop_tune tuned(struct params *p) {
    struct loop_tune t;
    struct error error;
    if (loop_tune(p, false, false, &t, &error)) fail_msg("%s", error.text);
    assert_true(t.gains.kp > 0.0);
    p->control = t.gains;
    return t;
}

static void multiply_gains(struct params *p, double by) {
    p->control.kp *= by, p->control.ki *= by, p->control.kd *= by, p->control.kpf *= by;
}

static void add_delay(struct params *p, double delay_s) { set_effect(p, "command_delay", 0, delay_s); }

/* ---- the loop's gain, measured ---- */

enum { SETTLE = 2000, WINDOW = 5000 };
static const double SINE = 1e-3;

/* Measures the gain of a mode's loop at its valve commands: a sine is added to the controller's own
 * command, and the gain is the controller's part divided by the whole command. The frequency is
 * moved to whole periods in the window. */
static double complex measured_gain(const struct params *p, const struct loop_place *place, int mode, double *hz) {
    static const double none[LEGS] = {0};
    struct loop_rig r;
    double most = 0.0, dt_s = p->loop.period_s;
    double complex answer = 0.0, given = 0.0;
    for (int i = 0; i < LEGS; i++) most = fmax(most, fabs(place->motion[mode][i]));
    *hz = fmax(round(*hz * WINDOW * dt_s), 1.0) / (WINDOW * dt_s);
    loop_rig_open(&r, p, place->pose);
    for (int n = 0; n < SETTLE + WINDOW; n++) {
        double add[LEGS], angle = 2.0 * PI * *hz * n * dt_s;
        for (int i = 0; i < LEGS; i++) add[i] = SINE * sin(angle) * place->motion[mode][i] / most;
        loop_rig_step(&r, none, add);
        double complex turn = cexp(CMPLX(0.0, -angle));
        for (int i = 0; i < LEGS && n >= SETTLE; i++)
            answer += turn * place->motion[mode][i] * r.command[i], given += turn * place->motion[mode][i] * (r.command[i] + add[i]);
    }
    loop_rig_close(&r);
    return -answer / given;
}

struct worst {
    double gain_db, phase_deg; /* largest differences */
};

static struct loop_margin predicted(const struct params *p, const struct loop_place *place, int mode) {
    static struct loop_plant plant;
    const struct loop_mode_input shape = loop_place_mode(place, mode);
    loop_plant_find(place->leg, &shape, p, &plant);
    return loop_margin(&plant, &p->control, p->loop.period_s);
}

/* Compares both margins of a mode at neutral, where the legs are alike and the modes do not mix,
 * with the loop's gain there. */
static void compare_mode(const struct params *p, const struct loop_place *place, int mode, struct worst *w) {
    struct loop_margin m = predicted(p, place, mode);
    if (isfinite(m.gain_db) && m.gain_db < 20.0) {
        double off_db = m.gain_db + 20.0 * log10(cabs(measured_gain(p, place, mode, &m.gain_hz)));
        w->gain_db = fmax(w->gain_db, fabs(off_db));
    }
    if (isfinite(m.phase_deg)) {
        double complex gain = measured_gain(p, place, mode, &m.phase_hz);
        double phase_deg = fabs(deg_from_rad(carg(-gain)));
        w->gain_db = fmax(w->gain_db, fabs(20.0 * log10(cabs(gain))));
        w->phase_deg = fmax(w->phase_deg, fabs(phase_deg - m.phase_deg));
    }
}

/* Checks that the platform is steady just below the predicted margins, in their worst poses, and
 * shakes just above. */
static void compare_limits(const struct params *p, const struct loop_standing *s, const char *name) {
    double size_m = 1.25e-4 * p->actuator.stroke_m[0];
    for (int above = 0; above < 2; above++) {
        struct params louder = *p, later = *p;
        double most = distance(s->delay_s.pose, neutral, DOFS) > 0.0 ? END_DEG : PHASE_DEG, degrees = above ? most : -most;
        multiply_gains(&louder, pow(10.0, (s->gain_db.value + (above ? GAIN_DB : -GAIN_DB)) / 20.0));
        if (loop_rig_shakes(&louder, s->gain_db.pose, size_m) != above)
            fail_msg("%s: with the gains %g dB %s it %s", name, GAIN_DB, above ? "above" : "below", above ? "holds" : "shakes");
        add_delay(&later, fmax(s->delay_s.value + degrees / 360.0 / s->delay_s.hz, 0.0));
        if (loop_rig_shakes(&later, s->delay_s.pose, size_m) != above)
            fail_msg("%s: with the delay %g degrees %s %g s at %g Hz it %s", name, most, above ? "above" : "below", s->delay_s.value,
                     s->delay_s.hz, above ? "holds" : "shakes");
    }
}

static void compare(const char *path) {
    struct params p = load(path, NULL);
    struct loop_tune t = tuned(&p);
    struct worst w = {0};
    struct loop_place place;
    assert_true(loop_place_find(&place, &p, neutral, 0.0));
    for (int mode = 0; mode < DOFS; mode++) compare_mode(&p, &place, mode, &w);
    print_message("# %s: margins at neutral off by %.2f dB, %.1f degrees at most\n", path, w.gain_db, w.phase_deg);
    assert_below(w.gain_db, GAIN_DB);
    assert_below(w.phase_deg, PHASE_DEG);
    compare_limits(&p, &t.after, path);
}

/* ---- claims ---- */

static const char *const machines[] = {"config/tian2015.yaml", "config/desktop.yaml", "config/simulator.yaml"};
enum { MACHINES = 3 };
static char **files;
static int file_count;

static void measured_margins_are_the_predicted_ones(void **unused) {
    (void)unused;
    slow_sweep();
    for (int i = 0; i < (more_cases() ? MACHINES : 1) && !file_count; i++) compare(machines[i]);
    for (int i = 0; i < file_count; i++) compare(files[i]);
}

/* Two derivations agree: with the gains raised by the gain margin, or the delay by the phase
 * margin, a pole of the sampled loop (loop_poles.h) lies on the limit of stability, at the margin's
 * frequency. */
static void a_margin_ends_where_a_pole_becomes_unstable(void **unused) {
    (void)unused;
    for (int i = 0; i < 2 * MACHINES; i++) {
        struct params p = load(machines[i / 2], i % 2 ? "control.modal=0.5" : NULL);
        struct loop_place place;
        assert_true(loop_place_find(&place, &p, neutral, 0.0));
        for (int mode = 0; mode < DOFS; mode++) {
            struct loop_margin m = predicted(&p, &place, mode);
            const struct loop_mode_input shape = loop_place_mode(&place, mode);
            struct loop_pole pole[LOOP_POLES];
            struct params louder = p;
            double least = HUGE_VAL, hz = 0.0;
            multiply_gains(&louder, pow(10.0, m.gain_db / 20.0));
            int count = loop_poles_all(place.leg, &shape, &louder, pole);
            for (int k = 0; k < count; k++)
                if (pole[k].radps > 1.0 && loop_pole_damping(&pole[k]) < least)
                    least = loop_pole_damping(&pole[k]), hz = loop_pole_hz(&pole[k]);
            assert_close(least, 0.0, 2e-3);
            assert_close(hz, m.gain_hz, 0.01 * m.gain_hz);
        }
    }
}

static void delay_is_a_margin_too(void **unused) {
    (void)unused;
    for (int i = 0; i < 2 * MACHINES; i++) {
        struct params p = load(machines[i / 2], i % 2 ? "control.modal=0.5" : NULL);
        struct loop_place place;
        assert_true(loop_place_find(&place, &p, neutral, 0.0));
        double delay_s = HUGE_VAL;
        for (int mode = 0; mode < DOFS; mode++) delay_s = fmin(delay_s, predicted(&p, &place, mode).delay_s);
        /* loop_poles.h cannot compute so long a delay */
        if (delay_s > (LOOP_DELAY_MOST - 1) * p.loop.period_s) continue;
        for (int above = 0; above < 2; above++) {
            assert_true(loop_place_find(&place, &p, neutral, delay_s * (above ? 1.03 : 0.97)));
            struct loop_worst worst = loop_place_worst(&place, &p);
            assert_int_equal(worst.pole.decay_per_s < 0.0, above);
        }
    }
}

static int by_delay(const void *a, const void *b) {
    double first_s = ((const struct loop_margin *)a)->delay_s, second_s = ((const struct loop_margin *)b)->delay_s;
    return (first_s > second_s) - (first_s < second_s);
}

/* Weights a on the diagonal and b beside it connect two equal modes into two others, with gains a +
 * b and a - b; which is which is not said. */
static void connected_modes_have_the_margins_of_those_they_make(void **unused) {
    (void)unused;
    static const double mix[DOFS][DOFS] = {{2.0, 1.1}, {1.1, 2.0}, {[2] = 1.6, 0.2}, {[2] = 0.2, 1.6}, {[4] = 0.9, 0.3}, {[4] = 0.3, 0.9}};
    struct params p = load("config/simulator.yaml", NULL);
    struct loop_place place;
    static struct loop_plant plant[DOFS];
    struct loop_margin connected[DOFS], made[DOFS];
    assert_true(loop_place_find(&place, &p, neutral, 0.0));
    const struct loop_mode_input shape = loop_place_mode(&place, 0);
    for (int mode = 0; mode < DOFS; mode++) loop_plant_find(place.leg, &shape, &p, &plant[mode]);
    loop_margins(plant, mix, &p.control, p.loop.period_s, connected);
    for (int mode = 0; mode < DOFS; mode++) {
        plant[mode].gain = mix[mode][mode] + (mode % 2 ? -1.0 : 1.0) * mix[mode][mode ^ 1];
        made[mode] = loop_margin(&plant[mode], &p.control, p.loop.period_s);
    }
    qsort(connected, DOFS, sizeof *connected, by_delay);
    qsort(made, DOFS, sizeof *made, by_delay);
    for (int i = 0; i < DOFS; i++) {
        assert_close(connected[i].gain_db, made[i].gain_db, 0.05);
        assert_close(connected[i].phase_deg, made[i].phase_deg, 0.5);
        assert_close(connected[i].delay_s, made[i].delay_s, 0.01 * made[i].delay_s);
    }
}

static void tuned_gains_reach_what_is_wanted(void **unused) {
    (void)unused;
    numbers_case();
    for (int i = 0; i < MACHINES; i++) {
        struct params p = load(machines[i], NULL);
        p.sensors.enabled = true;
        struct loop_tune t = tuned(&p);
        assert_true(t.reached);
        assert_true(t.after.stable);
        assert_true(t.after.gain_db.value >= TUNE_GAIN_DB);
        assert_true(t.after.phase_deg.value >= TUNE_PHASE_DEG);
        assert_true(t.after.damping.value >= TUNE_DAMPING);
        assert_true(t.after.following_m <= TUNE_FOLLOWING * p.limits.following_m);
        assert_true(t.after.noise_mps2 <= t.after.noise_most_mps2);
        assert_true(fabs(t.after.amplitude.value) <= fabs(t.before.amplitude.value));
        assert_true(p.control.kd == 0.0 && p.control.tf > 0.0);
    }
}

/* Gains of the modes do not spend the delay that the loop bears without them. */
static void faster_modes_leave_half_of_the_delay(void **unused) {
    (void)unused;
    slow_sweep();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    static const double wanted[MACHINES] = {0.0, 0.4, 1.0};
    for (int i = 0; i < (more_cases() ? MACHINES : 2); i++) {
        struct params p = load(machines[i], NULL);
        struct loop_standing with, without;
        struct error error;
        p.sensors.enabled = true;
        tuned(&p);
        assert_close(p.control.modal, wanted[i], 1e-12);
        assert_int_equal(loop_tune_stand(&p, false, &with, &error), STATUS_OK);
        p.control.modal = 0.0;
        assert_int_equal(loop_tune_stand(&p, false, &without, &error), STATUS_OK);
        assert_true(with.delay_s.value >= TUNE_MODAL_DELAY * without.delay_s.value);
    }
}

/* A user's platform of 4 t with the default controller is unstable before, and stable with its own
 * gains. */
static void a_heavy_platform_with_the_default_gains_gets_its_own(void **unused) {
    (void)unused;
    slow_case();
    struct params p = load("config/simulator.yaml", "payload.mass_kg=4000"), usual = load(NULL, NULL);
    p.control = usual.control;
    struct loop_tune t = tuned(&p);
    assert_false(t.before.stable);
    assert_true(t.reached && t.after.stable);
    assert_true(t.gains.kpf < 0.2 * usual.control.kpf);
    assert_false(loop_rig_shakes(&p, neutral, 1e-4));
}

/* Slow valves or air in the oil limit a loop, and a bus's delay lowers its gains. */
static void what_limits_a_loop_is_named(void **unused) {
    (void)unused;
    slow_sweep();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    static const struct {
        const char *setting;
        enum loop_part limit;
    } cases[] = {{"hydraulics.valve_frequency_hz=20", LOOP_PART_VALVE}, {"effects.entrained_air.bulk_modulus_pa=1e8", LOOP_PART_OIL}};
    struct params p;
    struct loop_tune t;
    struct error error;
    for (int i = 0; i < (more_cases() ? 2 : 1); i++) {
        p = load(NULL, cases[i].setting);
        assert_int_equal(loop_tune(&p, false, true, &t, &error), STATUS_OK);
        assert_false(t.reached);
        assert_int_equal(t.limit, cases[i].limit);
        assert_true(t.part_damping[t.limit] > t.after.damping.value);
    }
    p = load("config/simulator.yaml", NULL);
    struct loop_tune direct = tuned(&p);
    p.control = direct.now;
    assert_int_equal(loop_tune(&p, true, false, &t, &error), STATUS_OK);
    assert_true(t.gains.kp < direct.gains.kp || t.gains.kpf < direct.gains.kpf);
}

static void what_cannot_be_held_gets_no_gains(void **unused) {
    (void)unused;
    struct params p = load(NULL, "payload.mass_kg=90000");
    struct loop_tune t;
    struct error error;
    assert_int_equal(loop_tune(&p, false, false, &t, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "does not hold the platform up"));
    p = load(NULL, "effects.command_delay.delay_s=0.03");
    assert_int_equal(loop_tune(&p, false, false, &t, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "longer than 14 cycles"));
}

int main(int argc, char **argv) {
    files = argv + 1, file_count = argc - 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(measured_margins_are_the_predicted_ones),
        cmocka_unit_test(a_margin_ends_where_a_pole_becomes_unstable),
        cmocka_unit_test(delay_is_a_margin_too),
        cmocka_unit_test(connected_modes_have_the_margins_of_those_they_make),
        cmocka_unit_test(tuned_gains_reach_what_is_wanted),
        cmocka_unit_test(faster_modes_leave_half_of_the_delay),
        cmocka_unit_test(a_heavy_platform_with_the_default_gains_gets_its_own),
        cmocka_unit_test(what_limits_a_loop_is_named),
        cmocka_unit_test(what_cannot_be_held_gets_no_gains),
    };
    const struct CMUnitTest measured[] = {cmocka_unit_test(measured_margins_are_the_predicted_ones)};
    return file_count ? cmocka_run_group_tests(measured, NULL, NULL) : cmocka_run_group_tests(tests, NULL, NULL);
}
