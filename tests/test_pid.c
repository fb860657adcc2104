/* The controller's parts alone: the leg law against its formula, the reference's smoothness, the
 * supervisor's table and bucket. */
#include "support.h"

#include <limits.h>

#include "force.h"
#include "pid.h"
#include "reference.h"
#include "supervisor.h"
#include "units.h"

static const double dt_s = 0.002;

static struct params defaults(void) {
    struct params params;
    config_default(&params);
    return params;
}

static double clamped(double x, double limit) { return fmin(fmax(x, -limit), limit); }

/* ---- force ---- */

static void equal_pressures_push_with_the_rod_area(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct cylinder_areas areas = cylinder_areas(&params.actuator);
    double d = params.actuator.rod_diameter_m[0], rod_m2 = PI * d * d / 4;
    assert_close(leg_force(&areas, 0, 5e6, 5e6), 5e6 * rod_m2, 1e-8); /* tolerance: rounding of 15
                                                                       * kN */
    /* docs/method.md section 5 */
    assert_close(areas.a2_m2[0] / areas.a1_m2[0], 0.49, 0.005);
    assert_true(leg_force(&areas, 0, 1e6, 0.0) > 0.0 && leg_force(&areas, 0, 0.0, 1e6) < 0.0);
}

/* ---- pid ---- */

/* State of the header's formula, implemented again. */
struct law {
    double integral, d, flp, e_prev, ref_prev, u;
    bool saturated;
};

static double law_step(struct law *c, const struct control_params *g, double ref, double l, double f) {
    double e = ref - l, wished;
    bool outward = (c->u > 0.0 && e > 0.0) || (c->u < 0.0 && e < 0.0);
    if (!(c->saturated && outward)) c->integral = clamped(c->integral + g->ki * e * dt_s, g->integral_limit);
    c->d += dt_s / (g->tf + dt_s) * ((e - c->e_prev) / dt_s - c->d);
    c->flp += dt_s / (g->tp + dt_s) * (f - c->flp);
    wished = g->kp * e + c->integral + g->kd * c->d + g->kff * (ref - c->ref_prev) / dt_s - g->kpf * (f - c->flp);
    c->u = clamped(wished, g->output_limit);
    c->saturated = fabs(wished) > g->output_limit;
    c->e_prev = e;
    c->ref_prev = ref;
    return c->u;
}

static void pid_is_the_law_of_its_header(void **unused) {
    (void)unused;
    uint64_t seed = 1;
    int saturated = 0, free_running = 0;
    for (int run = 0; run < 200; run++) {
        struct control_params g = {.kp = 20, .ki = 50, .kd = 0.2, .kff = 1, .kpf = 1e-5, .tf = 5e-3, .tp = 0.05, .output_limit = 0.5};
        double *const gains[] = {&g.kp, &g.ki, &g.kd, &g.kff, &g.kpf, &g.tf, &g.tp, &g.output_limit};
        /* gains from zero to twice the default */
        for (int k = 0; k < 8; k++) *gains[k] *= 1 + random_unit(&seed);
        g.integral_limit = 0.3;
        double length = 1.8 + 0.2 * random_unit(&seed), force = 5e3 * random_unit(&seed), span = run % 2 ? 0.002 : 0.02;
        struct pid pid;
        struct law law = {.flp = force, .ref_prev = length};
        pid_reset(&pid, length, force);
        for (int n = 0; n < 500; n++) {
            double ref = length + span * sin(0.05 * n) + span * 0.1 * random_unit(&seed), at = length + 0.5 * span * random_unit(&seed);
            double f = force + 500 * random_unit(&seed);
            double u = pid_step(&pid, &g, dt_s, ref, at, f);
            /* tolerance: the same sums in another order, with rounding of e / dt times kd and kff,
             * 1 / dt = 500 */
            assert_close(u, law_step(&law, &g, ref, at, f), 1e-11);
            assert_true(fabs(u) <= g.output_limit);
            *(law.saturated ? &saturated : &free_running) += 1;
        }
    }
    assert_true(saturated > 1000 && free_running > 1000); /* both branches were exercised */
}

