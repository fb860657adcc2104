/* Geometry, valve, chambers and end stops against the equations of cylinder.h and against the
 * physical limits of a hydraulic cylinder. */
#include "support.h"

#include "cylinder.h"
#include "engine.h"
#include "hydraulics.h"
#include "units.h"

static const double MID_M = 1.8310;
static const double SUBSTEP_S = 2.5e-4;
static const double VACUUM_PA = -101325.0;

static struct params params;
static struct cylinder_model model;

static int defaults(void **unused) {
    (void)unused;
    config_default(&params);
    cylinder_model_init(&model, &params);
    return 0;
}

static double volume1(double length_m) {
    return params.hydraulics.dead_volume_m3[0] + model.leg[0].a1_m2 * (length_m - model.leg[0].length_min_m);
}
static double volume2(double length_m) {
    return params.hydraulics.dead_volume_m3[0] + model.leg[0].a2_m2 * (model.leg[0].length_max_m - length_m);
}

/* Returns the flow into a chamber that its pressure rate means. */
static double flow(double pressure_rate, double volume_m3) { return pressure_rate * volume_m3 / params.hydraulics.bulk_modulus_pa[0]; }

static struct cylinder_state derivative(const struct cylinder_state *s, double length_m, double rate_mps, double valve) {
    struct mains mains = cylinder_mains(&model);
    return cylinder_derivative(&model, 0, &mains, s, s->spool, length_m, rate_mps, valve);
}

static struct cylinder_state combine(const struct cylinder_state *s, double h, const struct cylinder_state *rate) {
    return (struct cylinder_state){s->p1_pa + h * rate->p1_pa, s->p2_pa + h * rate->p2_pa, s->spool + h * rate->spool,
                                   s->spool_rate + h * rate->spool_rate, s->deflection + h * rate->deflection};
}

/* Makes a step with constant input. */
static void step(struct cylinder_state *s, double h, double length_m, double rate_mps, double valve) {
    const struct cylinder_input in = {length_m, rate_mps, valve};
    cylinder_step(&model, 0, h, (struct cylinder_input[]){in, in, in}, s);
}

static void every_neutral_leg_has_the_same_length(void **unused) {
    (void)unused;
    struct sim_geometry g;
    sim_geometry_init(&g, &params);
    for (int k = 0; k < LEGS; k++) {
        double x = g.upper[k][0] - g.lower[k][0], y = g.upper[k][1] - g.lower[k][1], z = g.upper[k][2] - g.lower[k][2];
        assert_close(sqrt(x * x + y * y + z * z), g.neutral_length_m[0], 1e-14);
        assert_true(z < 0.0); /* z points down, and the platform is above the base */
    }
    assert_close(g.neutral_length_m[0], MID_M, 5e-5); /* the value that docs/method.md, section 1,
                                                       * prints */
}

static void joints_lie_at_the_angles_of_the_paper(void **unused) {
    (void)unused;
    struct sim_geometry g;
    sim_geometry_init(&g, &params);
    double a = params.geometry.upper_half_angle_rad, b = params.geometry.lower_half_angle_rad, third = 2 * PI / 3;
    double upper[LEGS] = {-a, a, third - a, third + a, 2 * third - a, 2 * third + a};
    double lower[LEGS] = {-PI / 3 + b, PI / 3 - b, PI / 3 + b, PI - b, PI + b, 5 * PI / 3 - b};
    for (int k = 0; k < LEGS; k++) {
        const double upper_axis[3] = {-sin(upper[k]), cos(upper[k]), 0.0}, lower_axis[3] = {-sin(lower[k]), cos(lower[k]), 0.0};
        assert_close(g.upper[k][0], params.geometry.upper_radius_m * cos(upper[k]), 1e-14);
        assert_close(g.upper[k][1], params.geometry.upper_radius_m * sin(upper[k]), 1e-14);
        assert_close(g.lower[k][0], params.geometry.lower_radius_m * cos(lower[k]), 1e-14);
        assert_close(g.lower[k][1], params.geometry.lower_radius_m * sin(lower[k]), 1e-14);
        assert_below(distance(g.upper_axis[k], upper_axis, 3), 1e-14);
        assert_below(distance(g.lower_axis[k], lower_axis, 3), 1e-14);
    }
}

