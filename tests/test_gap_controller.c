/* Checks whether the configured controller made the commands. The recordings are made here by the
 * controller's own law, on lengths that lag behind the references. */
#include "support.h"

#include "controller.h"
#include "force.h"
#include "kinematics.h"
#include "measured.h"
#include "pid.h"
#include "plant.h"
#include "platform.h"
#include "units.h"

static struct params params;
static struct recording recording;

enum { SAMPLES = 3000 };

/* Records a sine of 3 mm at 4 Hz in x, ramp-in included, on a machine that lags by 20 ms. */
static void record(double kff) {
    struct params machine = params;
    struct kinematics k;
    struct error error;
    struct pid pid[LEGS];
    machine.control.kff = kff;
    recording_init(&recording, &params);
    recording.measured = (struct recording_measured){.force = true, .pressures = true, .valve = true, .reference = true};
    recording.tests = 1;
    struct recording_test *t = &recording.test[0];
    *t = (struct recording_test){.dof = DOF_X, .frequency_hz = 4.0, .stated_hz = 4.0, .amplitude = 0.003};
    assert_int_equal(kinematics_init(&k, &params, &error), 0);
    struct cylinder_areas areas = cylinder_areas(&params.actuator);
    for (int i = 0; i < SAMPLES; i++) {
        struct recording_sample s = {.test_time_s = i * params.loop.period_s, .clock_s = i * params.loop.period_s};
        double late[DOFS] = {0}, ref_m[LEGS];
        s.ref[DOF_X] = 0.003 * sin(2 * PI * 4.0 * s.test_time_s);
        late[DOF_X] = 0.003 * sin(2 * PI * 4.0 * (s.test_time_s - 0.02));
        ik_lengths(&k, s.ref, ref_m);
        ik_lengths(&k, late, s.length_m);
        for (int leg = 0; leg < LEGS; leg++) {
            s.p1_pa[leg] = 3e6, s.p2_pa[leg] = 6e6;
            double force_n = leg_force(&areas, leg, s.p1_pa[leg], s.p2_pa[leg]);
            if (!i) pid_reset(&pid[leg], ref_m[leg], force_n);
            s.valve[leg] = pid_step(&pid[leg], &machine.control, params.loop.period_s, ref_m[leg], s.length_m[leg], force_n);
        }
        assert_int_equal(recording_append(t, &s, &error), 0);
    }
    t->first = SAMPLES / 6, t->end = t->count;
}

/* Removes the samples from from_s on, for `seconds`. */
static void lose(double from_s, double seconds) {
    struct recording_test *t = &recording.test[0];
    int kept = 0;
    for (int i = 0; i < t->count; i++)
        if (t->sample[i].test_time_s < from_s || t->sample[i].test_time_s >= from_s + seconds) t->sample[kept++] = t->sample[i];
    t->count = t->end = kept;
}

static double difference(void) {
    struct error error;
    assert_int_equal(measured_make(&recording, 0, &error), 0);
    return controller_difference(&params, &recording);
}

static void the_controllers_own_commands_do_not_differ(void **state) {
    (void)state;
    record(params.control.kff);
    assert_below(difference(), 1e-6);
    recording_free(&recording);
}

static void another_gain_differs(void **state) {
    (void)state;
    record(1.2 * params.control.kff);
    assert_true(difference() > 0.05);
    recording_free(&recording);
}

/* After a gap the integrator starts with another constant, wherever in the cycle the gap ends. */
static void a_hole_is_no_other_controller(void **state) {
    (void)state;
    double worst = 0.0;
    for (int eighth = 0; eighth < 8; eighth++) {
        record(params.control.kff);
        lose(3.0, 0.5 + eighth / 32.0);
        worst = fmax(worst, difference());
        recording_free(&recording);
    }
    print_message("# half a second lost: differs by %.3f %%\n", 100.0 * worst);
    assert_below(worst, 0.01);
}

static void every_lost_sample_is_a_long_step(void **state) {
    (void)state;
    record(params.control.kff);
    struct recording_test *t = &recording.test[0];
    int kept = 0;
    uint64_t seed = 3;
    /* random_unit() is in -1..1, so 5 % of the samples are lost */
    for (int i = 0; i < t->count; i++)
        if (i < 10 || random_unit(&seed) < 0.9) t->sample[kept++] = t->sample[i];
    assert_true(kept < 0.97 * t->count && kept > 0.93 * t->count);
    t->count = t->end = kept;
    assert_below(difference(), 0.02);
    recording_free(&recording);
}

/* Records a run of the tests of x and z under the configured law. */
static void drive(void) {
    struct error error;
    struct plant *plant = plant_create(&params, 1, &error);
    static struct platform platform;
    struct cycle c = {0};
    assert_int_equal(platform_init(&platform, &params, &error), 0);
    recording_init(&recording, &params);
    for (int i = 0; c.state != STATE_PARKING; i++) {
        struct hal_sample sample = {.time_ns = (int64_t)i * 2000000, .device_seq = (uint64_t)i + 1, .inputs = INPUTS_ALL};
        plant_measure(plant, &sample);
        platform_step(&platform, &sample, (struct request){0}, &c);
        assert_int_equal(recording_add(&recording, &c, &error), 0);
        plant_step(plant, c.out.enable ? c.out.valve : (const double[LEGS]){0});
        assert_true(c.state != STATE_FAULT && i < 20000);
    }
    for (int i = 0; i < recording.tests; i++) {
        struct recording_test *t = &recording.test[i];
        t->first = t->count / 2, t->end = t->count;
    }
    plant_destroy(plant);
}

/* The law's own commands are found again, except in the first moments of its low-passes; another
 * payload or another law gives other commands. */
static void the_law_model_is_known_and_told_from_the_pid(void **state) {
    (void)state;
    struct params before = params;
    params = brisk();
    params.control.law = CONTROL_MODEL;
    params.interlocks = (struct interlock_params){0};
    params.tests.duration_s = 2.0;
    params.tests.count = 2, params.tests.order[1] = DOF_Z;
    drive();
    assert_int_equal(recording.tests, 2);
    assert_below(difference(), 1e-4);
    params.payload.mass_kg *= 1.2;
    assert_true(difference() > 0.002);
    params.payload.mass_kg /= 1.2;
    params.control.law = CONTROL_PID;
    assert_true(difference() > 0.05);
    recording_free(&recording);
    params = before;
}

int main(void) {
    config_default(&params);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_controllers_own_commands_do_not_differ),
        cmocka_unit_test(another_gain_differs),
        cmocka_unit_test(a_hole_is_no_other_controller),
        cmocka_unit_test(every_lost_sample_is_a_long_step),
        cmocka_unit_test(the_law_model_is_known_and_told_from_the_pid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