/* Returns the largest overshoot, after a step of 0.3 m, of a leg that moves with the valve at 0.5
 * m/s at full opening. */
static double overshoot(bool anti_windup) {
    struct params params = defaults();
    struct pid pid;
    double length = 1.5, largest = 0.0, goal = 1.8;
    pid_reset(&pid, length, 0.0);
    for (int n = 0; n < 5000; n++) {
        if (!anti_windup)
            pid.saturated = false; /* without anti-windup, only the integral's clamp
                                                  * remains */
        length += 0.5 * dt_s * pid_step(&pid, &params.control, dt_s, goal, length, 0.0);
        largest = fmax(largest, length - goal);
    }
    assert_close(length, goal, 1e-4);
    return largest;
}

static void the_integral_does_not_wind_up_while_the_valve_is_wide_open(void **unused) {
    (void)unused;
    double with = overshoot(true), without = overshoot(false);
    print_message("# overshoot of a 0.3 m jump: %.2f mm, with the clamp alone %.2f mm\n", 1e3 * with, 1e3 * without);
    assert_below(with, 0.5 * without);
    struct params params = defaults();
    struct pid pid;
    pid_reset(&pid, 1.5, 0.0);
    pid_step(&pid, &params.control, dt_s, 1.8, 1.5, 0.0);
    double once = pid.integral;
    for (int n = 0; n < 1000; n++) pid_step(&pid, &params.control, dt_s, 1.8, 1.5, 0.0);
    assert_true(pid.saturated && pid.integral == once); /* one step was integrated before saturation
                                                         * was known */
    pid_step(&pid, &params.control, dt_s, 1.8, 1.81, 0.0);
    assert_true(pid.integral < once); /* the integral decreases at once */
}

static void pid_reset_is_bumpless_whatever_came_before(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct pid pid;
    uint64_t seed = 2;
    memset(&pid, 0, sizeof pid);
    for (int run = 0; run < 100; run++) {
        for (int n = 0; n < 20; n++) pid_step(&pid, &params.control, dt_s, 1.8, 1.8 + 0.1 * random_unit(&seed), 1e4 * random_unit(&seed));
        double length = 1.8 + 0.4 * random_unit(&seed), force = 1e4 * random_unit(&seed);
        pid_reset(&pid, length, force);
        assert_true(pid_step(&pid, &params.control, dt_s, length, length, force) == 0.0);
    }
}

static void a_static_force_does_not_open_the_valve(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct pid pid;
    double u = 0.0;
    pid_reset(&pid, 1.8, 0.0);
    u = pid_step(&pid, &params.control, dt_s, 1.8, 1.8, 5000.0);
    /* the command acts against the force at once */
    assert_close(u, -params.control.kpf * 5000.0 / (1.0 + dt_s / params.control.tp), 1e-12);
    for (int n = 0; n < (int)(params.control.tp / dt_s) * 40; n++) u = pid_step(&pid, &params.control, dt_s, 1.8, 1.8, 5000.0);
    /* after 40 time constants only e^-39 and the filter's rounding are left */
    assert_below(fabs(u), params.control.kpf * 5000.0 * 1e-14);
}

static void held_cycles_do_not_add_up_in_the_feedforward(void **unused) {
    (void)unused;
    struct params params = defaults();
    struct pid pid;
    double rate_mps = 0.1, ref = 1.8, u = 0.0;
    pid_reset(&pid, ref, 0.0);
    for (int n = 0; n < 100; n++) {
        ref += rate_mps * dt_s;
        if (n % 10 < 4) pid_hold(&pid, ref);
        else u = pid_step(&pid, &params.control, dt_s, ref, ref, 0.0);
        if (n > 3) assert_close(u, params.control.kff * rate_mps, 1e-12);
    }
}

/* ---- reference ---- */

/* Watches a trajectory for steps in position or rate. */
struct watch {
    int seen;
    double last[DOFS], rate[DOFS];
    double largest_acceleration;
};