static void neutral_is_at_mid_stroke(void **unused) {
    (void)unused;
    struct sim_geometry g;
    sim_geometry_init(&g, &params);
    assert_close(0.5 * (model.leg[0].length_min_m + model.leg[0].length_max_m), g.neutral_length_m[0], 1e-14);
    assert_close(model.leg[0].length_max_m - model.leg[0].length_min_m, params.actuator.stroke_m[0], 1e-14);
}

static void rated_drop_gives_rated_flow_either_way(void **unused) {
    (void)unused;
    const struct hydraulics_params *h = &params.hydraulics;
    /* the pressure drops are 5 MPa from the supply and 5 MPa to the tank; equal pressures cause no
     * leakage */
    double half = h->supply_pa - h->valve_drop_pa;
    assert_close(half - h->tank_pa, h->valve_drop_pa, 1e-9);
    for (int sign = -1; sign <= 1; sign += 2) {
        struct cylinder_state s = {.p1_pa = half, .p2_pa = half, .spool = sign};
        struct cylinder_state rate = derivative(&s, MID_M, 0.0, sign);
        assert_close(flow(rate.p1_pa, volume1(MID_M)), sign * h->valve_flow_m3_per_s[0], 1e-15);
        assert_close(flow(rate.p2_pa, volume2(MID_M)), -sign * h->valve_flow_m3_per_s[0], 1e-15);
    }
}

static void flow_follows_the_root_exactly_down_to_10_kpa(void **unused) {
    (void)unused;
    const struct hydraulics_params *h = &params.hydraulics;
    for (double drop = 1.0001e4; drop < 9e6; drop *= 1.7) {
        struct cylinder_state s = {.p1_pa = h->supply_pa - drop, .p2_pa = h->supply_pa - drop, .spool = 0.1};
        double q = flow(derivative(&s, MID_M, 0.0, 0.1).p1_pa, volume1(MID_M));
        /* tolerance: rounding of supply - drop */
        assert_close(q / (0.1 * h->valve_flow_m3_per_s[0] * sqrt(drop / h->valve_drop_pa)), 1.0, 1e-9);
    }
}

static void flow_through_zero_drop_is_odd_monotonic_and_smooth(void **unused) {
    (void)unused;
    const double supply = params.hydraulics.supply_pa, step = 10.0;
    double last = 0.0, last_slope = 0.0;
    for (double drop = -3e4; drop < 3e4; drop += step) {
        struct cylinder_state s = {.p1_pa = supply - drop, .p2_pa = supply - drop, .spool = 0.1};
        struct cylinder_state mirror = {.p1_pa = supply + drop, .p2_pa = supply + drop, .spool = 0.1};
        double q = derivative(&s, MID_M, 0.0, 0.1).p1_pa;
        assert_close(q + derivative(&mirror, MID_M, 0.0, 0.1).p1_pa, 0.0, 1e-9 * 1e8);
        double slope = (q - last) / step;
        if (drop > -3e4) assert_true(slope > 0.0);
        /* tolerance: a step is 1e-3 of the laminar limit, and the curvature is below 3 */
        if (drop > -3e4 + 2 * step) assert_close(slope / last_slope, 1.0, 5e-3);
        last = q, last_slope = slope;
    }
}

