/* Motions other than a sinusoid of one axis: splines, their files, the reference and the platform
 * that follow them, and the check before a run. */
#include "platform_rig.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "motion_check.h"
#include "trajectory_file.h"

enum { KNOTS = 41, TEXT = 1 << 16 };

static const double dt_s = 0.002;
static struct trajectory_knot knots[KNOTS];
static char path[40];
static struct error error;

/* The knots lie on a wave of each axis, at uneven times: two periods of x in 4 s. */
static double wave(int axis, double t_s) { return 0.01 * (axis + 1) * sin(PI * t_s + 0.4 * axis); }
static double wave_rate(int axis, double t_s) { return 0.01 * (axis + 1) * PI * cos(PI * t_s + 0.4 * axis); }

static struct trajectory sampled(int passes) {
    struct trajectory t = {.knots = KNOTS, .passes = passes, .knot = knots};
    uint64_t seed = 5;
    for (int i = 0; i < KNOTS; i++) {
        bool inner = i > 0 && i < KNOTS - 1;
        knots[i] = (struct trajectory_knot){.time_s = 0.1 * i + (inner ? 0.03 * random_unit(&seed) : 0.0)};
        for (int axis = 0; axis < DOFS; axis++) knots[i].pose[axis] = wave(axis, i == KNOTS - 1 ? 0.0 : knots[i].time_s);
    }
    assert_true(trajectory_bend(&t));
    return t;
}

/* ---- spline ---- */

static void a_trajectory_goes_through_its_poses(void **unused) {
    (void)unused;
    for (int passes = 1; passes <= 3; passes += 2) {
        struct trajectory t = sampled(passes);
        double pose[DOFS];
        assert_close(trajectory_s(&t), 4.0 * passes, 1e-12);
        for (int pass = 0; pass < passes; pass++)
            for (int i = 0; i < KNOTS; i++) {
                trajectory_at(&t, 4.0 * pass + knots[i].time_s, pose);
                assert_below(distance(pose, knots[i].pose, DOFS), 1e-13);
            }
    }
}

/* Tolerance: the error of a cubic spline is 5/384 h^4 |f''''| with h = 0.16 s, away from open ends;
 * everywhere if the spline is closed. */
static void between_them_it_is_the_wave_they_are_of(void **unused) {
    (void)unused;
    for (int passes = 1; passes <= 2; passes++) {
        struct trajectory t = sampled(passes);
        double pose[DOFS], edge_s = passes > 1 ? 0.0 : 1.0;
        for (double time_s = edge_s; time_s < 4.0 * passes - edge_s; time_s += 0.0137) {
            trajectory_at(&t, time_s, pose);
            for (int axis = 0; axis < DOFS; axis++)
                assert_close(pose[axis], wave(axis, time_s), 5.0 / 384.0 * pow(0.16 * PI, 4) * 0.01 * (axis + 1));
        }
    }
}

/* From step to step, the second differences of a smooth curve change by h times its third
 * derivative. A jump of the second derivative would not shrink with h. */
static void pose_rate_and_acceleration_are_continuous(void **unused) {
    (void)unused;
    static const double h = 1e-3;
    for (int passes = 1; passes <= 3; passes++) {
        struct trajectory t = sampled(passes);
        double p[4][DOFS], step = 0.0;
        for (int n = 0; n + 3 <= (int)lround(trajectory_s(&t) / h); n++) {
            for (int k = 0; k < 4; k++) trajectory_at(&t, h * (n + k), p[k]);
            for (int axis = 0; axis < DOFS; axis++)
                step = fmax(step, fabs(p[3][axis] - 3 * p[2][axis] + 3 * p[1][axis] - p[0][axis]) / (h * h));
        }
        /* a corner between two passes, or at a knot, would be 0.06 PI^2 */
        assert_below(step, h * 6.0 * 0.06 * pow(PI, 3));
    }
}