static void watch(struct watch *w, const double pose[DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        double rate = (pose[i] - w->last[i]) / dt_s;
        if (w->seen > 1) w->largest_acceleration = fmax(w->largest_acceleration, fabs(rate - w->rate[i]) / dt_s);
        if (isnan(pose[i])) w->largest_acceleration = (double)INFINITY;
        w->last[i] = pose[i];
        w->rate[i] = rate;
    }
    w->seen++;
}

/* Returns a bound of (amplitude x envelopes x sine)'': the product rule with |s'| <= 1.5/T and
 * |s''| <= 6/T^2, and half a percent for the finite step. */
static double largest_test_acceleration(const struct test_params *t, enum dof dof) {
    double amplitude = t->amplitude[dof], w = 2 * PI * t->hz[dof], a = t->ramp_s, b = t->ramp_out_s;
    return 1.005 * amplitude * (w * w + 2 * w * 1.5 * (1 / a + 1 / b) + 6 / (a * a) + 6 / (b * b) + 2 * 1.5 * 1.5 / (a * b));
}

static void the_reference_of_a_test_is_its_formula_at_whole_cycles(void **unused) {
    (void)unused;
    struct test_params t = defaults().tests;
    /* each axis has its own frequency and amplitude */
    for (int dof = 0; dof < DOFS; dof++) t.hz[dof] -= 0.3 * dof, t.amplitude[dof] *= 1.0 - 0.1 * dof;
    for (int dof = 0; dof < DOFS; dof++) {
        struct reference r;
        int count[PHASE_RAMP_OUT + 1] = {0};
        struct watch w = {0};
        t.settle_s = 0.3, t.ramp_s = 0.5, t.duration_s = 0.75, t.ramp_out_s = 0.25;
        reference_test(&r, (enum dof)dof, NULL, &t, dt_s);
        for (int tick = -150;; tick++) {
            struct reference_sample s = reference_step(&r, &t, dt_s);
            double time = tick * dt_s, q = fmin(fmax(time / 0.5, 0.0), 1.0), p = fmin(fmax((time - 1.25) / 0.25, 0.0), 1.0);
            double envelope = q * q * (3 - 2 * q) * (1 - p * p * (3 - 2 * p));
            assert_true(s.test_time_s == tick * dt_s); /* the time is exact, without accumulated
                                                        * rounding */
            for (int i = 0; i < DOFS; i++)
                assert_close(s.pose[i], i == dof ? t.amplitude[dof] * envelope * sin(2 * PI * t.hz[dof] * time) : 0.0, 1e-16);
            watch(&w, s.pose);
            count[s.phase]++;
            assert_true(s.done == (tick == 750));
            if (s.done) break;
        }
        for (int n = 0; n < 5; n++) {
            struct reference_sample s = reference_step(&r, &t, dt_s);
            assert_true(s.done && s.phase == PHASE_NONE && s.test_time_s == 0.0);
            watch(&w, s.pose);
        }
        assert_int_equal(count[PHASE_SETTLE], 150);
        assert_int_equal(count[PHASE_RAMP_IN], 250);
        assert_int_equal(count[PHASE_EVALUATE], 375);
        assert_int_equal(count[PHASE_RAMP_OUT], 126); /* the last sample is at rest at neutral */
        assert_below(w.largest_acceleration, largest_test_acceleration(&t, (enum dof)dof));
    }
}

static void durations_that_are_no_whole_cycles_are_rounded_to_one(void **unused) {
    (void)unused;
    struct test_params t = defaults().tests;
    struct reference r;
    int count[PHASE_RAMP_OUT + 1] = {0};
    t.settle_s = 0.0109, t.ramp_s = 0.0111, t.duration_s = 0.5000001, t.ramp_out_s = 0.1;
    reference_test(&r, DOF_X, NULL, &t, dt_s);
    for (bool done = false; !done;) {
        struct reference_sample s = reference_step(&r, &t, dt_s);
        count[s.phase]++;
        done = s.done;
    }
    assert_int_equal(count[PHASE_SETTLE], 5);
    assert_int_equal(count[PHASE_RAMP_IN], 6);
    assert_int_equal(count[PHASE_EVALUATE], 250);
    assert_int_equal(count[PHASE_RAMP_OUT], 51);
}