static void a_closed_chamber_keeps_its_oil(void **unused) {
    (void)unused;
    uint64_t seed = 1;
    for (int n = 0; n < 1000; n++) {
        double length = MID_M + 0.4 * random_unit(&seed), speed = random_unit(&seed);
        struct cylinder_state s = {.p1_pa = 5e6, .p2_pa = 5e6};
        struct cylinder_state rate = derivative(&s, length, speed, 0.0);
        assert_close(flow(rate.p1_pa, volume1(length)), -model.leg[0].a1_m2 * speed, 1e-15);
        assert_close(flow(rate.p2_pa, volume2(length)), model.leg[0].a2_m2 * speed, 1e-15);
    }
}

static void leakage_takes_from_one_chamber_what_it_gives_the_other(void **unused) {
    (void)unused;
    struct cylinder_state s = {.p1_pa = 7e6, .p2_pa = 4e6};
    struct cylinder_state rate = derivative(&s, MID_M, 0.0, 0.0);
    double leakage = params.hydraulics.leakage_m3_per_s_pa[0] * 3e6;
    assert_close(flow(rate.p1_pa, volume1(MID_M)), -leakage, 1e-15);
    assert_close(flow(rate.p2_pa, volume2(MID_M)), leakage, 1e-15);
}

static void spool_steps_like_a_second_order_system(void **unused) {
    (void)unused;
    double w = 2 * PI * params.hydraulics.valve_frequency_hz, z = params.hydraulics.valve_damping[0], wd = w * sqrt(1 - z * z);
    struct cylinder_state s = {.p1_pa = 5e6, .p2_pa = 5e6};
    for (int i = 1; i <= 80; i++) {
        double t = i * SUBSTEP_S;
        step(&s, SUBSTEP_S, MID_M, 0.0, 0.5);
        double exact = 0.5 * (1 - exp(-z * w * t) * (cos(wd * t) + z * w / wd * sin(wd * t)));
        /* tolerance: RK4 has (w h)^5/120 per step, at about 10 steps per time constant */
        assert_close(s.spool, exact, 2e-5);
    }
}

/* Draws any state and input; seals are on. */
static void a_step_is_runge_kuttas_of_the_derivative(void **unused) {
    (void)unused;
    uint64_t seed = 5;
    model.leg[0].seal_distance_m = 1e-4;
    for (int n = 0; n < 1000; n++) {
        struct cylinder_state s = {5e6 + 5e6 * random_unit(&seed), 5e6 + 5e6 * random_unit(&seed), 0.9 * random_unit(&seed),
                                   50.0 * random_unit(&seed), random_unit(&seed)};
        struct cylinder_input in[3], *i;
        for (i = in; i < in + 3; i++)
            *i = (struct cylinder_input){MID_M + 0.2 * random_unit(&seed), random_unit(&seed), random_unit(&seed)};
        struct cylinder_state k1 = derivative(&s, in[0].length_m, in[0].rate_mps, in[0].valve), at = combine(&s, SUBSTEP_S / 2, &k1);
        struct cylinder_state k2 = derivative(&at, in[1].length_m, in[1].rate_mps, in[1].valve);
        at = combine(&s, SUBSTEP_S / 2, &k2);
        struct cylinder_state k3 = derivative(&at, in[1].length_m, in[1].rate_mps, in[1].valve);
        at = combine(&s, SUBSTEP_S, &k3);
        struct cylinder_state k4 = derivative(&at, in[2].length_m, in[2].rate_mps, in[2].valve), expected = s;
        expected = combine(&expected, SUBSTEP_S / 6, &k1);
        expected = combine(&expected, SUBSTEP_S / 3, &k2);
        expected = combine(&expected, SUBSTEP_S / 3, &k3);
        expected = combine(&expected, SUBSTEP_S / 6, &k4);
        cylinder_limit(&model, 0, &expected);
        cylinder_step(&model, 0, SUBSTEP_S, in, &s);
        /* rounding only */
        assert_close(s.p1_pa, expected.p1_pa, 1e-5);
        assert_close(s.p2_pa, expected.p2_pa, 1e-5);
        assert_close(s.spool, expected.spool, 1e-14);
        assert_close(s.spool_rate, expected.spool_rate, 1e-11);
        assert_close(s.deflection, expected.deflection, 1e-14);
    }
    model.leg[0].seal_distance_m = 0.0;
}