static void a_natural_end_has_no_acceleration_and_goes_straight_on(void **unused) {
    (void)unused;
    struct trajectory t = sampled(1);
    double at[3][DOFS];
    for (int axis = 0; axis < DOFS; axis++) assert_true(knots[0].bend[axis] == 0.0 && knots[KNOTS - 1].bend[axis] == 0.0);
    for (int end = 0; end <= 1; end++) {
        for (int k = 0; k < 3; k++) trajectory_at(&t, 4.0 * end + 0.01 * (k - 1), at[k]);
        for (int axis = 0; axis < DOFS; axis++) {
            assert_close(at[2][axis] - at[1][axis], at[1][axis] - at[0][axis], 2e-6);
            /* tolerance: the natural ends bend the spline a little */
            assert_close((at[1][axis] - at[0][axis]) / 0.01, wave_rate(axis, 0.0), 0.03 * (axis + 1));
        }
    }
    trajectory_at(&t, -2.0, at[0]), trajectory_at(&t, -1.0, at[1]), trajectory_at(&t, 0.0, at[2]);
    for (int axis = 0; axis < DOFS; axis++) assert_close(at[2][axis] - at[1][axis], at[1][axis] - at[0][axis], 1e-12);
}

static void a_parabola_of_three_knots(void **unused) {
    (void)unused;
    struct trajectory_knot three[3] = {{.time_s = 0}, {.time_s = 1, .pose = {1}}, {.time_s = 2}};
    struct trajectory t = {.knots = 3, .passes = 1, .knot = three};
    assert_true(trajectory_bend(&t));
    assert_close(three[1].bend[DOF_X], -3.0, 1e-12); /* the knots give 4 b = 6 (-1 - 1) */
    t.passes = 2; /* a closed spline has 4 a + 2 b = 12 and 2 a + 4 b = -12 */
    assert_true(trajectory_bend(&t));
    assert_close(three[0].bend[DOF_X], 6.0, 1e-12);
    assert_close(three[1].bend[DOF_X], -6.0, 1e-12);
    assert_close(three[2].bend[DOF_X], 6.0, 1e-12);
}

/* ---- file ---- */

static void put(const char *text, size_t size) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static int load(struct trajectory *t, const char *text, int passes) {
    put(text, strlen(text));
    error = (struct error){0};
    return trajectory_load(t, path, passes, &error);
}

static void files_of_other_programs_are_taken(void **unused) {
    (void)unused;
    static const char *const texts[] = {
        "t_s,theta_rad,x_m\n10,0,0\n11,0.02,0.01\n13,0,0\n",
        "# of a spreadsheet\r\n\r\n\"x_m\";\"t_s\";\"theta_rad\"\r\n0;10;0\r\n0,01;11;0,02\r\n0;13,0;0\r\n",
        "\xef\xbb\xbft_s\tx_m\ttheta_rad\n1e1\t0\t0\n# half way\n1.1e1\t1e-2\t2e-2\n13\t0\t-0\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct trajectory t;
        if (load(&t, texts[i], 1)) fail_msg("%zu: %s", i, error.text);
        assert_int_equal(t.knots, 3);
        assert_true(t.knot[0].time_s == 0.0 && t.knot[1].time_s == 1.0 && t.knot[2].time_s == 3.0);
        assert_true(t.knot[1].pose[DOF_X] == 0.01 && t.knot[1].pose[DOF_THETA] == 0.02 && t.knot[1].pose[DOF_Z] == 0.0);
        trajectory_free(&t);
    }
}