/* A run has such a test if a trajectory was named but is missing. */
static void a_test_of_no_axis_no_multisine_and_no_trajectory_stays_at_neutral(void **unused) {
    (void)unused;
    struct test_params t = defaults().tests;
    struct reference r;
    t.multisine = false;
    reference_test(&r, DOF_NONE, NULL, &t, dt_s);
    for (bool done = false; !done;) {
        struct reference_sample s = reference_step(&r, &t, dt_s);
        for (int i = 0; i < DOFS; i++) assert_true(s.pose[i] == 0.0);
        done = s.done;
    }
}

static void a_test_stopped_at_any_instant_ramps_out_smoothly(void **unused) {
    (void)unused;
    struct test_params t = defaults().tests;
    t.settle_s = 0.1, t.ramp_s = 0.3, t.duration_s = 0.5, t.ramp_out_s = 0.2;
    int whole = 50 + 150 + 250 + 100, out = 100;
    double limit = largest_test_acceleration(&t, DOF_Z);
    for (int stop = 0; stop <= whole; stop++) {
        struct reference r;
        struct watch w = {0};
        int left = 0;
        reference_test(&r, DOF_Z, NULL, &t, dt_s);
        for (int n = 0;; n++) {
            if (n == stop) reference_stop(&r), left = out + 1;
            if (n == stop + 10)
                reference_stop(&r); /* a second stop does not start the ramp-out
                                                     * again */
            struct reference_sample s = reference_step(&r, &t, dt_s);
            watch(&w, s.pose);
            if (n >= stop) assert_int_equal(s.phase, PHASE_RAMP_OUT);
            if (s.done) break;
            assert_true(n < stop || --left > 0);
        }
        for (int n = 0; n < 3; n++) watch(&w, reference_step(&r, &t, dt_s).pose);
        assert_true(w.last[DOF_Z] == 0.0);
        assert_below(w.largest_acceleration, limit);
    }
}

static double weighed(const double v[DOFS], double arm_m) {
    double square = 0.0;
    for (int i = 0; i < DOFS; i++) square += v[i] * v[i] * (i < DOF_PHI ? 1.0 : arm_m * arm_m);
    return sqrt(square);
}

/* A move from any pose, rate and acceleration is continuous in acceleration, keeps its limits or
 * its initial values, takes no longer than these require, and ends exactly at the target at rest.
 * Rates and accelerations are differences of the poses. */