/* An extended model without hoses, laws or resistance has the same equations as the plain one.
 * Unequal legs step alike all together and one alone. */
static void legs_step_alone_as_they_do_together(void **unused) {
    (void)unused;
    uint64_t seed = 6;
    struct cylinder_model apart = model, together;
    double length_m[3][LEGS], rate_mps[3][LEGS], valve[3][LEGS];
    struct hydraulics_input in[3];
    struct hydraulics_state start = {0};
    for (int k = 0; k < LEGS; k++) {
        apart.leg[k].bulk_modulus_pa *= 1.0 + 0.01 * k, apart.leg[k].seal_distance_m = 1e-4 * k;
        start.cylinder[k] = (struct cylinder_state){5e6 + 5e6 * random_unit(&seed), 5e6 + 5e6 * random_unit(&seed),
                                                    0.9 * random_unit(&seed), 50.0 * random_unit(&seed), random_unit(&seed)};
        for (int i = 0; i < 3; i++)
            length_m[i][k] = MID_M + 0.2 * random_unit(&seed), rate_mps[i][k] = random_unit(&seed), valve[i][k] = random_unit(&seed);
    }
    for (int i = 0; i < 3; i++) in[i] = (struct hydraulics_input){length_m[i], rate_mps[i], valve[i]};
    for (int first = -1; first < LEGS; first++) {
        struct hydraulics_state a = start, b = start;
        if (first >= 0) apart.first = first, apart.legs = first + 1;
        together = apart;
        together.extended = true;
        hydraulics_step(&apart, SUBSTEP_S, in, &a);
        hydraulics_step(&together, SUBSTEP_S, in, &b);
        for (int k = 0; k < LEGS; k++) {
            bool moves = k >= apart.first && k < apart.legs;
            assert_true((a.cylinder[k].p1_pa != start.cylinder[k].p1_pa) == moves);
            assert_close(a.cylinder[k].p1_pa, b.cylinder[k].p1_pa, 1e-5);
            assert_close(a.cylinder[k].p2_pa, b.cylinder[k].p2_pa, 1e-5);
            assert_close(a.cylinder[k].spool, b.cylinder[k].spool, 1e-14);
            assert_close(a.cylinder[k].spool_rate, b.cylinder[k].spool_rate, 1e-11);
            assert_close(a.cylinder[k].deflection, b.cylinder[k].deflection, 1e-14);
        }
    }
}

static void spool_stops_at_full_opening(void **unused) {
    (void)unused;
    struct cylinder_state s = {.p1_pa = 5e6, .p2_pa = 5e6};
    for (int i = 0; i < 400; i++) {
        step(&s, SUBSTEP_S, MID_M, 0.0, 1.0);
        assert_true(fabs(s.spool) <= 1.0);
    }
    assert_close(s.spool, 1.0, 1e-12);
    for (int i = 0; i < 400; i++) step(&s, SUBSTEP_S, MID_M, 0.0, -1.0);
    assert_close(s.spool, -1.0, 1e-12);
    struct cylinder_state beyond = {.spool = 1.01, .spool_rate = -3.0};
    cylinder_limit(&model, 0, &beyond);
    assert_true(beyond.spool == 1.0 && beyond.spool_rate == -3.0); /* the spool may leave the
                                                                    * stop */
}