static void whatever_else_is_refused_with_line_and_remedy(void **unused) {
    (void)unused;
    static const struct {
        const char *text, *says;
        int passes;
    } cases[] = {
        {"", ":0: an empty file", 1},
        {"# nothing\n", ":1: an empty file", 1},
        {"t_s,x_mm\n0,1\n", ":1: \"x_mm\" is no column of a trajectory: they are t_s, x_m", 1},
        {"t_s,x_m,x_m\n", ":1: x_m stands there twice", 1},
        {"x_m\n1\n", ":1: no column t_s", 1},
        {"t_s\n1\n", ":1: no column of an axis", 1},
        {"t_s,x_m\n0,0\n1,nan\n", ":3: x_m: nan: every row has a number", 1},
        {"t_s,x_m\n0,0\n1,\n", ":3: x_m: nan", 1},
        {"t_s,x_m\n0,0\n1,inf\n", ":3: x_m: inf", 1},
        {"t_s,x_m\n0,0\n1,1e300\n", ":3: x_m: 1e+300: every row has a number within 10 either way, in metres", 1},
        {"t_s,phi_rad\n0,0\n1,5\n", ":3: phi_rad: 5: every row has a number within 3.142", 1},
        {"t_s,x_m\n0,0\n1,one\n", ":3: x_m: one is no number", 1},
        {"t_s,x_m\nnan,0\n", ":2: t_s: every row needs its time", 1},
        {"t_s,x_m\n0,0\n-inf,0\n", ":3: t_s: every row needs its time", 1},
        {"t_s,x_m\n0,0\n0,0\n", ":3: t_s: 0 after 0: time must increase", 1},
        {"t_s,x_m\n0,0\n1e-308,10\n1,0\n", ":3: t_s: 1e-308 after 0: time must increase from row to row, by 1e-06 s", 1},
        {"t_s,x_m\n1,0\n2,0\n1.5,0\n", ":4: t_s: 1.5 after 2: time must increase", 1},
        {"t_s,x_m\n0,0\n3601,0\n", ":3: 3601 s, 1 times: a run's motion is at most 3600 s", 1},
        {"t_s,x_m\n0,0\n1,0\n40,0\n", ":4: 40 s, 100 times", 100},
        {"t_s,x_m\n0,0\n1,0\n1e308,0\n", ":4: 1e+308 s", 1},
        {"t_s,x_m\n-1e308,0\n1e308,0\n", ":3: ", 1},
        {"t_s,x_m\n0,0\n1,0,0\n", ":3: more or fewer cells than the 2", 1},
        {"t_s,x_m\n0,0\n1\n", ":3: more or fewer cells than the 2", 1},
        {"t_s,x_m\n0,0\n1,0\n", ":3: 2 rows: a trajectory has at least 3", 1},
        {"t_s,x_m\n0,0\n1e-5,0\n2e-5,0\n", ":4: 2e-05 s: too short", 1},
        {"t_s,x_m\n0,0\n1,0.01\n2,0.001\n", ":4: x_m: ends at 0.001, began at 0: what is repeated must end where it began", 2},
        {"t_s,x_m\n0,\"0\n", ":2: a quote is not closed", 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct trajectory t;
        assert_int_equal(load(&t, cases[i].text, cases[i].passes), STATUS_USAGE);
        if (strncmp(error.text, path, strlen(path)) || !strstr(error.text, cases[i].says)) fail_msg("%zu: %s", i, error.text);
        trajectory_free(&t);
    }
    struct trajectory t;
    assert_int_equal(trajectory_load(&t, "/nowhere/at/all.csv", 1, &error), STATUS_IO);
    assert_non_null(strstr(error.text, "/nowhere/at/all.csv: cannot be read"));
    trajectory_free(&t);
}

/* A good file with random changes of bytes is refused, or its poses are finite at every instant. */
static void no_file_makes_a_pose_that_is_no_number(void **unused) {
    (void)unused;
    slow_case();
    static const char good[] = "t_s,x_m,psi_rad\n0,0,0\n0.5,0.01,0.02\n1.5,-0.01,1e-2\n2,0,0\n",
                      letters[] = "0123456789.,-+eE;\t\n\"#naifx_\0";
    uint64_t seed = 9;
    int taken = 0;
    for (int run = 0; run < 3000; run++) {
        char text[sizeof good];
        struct trajectory t;
        double pose[DOFS];
        memcpy(text, good, sizeof good);
        for (int k = random_below(&seed, 3); k >= 0; k--)
            text[random_below(&seed, sizeof good - 1)] = letters[random_below(&seed, sizeof letters)];
        put(text, sizeof good - 1);
        int status = trajectory_load(&t, path, 1 + run % 2, &error);
        assert_true(status == STATUS_OK || status == STATUS_USAGE);
        taken += status == STATUS_OK;
        for (double at_s = -1.0; !status && at_s < trajectory_s(&t) + 1.0; at_s += 0.05 * (1.0 + trajectory_s(&t))) {
            trajectory_at(&t, at_s, pose);
            for (int i = 0; i < DOFS; i++) assert_true(isfinite(pose[i]));
        }
        trajectory_free(&t);
    }
    print_message("# %d of 3000 were taken\n", taken);
    assert_in_range(taken, 50, 2900);
}

/* ---- reference ---- */

/* Second differences divided by dt^2: accelerations that the legs must be able to follow. */
struct watch {
    int seen;
    double last[DOFS], before[DOFS], acceleration, rate;
};

static void watch(struct watch *w, const double pose[DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        if (w->seen > 0) w->rate = fmax(w->rate, fabs(pose[i] - w->last[i]) / dt_s);
        if (w->seen > 1) w->acceleration = fmax(w->acceleration, fabs(pose[i] - 2 * w->last[i] + w->before[i]) / (dt_s * dt_s));
        w->before[i] = w->last[i], w->last[i] = pose[i];
    }
    w->seen++;
}

/* Bounds by the product rule. Pose, rate and acceleration of the motion are within 0.06, 0.2 and
 * 0.6 (pose 0.25 where a natural end continues straight during a ramp), those of the envelope
 * within 1, 3 and 24 (ramps of 0.5 s). */
static const double rate_most = 0.25 * 3.0 + 0.2, acceleration_most = 0.25 * 24.0 + 2.0 * 3.0 * 0.2 + 0.7;

static struct test_params half_second_ramps(void) {
    struct test_params t = brisk().tests;
    t.settle_s = 0.1, t.ramp_s = t.ramp_out_s = 0.5;
    return t;
}

static void a_trajectory_is_entered_and_left_smoothly(void **unused) {
    (void)unused;
    for (int passes = 1; passes <= 2; passes++) {
        struct trajectory trajectory = sampled(passes);
        struct test_params t = half_second_ramps();
        struct reference r;
        struct watch w = {0};
        int count[PHASE_RAMP_OUT + 1] = {0};
        reference_test(&r, DOF_NONE, &trajectory, &t, dt_s);
        for (bool done = false; !done;) {
            struct reference_sample s = reference_step(&r, &t, dt_s);
            double pose[DOFS];
            trajectory_at(&trajectory, s.test_time_s - 0.5, pose);
            /* exactly equal */
            if (s.phase == PHASE_EVALUATE) assert_true(distance(s.pose, pose, DOFS) == 0.0);
            if (s.phase == PHASE_SETTLE) assert_true(distance(s.pose, (double[DOFS]){0}, DOFS) == 0.0);
            watch(&w, s.pose);
            count[s.phase]++;
            done = s.done;
        }
        for (int n = 0; n < 3; n++) watch(&w, reference_step(&r, &t, dt_s).pose);
        assert_true(distance(w.last, (double[DOFS]){0}, DOFS) == 0.0);
        assert_int_equal(count[PHASE_RAMP_IN], 250);
        assert_int_equal(count[PHASE_EVALUATE], 2000 * passes);
        assert_int_equal(count[PHASE_RAMP_OUT], 251);
        assert_below(w.rate, rate_most);
        assert_below(w.acceleration, acceleration_most);
    }
}

static void stopped_at_any_instant_it_ramps_out_smoothly(void **unused) {
    (void)unused;
    struct trajectory trajectory = sampled(2);
    struct test_params t = half_second_ramps();
    for (int stop = 0; stop < 4500; stop += 7) {
        struct reference r;
        struct watch w = {0};
        int left = 252;
        reference_test(&r, DOF_NONE, &trajectory, &t, dt_s);
        for (int n = 0;; n++) {
            if (n == stop) reference_stop(&r);
            struct reference_sample s = reference_step(&r, &t, dt_s);
            watch(&w, s.pose);
            if (n >= stop) assert_int_equal(s.phase, PHASE_RAMP_OUT);
            if (s.done) break;
            assert_true(n < stop || --left > 0);
        }
        assert_true(distance(w.last, (double[DOFS]){0}, DOFS) == 0.0);
        assert_below(w.rate, rate_most);
        assert_below(w.acceleration, acceleration_most);
    }
}

static void a_multisine_is_the_sum_of_its_axes(void **unused) {
    (void)unused;
    struct test_params t = half_second_ramps();
    struct reference all, one[DOFS];
    for (int d = 0; d < DOFS; d++) t.hz[d] = 1.0 + 0.7 * d, t.amplitude[d] *= 1.0 + 0.1 * d;
    t.order[0] = DOF_PSI, t.order[1] = DOF_Z, t.count = 2;
    t.multisine = true;
    reference_test(&all, DOF_NONE, NULL, &t, dt_s);
    for (int d = 0; d < DOFS; d++) reference_test(&one[d], (enum dof)d, NULL, &t, dt_s);
    for (bool done = false; !done;) {
        struct reference_sample s = reference_step(&all, &t, dt_s);
        for (int d = 0; d < DOFS; d++) {
            struct reference_sample own = reference_step(&one[d], &t, dt_s);
            assert_true(s.pose[d] == (d == DOF_PSI || d == DOF_Z ? own.pose[d] : 0.0) && s.phase == own.phase);
        }
        done = s.done;
    }
}

/* ---- platform ---- */

static struct params gently(void) {
    struct params params = brisk();
    params.tests.ramp_s = params.tests.ramp_out_s = 0.5;
    strcpy(params.tests.trajectory, "wave.csv");
    return params;
}

/* Returns a trajectory with the wave's poses, a fifth as large. */
static struct trajectory gentle(int passes) {
    struct trajectory t = sampled(passes);
    for (int i = 0; i < KNOTS; i++)
        for (int axis = 0; axis < DOFS; axis++) knots[i].pose[axis] *= 0.2;
    assert_true(trajectory_bend(&t));
    return t;
}

static void the_platform_follows_it_as_one_test_of_no_axis(void **unused) {
    (void)unused;
    struct params params = gently();
    struct trajectory trajectory = gentle(2);
    struct rig rig;
    int evaluated = 0;
    rig_init(&rig, &params);
    rig.platform.trajectory = &trajectory;
    for (int n = 0; n < 20000 && (n == 0 || rig.platform.automatic); n++) {
        rig_cycle(&rig, COMMAND_NONE);
        const struct cycle *c = &rig.now;
        assert_int_equal(c->dof, DOF_NONE);
        assert_int_equal(c->test, c->phase == PHASE_NONE ? -1 : 0);
        if (c->phase != PHASE_EVALUATE) continue;
        evaluated++;
        assert_below(distance(c->pose, c->ref, DOFS), 2e-3);
    }
    assert_int_equal(evaluated, 4000);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    assert_int_equal(rig.now.faults, 0);
    plant_destroy(rig.plant);
}

static void without_the_trajectory_it_asks_for_it_stays_at_neutral(void **unused) {
    (void)unused;
    struct params params = gently();
    struct rig rig;
    int tested = 0;
    rig_init(&rig, &params);
    for (int n = 0; n < 20000 && (n == 0 || rig.platform.automatic); n++) {
        rig_cycle(&rig, COMMAND_NONE);
        if (rig.now.phase == PHASE_NONE) continue;
        tested++;
        assert_true(distance(rig.now.ref, (double[DOFS]){0}, DOFS) == 0.0);
    }
    assert_in_range(tested, 100, 20000);
    assert_int_equal(rig.now.state, STATE_SETTLED);
    plant_destroy(rig.plant);
}

/* At any instant a stop returns the platform to neutral and a park lowers it; neither jerks
 * (platform_rig.h). */
static void stop_and_park_in_the_middle_act_as_in_any_test(void **unused) {
    (void)unused;
    slow_case();
    static const int at[] = {1, 200, 320, 1000, 2100, 2330};
    struct trajectory trajectory = gentle(1);
    for (int park = 0; park <= 1; park++)
        for (size_t i = 0; i < sizeof at / sizeof *at; i++) {
            struct params params = gently();
            struct rig rig;
            params.motion.automatic = false;
            rig_init(&rig, &params);
            rig.platform.trajectory = &trajectory;
            rig_bring(&rig, STATE_TESTING, at[i]);
            rig_cycle(&rig, park ? COMMAND_PARK : COMMAND_STOP);
            rig_until(&rig, park ? STATE_SETTLED : STATE_READY);
            assert_int_equal(rig.now.faults, 0);
            if (!park) assert_true(distance(rig.now.ref, (double[DOFS]){0}, DOFS) == 0.0);
            plant_destroy(rig.plant);
        }
}

/* ---- the check before any motion ---- */

static void assert_refused(const struct params *params, const struct trajectory *t, const char *words) {
    char copy[200], *save = NULL;
    error = (struct error){0};
    if (motion_check(params, t, &error) != STATUS_USAGE) fail_msg("it should refuse: %s", words);
    snprintf(copy, sizeof copy, "%s", words);
    for (char *word = strtok_r(copy, "|", &save); word; word = strtok_r(NULL, "|", &save))
        if (!strstr(error.text, word)) fail_msg("\"%s\" is not in: %s", word, error.text);
}

static double advised(void) {
    const char *by = strstr(error.text, " by 0");
    assert_non_null(by);
    return atof(by + 4);
}

static void what_the_machine_can_do_is_let_through(void **unused) {
    (void)unused;
    struct params params;
    config_default(&params);
    if (motion_check(&params, NULL, &error)) fail_msg("%s", error.text);
    params.tests.multisine = true;
    if (motion_check(&params, NULL, &error)) fail_msg("%s", error.text);
    params = gently();
    struct trajectory t = gentle(2);
    if (motion_check(&params, &t, &error)) fail_msg("%s", error.text);
}

static void each_limit_refuses_by_its_name(void **unused) {
    (void)unused;
    slow_case();
    struct params params = brisk();
    /* at neutral a leg is 1.8307 m long; 4 mm of z are 3.6 mm of a leg */
    all_legs(params.limits.length_max_m, 1.8332);
    assert_refused(&params, NULL, "test z|leg |length 1.83|limit 1.8332 (limits.length_max_m)");
    params = brisk();
    params.limits.leg_rate_mps = 0.08;
    assert_refused(&params, NULL, "test z|rate|limit|0.08 (limits.leg_rate_mps)|scale its amplitude by 0.");
    params = brisk();
    params.limits.force_n = 600.0;
    assert_refused(&params, NULL, "force|N, limit|600 (limits.force_n)");
    params = brisk();
    for (int k = 0; k < LEGS; k++) params.hydraulics.valve_flow_m3_per_s[k] *= k == 4 ? 0.1 : 1.0;
    assert_refused(&params, NULL, "leg 5|rate|flow, by hydraulics.valve_flow_m3_per_s");
    params.tests.multisine = true;
    /* with equal frequencies the axes' shares of a leg's motion might cancel */
    for (int d = 0; d < DOFS; d++) params.tests.hz[d] = 4.0 + d;
    assert_refused(&params, NULL, "test multisine|leg 5|scale all amplitudes by 0.");
    params = brisk();
    params.limits.force_n = 100.0; /* the limit is less than the weight */
    assert_refused(&params, NULL, "force|limit|100|at rest|no smaller motion would do|payload.mass_kg|hexid doctor");
}

static void the_scale_it_gives_is_the_largest_that_does(void **unused) {
    (void)unused;
    slow_case();
    struct params params = brisk();
    params.tests.amplitude[DOF_Z] = 0.03;
    assert_refused(&params, NULL, "test z");
    double scale = advised();
    for (int more = 0; more <= 1; more++) {
        struct params scaled = params;
        for (int d = 0; d < DOFS; d++) scaled.tests.amplitude[d] *= scale + 0.01 * more;
        assert_int_equal(motion_check(&scaled, NULL, &error), more ? STATUS_USAGE : STATUS_OK);
    }
}

/* The motion rests at its ends and is far away in between, so returning within the ramp-out takes
 * more speed than the motion itself. */
static void a_stop_in_the_middle_is_checked_too(void **unused) {
    (void)unused;
    slow_case();
    struct params params = gently();
    struct trajectory t = {.knots = KNOTS, .passes = 1, .knot = knots};
    for (int i = 0; i < KNOTS; i++)
        knots[i] = (struct trajectory_knot){.time_s = 0.25 * i, .pose = {[DOF_Z] = -0.3 * pow(sin(PI * i / (KNOTS - 1)), 2)}};
    assert_true(trajectory_bend(&t));
    strcpy(params.tests.trajectory, "far.csv");
    assert_refused(&params, &t, "test trajectory at |(stopped at |scale the poses by 0.|, or raise tests.ramp_out_s");
    params.tests.ramp_out_s = 3.0;
    if (motion_check(&params, &t, &error)) fail_msg("%s", error.text);
}

/* Returns the largest speed of any leg between two cycles, for a stop of the test at any tick. */
static double fastest(const struct params *params, const struct trajectory *t, enum dof dof) {
    struct kinematics k;
    struct reference r;
    double most = 0.0;
    assert_int_equal(kinematics_init(&k, params, &error), 0);
    reference_test(&r, dof, t, &params->tests, dt_s);
    for (r.ticks = 0; r.ticks < r.ramp_out_tick; r.ticks++) {
        struct reference stopped = r;
        double length_m[3][LEGS];
        reference_stop(&stopped);
        stopped.ticks -= 2;
        for (int n = 0; stopped.mode == REFERENCE_TEST; n++) {
            struct reference_sample s = reference_step(&stopped, &params->tests, dt_s);
            memmove(length_m[0], length_m[1], 2 * sizeof length_m[0]);
            ik_lengths(&k, s.pose, length_m[2]);
            for (int leg = 0; leg < LEGS && n > 1; leg++) most = fmax(most, fabs(length_m[2][leg] - length_m[0][leg]) / (2.0 * dt_s));
        }
    }
    return most;
}

/* Asserts that a motion is accepted at the limit and refused 2 % beyond it, although the check does
 * not simulate all repetitions. */
static void assert_limited_at(struct params *params, const struct trajectory *t, enum dof dof) {
    double most = fastest(params, t, dof);
    params->limits.leg_rate_mps = 1.001 * most;
    if (motion_check(params, t, &error)) fail_msg("%s", error.text);
    params->limits.leg_rate_mps = 0.98 * most;
    assert_refused(params, t, "rate|(limits.leg_rate_mps)");
}

static void what_repeats_is_checked_as_if_all_of_it_were(void **unused) {
    (void)unused;
    slow_case();
    struct params params = gently();
    struct trajectory t = {.knots = 11, .passes = 30, .knot = knots};
    /* the passes are far shorter than the ramp-out, and go to and fro about a distant place */
    for (int i = 0; i < 11; i++)
        knots[i] = (struct trajectory_knot){.time_s = 0.01 * i, .pose = {[DOF_Z] = 0.05 + 0.5e-3 * cos(0.2 * PI * i)}};
    knots[10].pose[DOF_Z] = knots[0].pose[DOF_Z];
    assert_true(trajectory_bend(&t));
    params.tests.ramp_s = params.tests.ramp_out_s = 2.0;
    assert_limited_at(&params, &t, DOF_NONE);
    /* the periods have a few cycles, so that no period covers all phases; the end falls within a
     * period */
    for (int i = 0; i < 2; i++) {
        params = brisk();
        params.tests.order[0] = DOF_Z, params.tests.count = 1;
        params.tests.ramp_s = 0.374, params.tests.ramp_out_s = 0.5;
        params.tests.hz[DOF_Z] = i ? 2.05 : 62.0, params.tests.amplitude[DOF_Z] = i ? 0.01 : 2e-5;
        assert_limited_at(&params, NULL, DOF_Z);
    }
}

static void no_number_gets_through(void **unused) {
    (void)unused;
    struct params params = gently();
    struct trajectory t = gentle(1);
    strcpy(params.tests.trajectory, "wave.csv");
    knots[20].bend[DOF_X] = (double)NAN;
    assert_refused(&params, &t, "test trajectory|nan");
}

static int make_path(void **unused) {
    (void)unused;
    snprintf(path, sizeof path, "/tmp/hexid_trajectory_%d.csv", (int)getpid());
    return 0;
}

static int remove_path(void **unused) {
    (void)unused;
    unlink(path);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_trajectory_goes_through_its_poses),
        cmocka_unit_test(between_them_it_is_the_wave_they_are_of),
        cmocka_unit_test(pose_rate_and_acceleration_are_continuous),
        cmocka_unit_test(a_natural_end_has_no_acceleration_and_goes_straight_on),
        cmocka_unit_test(a_parabola_of_three_knots),
        cmocka_unit_test(files_of_other_programs_are_taken),
        cmocka_unit_test(whatever_else_is_refused_with_line_and_remedy),
        cmocka_unit_test(no_file_makes_a_pose_that_is_no_number),
        cmocka_unit_test(a_trajectory_is_entered_and_left_smoothly),
        cmocka_unit_test(stopped_at_any_instant_it_ramps_out_smoothly),
        cmocka_unit_test(a_multisine_is_the_sum_of_its_axes),
        cmocka_unit_test(the_platform_follows_it_as_one_test_of_no_axis),
        cmocka_unit_test(without_the_trajectory_it_asks_for_it_stays_at_neutral),
        cmocka_unit_test(stop_and_park_in_the_middle_act_as_in_any_test),
        cmocka_unit_test(what_the_machine_can_do_is_let_through),
        cmocka_unit_test(each_limit_refuses_by_its_name),
        cmocka_unit_test(the_scale_it_gives_is_the_largest_that_does),
        cmocka_unit_test(a_stop_in_the_middle_is_checked_too),
        cmocka_unit_test(what_repeats_is_checked_as_if_all_of_it_were),
        cmocka_unit_test(no_number_gets_through),
    };
    return cmocka_run_group_tests(tests, make_path, remove_path);
}