static void a_move_from_any_motion_keeps_its_limits_and_ends_at_rest(void **unused) {
    (void)unused;
    struct test_params t = defaults().tests;
    uint64_t seed = 3;
    for (int run = 0; run < 2000; run++) {
        double from[DOFS], rate[DOFS], accel[DOFS], to[DOFS], last[DOFS], before[DOFS], shift[DOFS], arm_m = 0.56;
        for (int i = 0; i < DOFS; i++) {
            from[i] = 0.3 * random_unit(&seed), to[i] = 0.3 * random_unit(&seed);
            rate[i] = run % 3 ? 0.2 * random_unit(&seed) : 0.0, accel[i] = run % 3 > 1 ? 0.3 * random_unit(&seed) : 0.0;
            last[i] = from[i], before[i] = from[i] - dt_s * rate[i] + dt_s * dt_s / 2 * accel[i];
        }
        struct move_limits l = {3.0 * fmax(0.0, random_unit(&seed)), 0.05 + 0.5 * fabs(random_unit(&seed)), 0.1 + fabs(random_unit(&seed)),
                                arm_m};
        double v0 = weighed(rate, arm_m), a0 = weighed(accel, arm_m), most = fmax(l.accel_mps2, a0);
        double brake_s = v0 + a0 > 0.0 ? fmax(0.25, 3 * v0 / (most - a0 + sqrt(most * most + most * a0))) : 0.0;
        struct reference r;
        int cycles = 0;
        reference_move(&r, &(struct move_start){from, rate, accel}, to, &l);
        double accel_before[DOFS];
        memcpy(accel_before, accel, sizeof accel_before);
        for (bool done = false; !done; cycles++) {
            struct reference_sample s = reference_step(&r, &t, dt_s);
            double v[DOFS], a[DOFS], jerk[DOFS];
            for (int i = 0; i < DOFS; i++) {
                v[i] = (s.pose[i] - last[i]) / dt_s, a[i] = (s.pose[i] - 2 * last[i] + before[i]) / (dt_s * dt_s);
                jerk[i] = a[i] - accel_before[i], accel_before[i] = a[i];
            }
            assert_true(s.phase == PHASE_NONE);
            assert_below(weighed(v, arm_m), fmax(l.rate_mps, v0 + 4.0 / 27.0 * a0 * brake_s) * (1 + 1e-9) + 1e-9);
            assert_below(weighed(a, arm_m), most * (1 + 1e-6) + 1e-6);
            /* the acceleration has no step: it changes by at most the polynomials' third derivative
             * times a cycle, plus as much for the cycle before */
            double travel_s = r.mode == REFERENCE_MOVE ? r.travel_s : l.duration_s;
            double third = fmax(60 * 1.3 / pow(fmax(travel_s, 0.2), 3), (4 * a0 + 6 * v0 / fmax(brake_s, 0.25)) / fmax(brake_s, 0.25));
            if (!s.done) assert_below(weighed(jerk, arm_m), 2.0 * third * dt_s + 1e-6);
            memcpy(before, last, sizeof before);
            memcpy(last, s.pose, sizeof last);
            done = s.done;
        }
        for (int i = 0; i < DOFS; i++) shift[i] = to[i] - from[i] - brake_s * (rate[i] / 2 + brake_s * accel[i] / 12);
        double distance = weighed(shift, arm_m),
               limited_s = fmax(15.0 / 8 * distance / l.rate_mps, sqrt(10 / sqrt(3.0) * distance / l.accel_mps2));
        assert_int_equal(cycles, (int)ceil((brake_s + fmax(limited_s, l.duration_s - brake_s)) / dt_s - 1e-9));
        assert_memory_equal(last, to, sizeof to);
        for (int n = 0; n < 3; n++) assert_memory_equal(reference_step(&r, &t, dt_s).pose, to, sizeof to);
    }
}

static void a_move_that_is_turned_round_overshoots_by_its_brake_alone(void **unused) {
    (void)unused;
    struct test_params t = defaults().tests;
    const double rate[DOFS] = {[DOF_Z] = -0.5}, rest[DOFS] = {0}, to[DOFS] = {[DOF_Z] = 0.45};
    struct move_limits l = {600.0, 0.55, 1.1, 0.56};
    struct reference r;
    double least = 0.0;
    reference_move(&r, &(struct move_start){rest, rate, rest}, to, &l);
    for (bool done = false; !done;) {
        struct reference_sample s = reference_step(&r, &t, dt_s);
        least = fmin(least, s.pose[DOF_Z]);
        done = s.done;
    }
    double brake_s = 1.5 * 0.5 / 1.1;
    assert_close(least, -0.5 * brake_s / 2, 1e-6);
}

static void a_hold_holds(void **unused) {
    (void)unused;
    struct test_params t = defaults().tests;
    struct reference r;
    const double pose[DOFS] = {1, 2, 3, 4, 5, 6};
    reference_hold(&r, pose);
    reference_stop(&r);
    for (int n = 0; n < 10; n++) {
        struct reference_sample s = reference_step(&r, &t, dt_s);
        assert_memory_equal(s.pose, pose, sizeof pose);
        assert_true(s.done && s.phase == PHASE_NONE);
    }
}

/* ---- supervisor ---- */

enum { TRIGGERS = TRIGGER_FAULT + 1 };

static enum state supervisor_next(enum state state, enum trigger trigger) {
    const struct transition *row = supervisor_find(state, trigger);
    return row ? row->to : state;
}