static void the_spool_alone_moves_as_with_its_chambers(void **unused) {
    (void)unused;
    struct cylinder_state with = {.p1_pa = 5e6, .p2_pa = 5e6, .spool = 0.2}, alone = with;
    struct cylinder_model limited = model;
    model.leg[0].rate_limited = true, model.leg[0].valve_rate_per_s = 2.0;
    bool at_limit = false;
    for (int i = 0; i < 4000; i++) {
        double valve = 0.1 * sin(0.01 * i) + (i % 7 ? 0.001 : -0.004);
        step(&with, SUBSTEP_S, MID_M, 0.0, valve);
        cylinder_spool_step(&model, 0, SUBSTEP_S, valve, &alone);
        at_limit = at_limit || fabs(alone.spool_rate) >= 2.0;
        assert_close(alone.spool, with.spool, 1e-12);
        assert_close(alone.spool_rate, with.spool_rate, 1e-9);
    }
    assert_true(at_limit && alone.p1_pa == 5e6);
    model = limited;
}

/* Extends by 0.3 m through mid-stroke with closed ports; returns the lowest pressure and the last
 * state. */
static double tear_open(double speed, double substep, struct cylinder_state *s) {
    double start = MID_M - 0.15, lowest = 0.0;
    *s = (struct cylinder_state){.p1_pa = 1e6, .p2_pa = 1e6};
    for (int i = 0; i * substep * speed < 0.3; i++) {
        step(s, substep, start + i * substep * speed, speed, 0.0);
        lowest = fmin(lowest, s->p1_pa);
    }
    return lowest;
}

static void a_chamber_torn_open_stays_above_vacuum_and_recovers(void **unused) {
    (void)unused;
    for (double speed = 0.05; speed <= 1.0; speed *= 1.5) {
        struct cylinder_state s, fine;
        double lowest = tear_open(speed, SUBSTEP_S, &s);
        assert_true(lowest < 0.0); /* it did cavitate */
        assert_true(lowest >= VACUUM_PA);
        /* the equations, not the limit, keep the pressure above vacuum */
        assert_below(VACUUM_PA + 1e3, tear_open(speed, SUBSTEP_S / 16, &fine));
        assert_close(s.p1_pa, fine.p1_pa, 1e3); /* the substep is fine enough */
        s.p2_pa = 0.0;
        for (int i = 0; i < 80; i++) step(&s, SUBSTEP_S, MID_M + 0.15, 0.0, 0.0);
        assert_close(s.p1_pa, 0.0, 10.0); /* 20 ms are many time constants of the make-up valve, 1
                                           * ms */
    }
}

/* The stiffest case: the chamber is only the dead volume, the valve is wide open, and the bare
 * orifice has a time constant of 11 us. */
static void a_small_chamber_fills_without_ringing_even_under_euler(void **unused) {
    (void)unused;
    const double supply = params.hydraulics.supply_pa;
    struct cylinder_state s = {.p1_pa = 0.0, .p2_pa = 0.0, .spool = 1.0};
    double gap = supply;
    for (int i = 0; i < 400; i++) {
        struct cylinder_state rate = derivative(&s, model.leg[0].length_min_m, 0.0, 1.0);
        s.p1_pa += SUBSTEP_S * rate.p1_pa;
        s.p2_pa = s.p1_pa; /* no leakage */
        if (i > 4) assert_true(fabs(supply - s.p1_pa) <= gap); /* the first steps may overshoot */
        gap = fabs(supply - s.p1_pa);
    }
    assert_below(gap, 1e-9 * supply);
}

static void end_stops_push_and_never_pull(void **unused) {
    (void)unused;
    uint64_t seed = 2;
    for (int n = 0; n < 10000; n++) {
        double depth = 1e-3 * random_unit(&seed), speed = random_unit(&seed);
        double low = cylinder_stop_force(&model, 0, model.leg[0].length_min_m - depth, speed);
        double high = cylinder_stop_force(&model, 0, model.leg[0].length_max_m + depth, speed);
        assert_true(low >= 0.0 && high <= 0.0);
        if (depth <= 0.0) assert_true(low == 0.0 && high == 0.0);
    }
    double stiffness = params.hydraulics.stop_stiffness_n_per_m;
    assert_close(cylinder_stop_force(&model, 0, model.leg[0].length_min_m - 1e-3, 0.0), 1e-3 * stiffness, 1e-6);
    assert_close(cylinder_stop_force(&model, 0, model.leg[0].length_max_m + 1e-3, 0.0), -1e-3 * stiffness, 1e-6);
}