static void every_state_and_trigger_leads_where_the_matrix_says(void **unused) {
    (void)unused;
    static const char letter[STATES + 1] = "iserTpFP"; /* initials of state_names, in order */
    static const char *const expected[STATES] = {
        /* columns: none, good sensors, engage, pressure, arrived, start, tests done, stop, park,
         * reset, fault */
        [STATE_INIT] = "isiiiiiiiiF",  [STATE_SETTLED] = "ssPsssssssF",      [STATE_ENGAGING] = "eeeereeppeF",
        [STATE_READY] = "rrrrrTrrprF", [STATE_TESTING] = "TTTTTTrTpTF",      [STATE_PARKING] = "ppppspppppF",
        [STATE_FAULT] = "FFFFFFFFFiF", [STATE_PRESSURISING] = "PPPePPPssPF",
    };
    for (int s = 0; s < STATES; s++)
        for (int t = 0; t < TRIGGERS; t++) {
            enum state next = supervisor_next((enum state)s, (enum trigger)t);
            if (letter[next] != expected[s][t]) fail_msg("state %s, trigger %d: %s", state_names[s], t, state_names[next]);
        }
}

static void a_stop_or_park_in_testing_is_a_row_that_ramps_out_and_no_other_row_does(void **unused) {
    (void)unused;
    for (int s = 0; s < STATES; s++)
        for (int t = 0; t < TRIGGERS; t++) {
            const struct transition *row = supervisor_find((enum state)s, (enum trigger)t);
            bool ramps = s == STATE_TESTING && (t == TRIGGER_STOP || t == TRIGGER_PARK);
            if (ramps) assert_non_null(row);
            if (!row) continue;
            assert_true(row->from == (enum state)s && row->trigger == (enum trigger)t);
            assert_int_equal(row->ramp_out, ramps);
            assert_int_equal(row->to == row->from, s == STATE_TESTING && t == TRIGGER_STOP);
        }
}

/* True if a driven state can be reached from `from` without this trigger. */
static bool drives_without(enum state from, enum trigger missing) {
    bool reached[STATES] = {false};
    reached[from] = true;
    for (int round = 0; round < STATES; round++)
        for (int s = 0; s < STATES; s++)
            for (int t = 0; reached[s] && t < TRIGGERS; t++)
                if (t != (int)missing) reached[supervisor_next((enum state)s, (enum trigger)t)] = true;
    for (int s = 0; s < STATES; s++)
        if (reached[s] && supervisor_drives((enum state)s)) return true;
    return false;
}

static void nothing_moves_before_reset_good_sensors_and_engage(void **unused) {
    (void)unused;
    assert_false(drives_without(STATE_FAULT, TRIGGER_RESET));
    assert_false(drives_without(STATE_FAULT, TRIGGER_SENSORS_GOOD));
    assert_false(drives_without(STATE_FAULT, TRIGGER_ENGAGE));
    assert_false(drives_without(STATE_INIT, TRIGGER_SENSORS_GOOD));
    assert_false(drives_without(STATE_INIT, TRIGGER_ENGAGE));
    assert_false(drives_without(STATE_SETTLED, TRIGGER_ENGAGE));
    assert_true(drives_without(STATE_FAULT, TRIGGER_NONE)); /* the search finds a way if no trigger
                                                             * is missing */
    for (int s = 0; s < STATES; s++) {
        bool driven = s == STATE_ENGAGING || s == STATE_READY || s == STATE_TESTING || s == STATE_PARKING;
        assert_int_equal(supervisor_drives((enum state)s), driven);
    }
}

static void the_bucket_rides_out_fewer_than_limit_bad_samples(void **unused) {
    (void)unused;
    for (int limit = 1; limit < 20; limit++) {
        struct supervisor s = {0};
        for (int n = 1; n < limit; n++) assert_false(supervisor_judge(&s, FAULT_STROKE, limit));
        assert_int_equal(s.faults, 0);
        assert_true(supervisor_judge(&s, FAULT_STROKE, limit));
        assert_int_equal(s.faults, FAULT_STROKE);
    }
    struct supervisor s = {0};
    for (int n = 0; n < 1000; n++) {
        assert_false(supervisor_judge(&s, FAULT_IO, 2)); /* every second sample is bad, without an
                                                          * end */
        assert_false(supervisor_judge(&s, 0, 2));
    }
    assert_int_equal(s.faults, 0);
}

static void faults_stay_and_the_first_is_the_headline(void **unused) {
    (void)unused;
    struct supervisor s = {0};
    supervisor_judge(&s, FAULT_IO, 1);
    supervisor_judge(&s, FAULT_STROKE, 1);
    for (int n = 0; n < 100; n++) assert_false(supervisor_judge(&s, 0, 1));
    assert_int_equal(s.faults, FAULT_IO | FAULT_STROKE);
    assert_string_equal(fault_name(s.first_fault), "io");
    supervisor_clear(&s);
    assert_int_equal(s.faults | s.first_fault, 0);
    assert_string_equal(fault_name(s.first_fault), "none");
    supervisor_judge(&s, FAULT_FOLLOWING | FAULT_LEG_RATE, 1);
    assert_string_equal(fault_name(s.first_fault), "leg_rate"); /* only one of the two faults is the
                                                                 * headline */
    supervisor_clear(&s);
    supervisor_judge(&s, FAULT_MASTER | FAULT_SENSOR_INVALID | FAULT_STROKE | fault_leg(2), 1);
    assert_string_equal(fault_name(s.first_fault), "second_master"); /* this fault is the cause of
                                                                      * the others */
}

static void counters_do_not_overflow_in_months(void **unused) {
    (void)unused;
    struct supervisor s = {.good = INT_MAX};
    supervisor_judge(&s, 0, 5);
    assert_int_equal(s.good, INT_MAX);
    for (int n = 0; n < 100; n++) supervisor_judge(&s, FAULT_IO, 5);
    assert_int_equal(s.bad, 5);
    assert_int_equal(s.good, 0);
}

static void every_fault_has_a_cause_and_a_remedy(void **unused) {
    (void)unused;
    char cause[FAILURE_TEXT_SIZE], remedy[FAILURE_TEXT_SIZE];
    uint32_t seen = 0;
    for (int i = 0; failure_table[i].fault; i++) {
        const struct failure *f = &failure_table[i];
        assert_true(f->fault && !(f->fault & (f->fault - 1)) && !(seen & f->fault));
        seen |= f->fault;
        assert_true(f->what && f->detected && f->within && f->platform && f->cause && f->remedy);
        failure_explain(f->fault, 12, 0.0242, false, cause, remedy);
        assert_non_null(strstr(cause, f->cause));
        assert_non_null(strstr(remedy, f->remedy));
        assert_non_null(strstr(remedy, "reset"));
        /* no text is cut */
        assert_true(strlen(cause) < FAILURE_TEXT_SIZE - 1 && strlen(remedy) < FAILURE_TEXT_SIZE - 1);
        if (f->fault == FAULT_OVERRUN) assert_non_null(strstr(cause, "12 deadlines missed in a row, the longest by 24 ms"));
        failure_explain(f->fault, 1, 0.004, true, cause, remedy);
        assert_non_null(strstr(remedy, "start the run again")); /* the remedy of an automatic run,
                                                                 * which has ended */
    }
}

static void every_fault_state_and_command_has_a_name(void **unused) {
    (void)unused;
    static const char *const names[] = {"sensor_age",    "sensor_invalid", "stroke", "leg_rate",       "following_error", "force",
                                        "kinematics",    "overrun",        "io",     "standstill",     "second_master",   "emergency_stop",
                                        "enable_switch", "door",           "supply", "pressure_sensor"};
    for (unsigned i = 0; i < FAULT_LEG_SHIFT; i++) assert_string_equal(fault_name(1u << i), names[i]);
    for (int i = 0; i < STATES; i++) assert_non_null(state_names[i]);
    for (int i = 0; i < COMMANDS; i++) assert_non_null(command_names[i]);
    assert_string_equal(state_names[STATE_FAULT], "fault");
    assert_string_equal(command_names[COMMAND_RESET], "reset");
}