static void force_is_that_of_the_two_areas(void **unused) {
    (void)unused;
    double bore = params.actuator.piston_diameter_m[0], rod = params.actuator.rod_diameter_m[0];
    struct cylinder_state push = {.p1_pa = 1e6}, pull = {.p2_pa = 1e6};
    assert_close(cylinder_hydraulic_force(&model, 0, &push), PI / 4 * bore * bore * 1e6, 1e-9);
    assert_close(cylinder_hydraulic_force(&model, 0, &pull), -PI / 4 * (bore * bore - rod * rod) * 1e6, 1e-9);
}

/* Dahl's law at constant speed; the seals of a fast rod slide within 0.2 ms and never overshoot. */
static void seals_are_deflected_and_then_slide(void **unused) {
    (void)unused;
    struct cylinder_state s = {.p1_pa = 5e6, .p2_pa = 5e6};
    double way_m = 0.0;
    model.leg[0].seal_distance_m = 1e-4;
    for (int i = 0; i < 400; i++, way_m += 0.01 * SUBSTEP_S) {
        assert_close(s.deflection, 1.0 - exp(-way_m / 1e-4), 1e-6);
        step(&s, SUBSTEP_S, MID_M, 0.01, 0.0);
    }
    double slides = s.deflection;
    way_m = 0.0;
    for (int i = 0; i < 400; i++, way_m += 0.01 * SUBSTEP_S) {
        assert_close(s.deflection, -1.0 + (slides + 1.0) * exp(-way_m / 1e-4), 1e-6);
        step(&s, SUBSTEP_S, MID_M, -0.01, 0.0);
    }
    for (int i = 0; i < 400; i++) {
        step(&s, SUBSTEP_S, MID_M, i % 2 ? -2.0 : 2.0, 0.0);
        assert_true(fabs(s.deflection) <= 1.0);
    }
    for (int i = 0; i < 8; i++) step(&s, SUBSTEP_S, MID_M, 2.0, 0.0);
    assert_true(s.deflection > 0.99);
    model.leg[0].seal_distance_m = 0.0;
    step(&s, SUBSTEP_S, MID_M, 2.0, 0.0);
    assert_true(s.deflection > 0.99);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_spool_alone_moves_as_with_its_chambers),
        cmocka_unit_test(every_neutral_leg_has_the_same_length),
        cmocka_unit_test(joints_lie_at_the_angles_of_the_paper),
        cmocka_unit_test(neutral_is_at_mid_stroke),
        cmocka_unit_test(rated_drop_gives_rated_flow_either_way),
        cmocka_unit_test(flow_follows_the_root_exactly_down_to_10_kpa),
        cmocka_unit_test(flow_through_zero_drop_is_odd_monotonic_and_smooth),
        cmocka_unit_test(a_closed_chamber_keeps_its_oil),
        cmocka_unit_test(leakage_takes_from_one_chamber_what_it_gives_the_other),
        cmocka_unit_test(spool_steps_like_a_second_order_system),
        cmocka_unit_test(a_step_is_runge_kuttas_of_the_derivative),
        cmocka_unit_test(legs_step_alone_as_they_do_together),
        cmocka_unit_test(seals_are_deflected_and_then_slide),
        cmocka_unit_test(spool_stops_at_full_opening),
        cmocka_unit_test(a_chamber_torn_open_stays_above_vacuum_and_recovers),
        cmocka_unit_test(a_small_chamber_fills_without_ringing_even_under_euler),
        cmocka_unit_test(end_stops_push_and_never_pull),
        cmocka_unit_test(force_is_that_of_the_two_areas),
    };
    return cmocka_run_group_tests(tests, defaults, NULL);
}