/* A step after a change of the gains has the output that the old gains would have given, at rest
 * with any reading; then the new gains act. */
static void gains_change_without_a_bump(void **unused) {
    (void)unused;
    struct control_params from, to;
    uint64_t seed = 4;
    struct params p;
    config_default(&p);
    from = to = p.control;
    from.kd = 0.3, to.kd = 0.2, to.kp = 60.0, to.ki = 11.0, to.kpf = 1.1e-5;
    for (int n = 0; n < 200; n++) {
        struct pid old, changed;
        struct pid_reading r = {1.8, 3000.0, 0.0};
        pid_reset(&old, 1.8, 2000.0);
        for (int i = 0; i < 50; i++) pid_step(&old, &from, dt_s, 1.8, 1.8 + 1e-4 * random_unit(&seed), 2500.0 + 300.0 * random_unit(&seed));
        old.feedback_cut = n % 2 ? 0.4 : 0.0;
        r.length_m += 1e-4 * random_unit(&seed), r.force_n += 300.0 * random_unit(&seed);
        changed = old;
        assert_true(pid_change(&changed, &from, &to, dt_s, &r));
        assert_close(pid_step(&changed, &to, dt_s, 1.8, r.length_m, r.force_n), pid_step(&old, &from, dt_s, 1.8, r.length_m, r.force_n),
                     1e-12);
    }
}

/* A change of gains for which the integral would leave its limits is refused. */
static void no_room_in_the_integral_no_change(void **unused) {
    (void)unused;
    struct params p;
    config_default(&p);
    struct control_params to = p.control;
    struct pid c, before;
    to.kp = 20.0;
    pid_reset(&c, 1.8, 0.0);
    c.ref_m = 1.82; /* 20 mm off: the integral would have to hold 0.4 */
    before = c;
    assert_false(pid_change(&c, &p.control, &to, 0.002, &(struct pid_reading){.length_m = 1.8}));
    assert_memory_equal(&c, &before, sizeof c);
    assert_false(pid_change(&c, &p.control, &to, 0.002, &(struct pid_reading){.length_m = (double)NAN}));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gains_change_without_a_bump),
        cmocka_unit_test(no_room_in_the_integral_no_change),
        cmocka_unit_test(equal_pressures_push_with_the_rod_area),
        cmocka_unit_test(pid_is_the_law_of_its_header),
        cmocka_unit_test(the_integral_does_not_wind_up_while_the_valve_is_wide_open),
        cmocka_unit_test(pid_reset_is_bumpless_whatever_came_before),
        cmocka_unit_test(a_static_force_does_not_open_the_valve),
        cmocka_unit_test(held_cycles_do_not_add_up_in_the_feedforward),
        cmocka_unit_test(the_reference_of_a_test_is_its_formula_at_whole_cycles),
        cmocka_unit_test(durations_that_are_no_whole_cycles_are_rounded_to_one),
        cmocka_unit_test(a_test_of_no_axis_no_multisine_and_no_trajectory_stays_at_neutral),
        cmocka_unit_test(a_test_stopped_at_any_instant_ramps_out_smoothly),
        cmocka_unit_test(a_move_from_any_motion_keeps_its_limits_and_ends_at_rest),
        cmocka_unit_test(a_move_that_is_turned_round_overshoots_by_its_brake_alone),
        cmocka_unit_test(a_hold_holds),
        cmocka_unit_test(every_state_and_trigger_leads_where_the_matrix_says),
        cmocka_unit_test(a_stop_or_park_in_testing_is_a_row_that_ramps_out_and_no_other_row_does),
        cmocka_unit_test(nothing_moves_before_reset_good_sensors_and_engage),
        cmocka_unit_test(the_bucket_rides_out_fewer_than_limit_bad_samples),
        cmocka_unit_test(faults_stay_and_the_first_is_the_headline),
        cmocka_unit_test(counters_do_not_overflow_in_months),
        cmocka_unit_test(every_fault_state_and_command_has_a_name),
        cmocka_unit_test(every_fault_has_a_cause_and_a_remedy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
