/* A survey of the simulated platform against its linearisation: the machine's equations
 * differentiated by finite differences with the controller in the loop, and their eigenvalues. */
#include "platform_rig.h"

#include <complex.h>
#include <stdlib.h>

#include "closed_form.h"
#include "loop_found.h"
#include "loop_survey.h"
#include "machine_found.h"
#include "loop_tune.h"
#include "modal.h"
#include "motion_check.h"
#include "pid.h"
#include "proposal.h"
#include "admit_rig.h"
#include "trajectory_file.h"

enum { BODY = 2 * DOFS, OPEN = BODY + 4 * LEGS, CLOSED = OPEN + 4 * LEGS, SUBSTEPS = 8 };

/* The machine at its working point, and its controllers. */
struct linear {
    const struct params *params;
    struct closed_form *machine;
    struct pid pid[LEGS];
    double valve[LEGS], neutral_m[LEGS];
    double (*map)[CLOSED]; /* [size] maps one instant to the next, dt_s later */
    int size;
    double dt_s;
};

static void cycle(struct linear *l) {
    struct instant now;
    rigid_legs(&l->machine->rigid, &l->machine->state.body, &now.legs);
    for (int k = 0; k < LEGS; k++)
        l->valve[k] = pid_step(&l->pid[k], &l->params->control, l->params->loop.period_s, l->neutral_m[k], now.legs.length[k],
                               cylinder_hydraulic_force(&l->machine->cylinder, k, &l->machine->state.hydraulics.cylinder[k]));
    const struct drive drive = {.valve = l->valve};
    for (int i = 0; i < SUBSTEPS; i++)
        closed_form_rk4(l->machine, &l->machine->state, l->params->loop.period_s / SUBSTEPS, &drive, &l->machine->state);
}

static void get(const struct linear *l, double *y) {
    const union system *s = &l->machine->state;
    rigid_pose(&s->body, y);
    memcpy(y + DOFS, s->body.twist, sizeof s->body.twist);
    for (int k = 0; k < LEGS; k++) {
        const struct cylinder_state *c = &s->hydraulics.cylinder[k];
        double *own = y + BODY + 4 * k, *control = y + OPEN + 4 * k;
        own[0] = c->p1_pa, own[1] = c->p2_pa, own[2] = c->spool, own[3] = c->spool_rate;
        if (l->size == CLOSED)
            control[0] = l->pid[k].integral, control[1] = l->pid[k].derivative_mps, control[2] = l->pid[k].force_lp_n,
            control[3] = l->pid[k].error_m;
    }
}

static void set(struct linear *l, const double *y) {
    union system *s = &l->machine->state;
    rigid_rest(&s->body, y);
    memcpy(s->body.twist, y + DOFS, sizeof s->body.twist);
    for (int k = 0; k < LEGS; k++) {
        const double *own = y + BODY + 4 * k, *control = y + OPEN + 4 * k;
        s->hydraulics.cylinder[k] = (struct cylinder_state){.p1_pa = own[0], .p2_pa = own[1], .spool = own[2], .spool_rate = own[3]};
        if (l->size == CLOSED)
            l->pid[k] = (struct pid){.integral = control[0],
                                     .derivative_mps = control[1],
                                     .force_lp_n = control[2],
                                     .error_m = control[3],
                                     .ref_m = l->neutral_m[k]};
    }
}

static void advance(struct linear *l) {
    const struct drive drive = {.valve = l->valve};
    if (l->size == CLOSED) cycle(l);
    else closed_form_rk4(l->machine, &l->machine->state, l->dt_s, &drive, &l->machine->state);
}

/* Differentiates by central differences, whose steps are small against the working point and large
 * against rounding. */
static void differentiate(struct linear *l, int size) {
    static const double step[4] = {1e3, 1e3, 1e-5, 1e-3}, control_step[4] = {1e-4, 1e-6, 1.0, 1e-7};
    double at[CLOSED], from[CLOSED], to[CLOSED], valve[LEGS];
    l->size = size;
    l->dt_s = l->params->loop.period_s / (size == CLOSED ? 1 : SUBSTEPS);
    memcpy(valve, l->valve, sizeof valve);
    get(l, at);
    for (int c = 0; c < size; c++) {
        double h = c < DOFS ? 1e-7 : c < BODY ? 1e-5 : c < OPEN ? step[(c - BODY) % 4] : control_step[(c - OPEN) % 4], y[CLOSED];
        memcpy(y, at, sizeof y);
        y[c] = at[c] + h, set(l, y), advance(l), get(l, to);
        y[c] = at[c] - h, set(l, y), memcpy(l->valve, valve, sizeof valve), advance(l), get(l, from);
        memcpy(l->valve, valve, sizeof valve);
        for (int r = 0; r < size; r++) l->map[r][c] = (to[r] - from[r]) / (2.0 * h);
    }
    set(l, at);
}

/* Solves the equations by Gaussian elimination with row pivots. */
static void solve(int n, double complex a[CLOSED][CLOSED], double complex *b) {
    for (int c = 0; c < n; c++) {
        int pivot = c;
        for (int r = c + 1; r < n; r++)
            if (cabs(a[r][c]) > cabs(a[pivot][c])) pivot = r;
        for (int i = 0; i < n; i++) {
            double complex swap = a[c][i];
            a[c][i] = a[pivot][i], a[pivot][i] = swap;
        }
        double complex swap = b[c];
        b[c] = b[pivot], b[pivot] = swap;
        for (int r = c + 1; r < n; r++) {
            double complex factor = a[r][c] / a[c][c];
            for (int i = c; i < n; i++) a[r][i] -= factor * a[c][i];
            b[r] -= factor * b[c];
        }
    }
    for (int c = n - 1; c >= 0; c--) {
        for (int i = c + 1; i < n; i++) b[c] -= a[c][i] * b[i];
        b[c] /= a[c][c];
    }
}

/* Finds a pole near a guess by inverse iteration. */
static double complex pole_near(const struct linear *l, double complex guess) {
    static double complex a[CLOSED][CLOSED];
    double complex z = cexp(guess * l->dt_s), x[CLOSED], before[CLOSED], grown = 1.0;
    for (int i = 0; i < l->size; i++) x[i] = 1.0 + 0.1 * i;
    for (int n = 0; n < 60; n++) {
        int most = 0;
        for (int i = 0; i < l->size; i++)
            if (cabs(x[i]) > cabs(x[most])) most = i;
        double size = cabs(x[most]);
        for (int i = 0; i < l->size; i++) before[i] = x[i] /= size;
        for (int r = 0; r < l->size; r++)
            for (int c = 0; c < l->size; c++) a[r][c] = l->map[r][c] - (r == c ? z : 0.0);
        solve(l->size, a, x);
        grown = x[most] / before[most];
        /* the guess is now nearer to this pole than to any other */
        if (n % 10 == 9) z += 1.0 / grown, grown = HUGE_VAL;
    }
    return clog(z) / l->dt_s;
}

/* A machine surveyed as in a run; `configured` may differ from it. */
struct surveyed {
    struct params params, configured;
    double noise_pa; /* noise added to leg 3's recorded pressures */
    struct loop_survey survey;
    struct linear linear;
};

static void work_out(struct surveyed *s) {
    static const double neutral[DOFS] = {0};
    static double map[CLOSED][CLOSED];
    struct linear *l = &s->linear;
    struct error error;
    struct kinematics k;
    assert_int_equal(kinematics_init(&k, &s->params, &error), 0);
    *l = (struct linear){.params = &s->params, .machine = (struct closed_form *)engine_closed_form.create(&s->params, &error), .map = map};
    memcpy(l->neutral_m, k.neutral_length_m, sizeof l->neutral_m);
    assert_non_null(l->machine);
    rigid_rest(&l->machine->state.body, neutral);
    for (int leg = 0; leg < LEGS; leg++) {
        l->machine->state.hydraulics.cylinder[leg] = (struct cylinder_state){.p1_pa = 3.4e6, .p2_pa = 6.6e6, .spool = -0.07};
        pid_reset(&l->pid[leg], l->neutral_m[leg], 500.0);
    }
    for (int i = 0; i < 5000; i++)
        cycle(l); /* runs ten seconds, five time constants of the
                                              * integral */
}

static int survey(struct surveyed *s, struct error *error) {
    static struct rig rig;
    static struct recording recording;
    struct multisine multisine;
    struct trajectory trajectory;
    struct method_c c;
    struct cylinder_areas areas = cylinder_areas(&s->params.actuator);
    uint64_t seed = 3;
    assert_int_equal(multisine_init(&multisine, &s->configured, error), 0);
    assert_int_equal(multisine_trajectory(&multisine, &trajectory, error), 0);
    s->params.tests.duration_s = s->configured.tests.duration_s = trajectory_s(&trajectory);
    snprintf(s->params.tests.trajectory, sizeof s->params.tests.trajectory, "survey");
    rig_init(&rig, &s->params);
    rig.platform.trajectory = &trajectory;
    recording_init(&recording, &s->configured);
    while (rig.now.state != STATE_PARKING) {
        rig_cycle(&rig, COMMAND_NONE);
        struct cycle recorded = rig.now;
        recorded.in.p1_pa[2] += s->noise_pa * random_unit(&seed), recorded.in.p2_pa[2] += s->noise_pa * random_unit(&seed);
        recorded.force_n[2] = leg_force(&areas, 2, recorded.in.p1_pa[2], recorded.in.p2_pa[2]);
        assert_int_equal(recording_add(&recording, &recorded, error), 0);
        assert_true(rig.now.state != STATE_FAULT && rig.cycles < 20000);
    }
    plant_destroy(rig.plant);
    int status = admit_rig(&recording, false, error);
    if (!status) status = method_c(&recording, &c, error);
    if (!status) status = loop_survey(&s->survey, &multisine, &recording, &c, error);
    recording_free(&recording);
    trajectory_free(&trajectory);
    return status;
}

static struct surveyed *surveyed_default(void) {
    static struct surveyed s;
    struct error error;
    if (s.survey.determined) return &s;
    s.params = s.configured = brisk();
    if (survey(&s, &error)) fail_msg("%s", error.text);
    assert_true(s.survey.determined);
    work_out(&s);
    return &s;
}

/* Surveys a machine unlike the configuration: heavier, softer oil, one leg with air in it and one
 * with dead volume, more friction, slower valves. */
static struct surveyed *surveyed_other(void) {
    static struct surveyed s;
    struct error error;
    if (s.survey.determined) return &s;
    s.params = s.configured = brisk();
    s.params.payload.mass_kg = 260.0, s.params.payload.inertia_xx_kg_m2 = 22.0;
    s.params.hydraulics.valve_frequency_hz = 70.0;
    for (int k = 0; k < LEGS; k++) s.params.hydraulics.bulk_modulus_pa[k] = 0.8e9, s.params.hydraulics.viscous_n_s_per_m[k] = 3000.0;
    s.params.hydraulics.bulk_modulus_pa[2] = 0.6e9, s.params.hydraulics.dead_volume_m3[4] = 2.5e-4;
    if (survey(&s, &error)) fail_msg("%s", error.text);
    assert_true(s.survey.determined);
    work_out(&s);
    return &s;
}

static void check_oil_columns(struct surveyed *s) {
    differentiate(&s->linear, OPEN);
    for (int i = 0; i < DOFS; i++) {
        double hz = s->survey.mode[i].hz, plant_hz = HUGE_VAL;
        /* poles are close together: the guess decides which one is found */
        for (double damping = 0.02; damping < 0.4; damping += 0.06) {
            double pole_hz = cabs(pole_near(&s->linear, CMPLX(-damping, 1.0) * 2.0 * PI * hz)) / (2.0 * PI);
            if (fabs(pole_hz - hz) < fabs(plant_hz - hz)) plant_hz = pole_hz;
        }
        print_message("oil column %d: %.2f +- %.2f Hz, plant %.2f Hz: %+.1f %%\n", i + 1, hz, s->survey.mode[i].hz_std, plant_hz,
                      100.0 * (hz / plant_hz - 1.0));
        assert_close(hz / plant_hz, 1.0, 0.05);
    }
}

static void the_oil_columns_are_within_5_pct_of_the_plants_linearisation(void **unused) {
    (void)unused;
    numbers_case();
    check_oil_columns(surveyed_default());
}

static void and_of_a_machine_that_is_not_as_configured(void **unused) {
    (void)unused;
    numbers_case();
    check_oil_columns(surveyed_other());
}

static bool oscillates(double complex s) { return fabs(cimag(s)) > 1.0 && -creal(s) < 0.95 * cabs(s); }

/* Asserts that guesses from a quarter of the survey's frequency upwards lead to no lower pole that
 * oscillates. */
static void check_loop(struct surveyed *s) {
    double hz = loop_survey_loop_hz(&s->survey), least = HUGE_VAL;
    differentiate(&s->linear, CLOSED);
    for (double guess_hz = 0.25 * hz; guess_hz < 1.3 * hz; guess_hz *= 1.1)
        for (double damping = 0.1; damping < 0.9; damping += 0.35) {
            double complex pole = pole_near(&s->linear, CMPLX(-damping, sqrt(1.0 - damping * damping)) * 2.0 * PI * guess_hz);
            if (oscillates(pole)) least = fmin(least, cabs(pole) / (2.0 * PI));
        }
    print_message("closed loop: lowest pair %.2f Hz, linearised %.2f Hz: %+.1f %%\n", hz, least, 100.0 * (hz / least - 1.0));
    assert_close(hz / least, 1.0, 0.05);
}

static void the_loops_lowest_pole_pair_is_within_5_pct_of_the_linearised_loops(void **unused) {
    (void)unused;
    numbers_case();
    check_loop(surveyed_default());
}

static void and_with_another_machine_in_it(void **unused) {
    (void)unused;
    numbers_case();
    check_loop(surveyed_other());
}

/* The controller weighs its modes with the configured payload, also when a survey has found
 * another one. So must the margins that follow from the survey. */
static void weights_are_those_of_the_configuration(void **unused) {
    (void)unused;
    slow_case();
    struct surveyed *s = surveyed_other();
    struct params configured = s->configured, machine = s->params;
    struct loop_tune found;
    struct error error;
    struct kinematics k;
    struct modal modal;
    static struct loop_places places;
    static struct loop_plant plant[DOFS];
    double least_db = HUGE_VAL;
    configured.control.modal = 0.6;
    machine.control = configured.control;
    kinematics_place(&k, &configured);
    assert_int_equal(modal_init(&modal, &configured, &k, &error), STATUS_OK);
    assert_int_equal(loop_tune_surveyed(&configured, &s->survey, &found, &error), 0);
    assert_true(loop_places_find(&places, &machine, false));
    for (int i = 0; i < places.count; i++) {
        struct loop_place *place = &places.place[i];
        struct loop_margin margin[DOFS];
        loop_place_weigh(place, &modal);
        for (int mode = 0; mode < DOFS; mode++) {
            const struct loop_mode_input shape = loop_place_mode(place, mode);
            loop_plant_find(place->leg, &shape, &machine, &plant[mode]);
        }
        loop_margins(plant, (const double (*)[DOFS])place->mix, &machine.control, machine.loop.period_s, margin);
        for (int mode = 0; mode < DOFS; mode++) least_db = fmin(least_db, fmin(margin[mode].gain_db, margin[mode].drop_db));
    }
    print_message("# gain margin %.2f dB of the machine, %.2f dB from the survey\n", least_db, found.before.gain_db.value);
    assert_close(found.before.gain_db.value, least_db, 1.0);
}

/* Gains from a survey suit the machine that was surveyed, even if the configuration describes
 * another one. kp and kpf are within a fifth, and on the machine itself they keep the margins to 1
 * dB and 5 degrees. */
static void gains_from_a_survey_are_those_of_the_machine(void **unused) {
    (void)unused;
    numbers_case();
    struct surveyed *s = surveyed_other();
    struct loop_tune found, exact, nominal;
    struct error error;
    assert_int_equal(loop_tune_surveyed(&s->configured, &s->survey, &found, &error), 0);
    assert_int_equal(loop_tune(&s->params, false, false, &exact, &error), 0);
    assert_int_equal(loop_tune(&s->configured, false, false, &nominal, &error), 0);
    print_message("# kp %g, kpf %g, kff %g from the survey; %g, %g, %g of the machine; %g, %g, %g of the configuration\n", found.gains.kp,
                  found.gains.kpf, found.gains.kff, exact.gains.kp, exact.gains.kpf, exact.gains.kff, nominal.gains.kp, nominal.gains.kpf,
                  nominal.gains.kff);
    struct params p = s->params;
    struct loop_standing standing;
    p.control = found.gains;
    assert_int_equal(loop_tune_stand(&p, false, &standing, &error), 0);
    print_message("# on the machine: gain %.1f dB, phase %.0f degrees, damping %.2f; predicted %.1f, %.0f, %.2f\n", standing.gain_db.value,
                  standing.phase_deg.value, standing.damping.value, found.after.gain_db.value, found.after.phase_deg.value,
                  found.after.damping.value);
    assert_close(found.gains.kp / exact.gains.kp, 1.0, 0.2);
    assert_close(standing.gain_db.value, found.after.gain_db.value, 1.0);
    assert_close(standing.phase_deg.value, found.after.phase_deg.value, 5.0);
}

/* The survey's oil and delay go into the configuration that control reads: leg 3 has air in it, leg
 * 5 a dead volume, which softens it as soft oil does; the valves are later by 1.09 ms. */
static void what_a_survey_found_goes_into_the_configuration(void **unused) {
    (void)unused;
    numbers_case();
    struct surveyed *s = surveyed_other();
    static struct machine_found found;
    struct test_params *t = &found.params.tests;
    memset(&found, 0, sizeof found);
    found.params = loop_found_params(&s->configured, &s->survey);
    snprintf(t->trajectory, sizeof t->trajectory, "survey");
    t->repeat = MULTISINE_PASSES;
    assert_true(machine_found_is_survey(&found.params));
    machine_found_survey(&s->survey, &found);
    for (int leg = 0; leg < LEGS; leg++) {
        print_message("# leg %d: oil %.3g Pa, valve %.3g m^3/s\n", leg + 1, found.params.hydraulics.bulk_modulus_pa[leg],
                      found.params.hydraulics.valve_flow_m3_per_s[leg]);
        if (leg == 4) continue;
        assert_close(found.params.hydraulics.bulk_modulus_pa[leg] / s->params.hydraulics.bulk_modulus_pa[leg], 1.0, 0.05);
        assert_close(found.params.hydraulics.valve_flow_m3_per_s[leg] / s->params.hydraulics.valve_flow_m3_per_s[leg], 1.0, 0.05);
    }
    assert_true(found.params.hydraulics.bulk_modulus_pa[4] < 0.7e9);
    assert_close(found.params.control.delay_s, 1.09e-3, 0.3e-3);
    assert_false(machine_found_is_survey(&found.params));
    assert_true(!*t->trajectory && t->repeat == 1);
}

/* Valves that differ from the configured ones within their tolerance. The survey measures their
 * flow to half a per cent, so hardly anything of the configured error may stay in the law. */
static void a_surveys_flow_outweighs_the_tolerance(void **unused) {
    (void)unused;
    slow_case();
    static struct surveyed s;
    static struct machine_found found;
    struct error error;
    s.params = s.configured = brisk();
    for (int leg = 0; leg < LEGS; leg++) s.params.hydraulics.valve_flow_m3_per_s[leg] *= leg % 2 ? 1.04 : 0.96;
    if (survey(&s, &error)) fail_msg("%s", error.text);
    memset(&found, 0, sizeof found);
    found.params = s.configured;
    machine_found_survey(&s.survey, &found);
    for (int leg = 0; leg < LEGS; leg++)
        assert_close(found.params.hydraulics.valve_flow_m3_per_s[leg] / s.params.hydraulics.valve_flow_m3_per_s[leg], 1.0, 0.01);
}

/* Pistons that leak 4 % more or less than configured, behind valves whose nulls are off by 1 %.
 * The configuration has its leakage in part as an effect. */
static void a_surveys_leakage_is_found_beside_a_null(void **unused) {
    (void)unused;
    numbers_case();
    static struct surveyed s;
    static struct machine_found found;
    struct error error;
    int leakage = effect_find("internal_leakage");
    s.params = s.configured = brisk();
    struct effect_values *null_bias = &s.params.effects[effect_find("valve_null_bias")], *scale = &s.configured.effects[leakage];
    null_bias->on = scale->on = true;
    for (int leg = 0; leg < LEGS; leg++) {
        s.params.hydraulics.leakage_m3_per_s_pa[leg] *= leg % 2 ? 1.04 : 0.96;
        null_bias->value[0][leg] = leg % 3 ? 0.01 : -0.01;
        scale->value[0][leg] = 1.25, s.configured.hydraulics.leakage_m3_per_s_pa[leg] /= 1.25;
    }
    if (survey(&s, &error)) fail_msg("%s", error.text);
    memset(&found, 0, sizeof found);
    found.params = s.configured;
    machine_found_survey(&s.survey, &found);
    assert_false(found.params.effects[leakage].on);
    for (int leg = 0; leg < LEGS; leg++) {
        double truth = s.params.hydraulics.leakage_m3_per_s_pa[leg], std = s.survey.leg[leg].leakage_std;
        print_message("# leg %d: leakage %.4g +- %.2g, is %.4g; taken %.4g\n", leg + 1, s.survey.leg[leg].leakage, 2.0 * std, truth,
                      found.params.hydraulics.leakage_m3_per_s_pa[leg]);
        assert_below(fabs(s.survey.leg[leg].leakage - truth), 3.0 * std);
        assert_close(found.params.hydraulics.leakage_m3_per_s_pa[leg] / truth, 1.0, 0.03);
    }
}

static void what_the_pressures_do_not_show_is_no_number(void **unused) {
    (void)unused;
    numbers_case();
    static struct surveyed s;
    struct error error;
    s.params = s.configured = brisk();
    s.noise_pa = 3e6; /* 150 times the sensors' noise */
    if (survey(&s, &error)) fail_msg("%s", error.text);
    assert_true(isnan(s.survey.leg[2].stiffness) && isnan(s.survey.leg[2].leakage) && isfinite(s.survey.leg[1].stiffness));
    assert_true(!s.survey.determined && isnan(s.survey.mode[0].hz) && isnan(loop_survey_oil_hz(&s.survey)) &&
                isnan(loop_survey_loop_hz(&s.survey)));
}

static void samples_lost_in_every_pass_are_said(void **unused) {
    (void)unused;
    struct params params = brisk();
    struct multisine multisine;
    struct multisine_mean mean;
    struct recording_test test = {0};
    struct error error;
    assert_int_equal(multisine_init(&multisine, &params, &error), 0);
    for (int i = 0; i < MULTISINE_PASSES * multisine.samples; i++) {
        struct recording_sample sample = {.test_time_s = i * multisine.step_s,
                                          .refused = i % multisine.samples == 700 ? REFUSED_LATE : REFUSED_NOT};
        assert_int_equal(recording_append(&test, &sample, &error), 0);
    }
    assert_int_equal(multisine_average(&mean, &multisine, &test, 0.0, &error), STATUS_USAGE);
    assert_non_null(strstr(error.text, "1.400 s"));
    multisine_free(&mean);
    test.sample[700 + 2 * multisine.samples].refused = REFUSED_NOT; /* one is enough */
    assert_int_equal(multisine_average(&mean, &multisine, &test, 0.0, &error), 0);
    multisine_free(&mean);
    free(test.sample);
}

static void rises(void *context, double share) {
    double *before = context;
    assert_true(share > *before && share < 1.0);
    *before = share;
}

/* A search for shares of a multisine repeats these predictions; tests/scenarios/survey.sh runs what
 * is proposed. */
static void proposed_sines_keep_to_every_limit_and_reach_what_is_wanted(void **unused) {
    (void)unused;
    slow_case();
    struct surveyed *s = surveyed_default();
    double share = -1.0, wanted_pct = 3.0;
    struct proposal_watch watch = {.share = rises, .context = &share};
    struct params run = s->configured;
    struct proposal p;
    struct error error;
    run.tests.trajectory[0] = '\0';
    assert_int_equal(propose(PROPOSAL_SINES, &s->survey, &run, wanted_pct, &watch, &p, &error), 0);
    if (p.none.status) fail_msg("%s", p.none.text);
    print_message("# %g %% wanted, %g %% predicted, %g s an axis\n", wanted_pct, p.predicted.worst_pct, p.tests.duration_s);
    assert_true(p.reached && !p.tests.multisine && p.tests.count == DOFS);
    assert_close(p.predicted.worst_pct / wanted_pct, 1.0, 0.05);
    for (int i = 0; i < DOFS; i++) {
        assert_true(p.tests.hz[i] >= 1.0 && p.tests.amplitude[i] > 0.0);
        assert_true(p.tests.hz[i] <= loop_survey_oil_hz(&s->survey) / 3.0 && p.tests.hz[i] <= loop_survey_loop_hz(&s->survey) / 2.0);
    }
    run.tests = p.tests;
    if (motion_check(&run, NULL, &error)) fail_msg("%s", error.text);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_oil_columns_are_within_5_pct_of_the_plants_linearisation),
                                       cmocka_unit_test(and_of_a_machine_that_is_not_as_configured),
                                       cmocka_unit_test(the_loops_lowest_pole_pair_is_within_5_pct_of_the_linearised_loops),
                                       cmocka_unit_test(and_with_another_machine_in_it),
                                       cmocka_unit_test(weights_are_those_of_the_configuration),
                                       cmocka_unit_test(gains_from_a_survey_are_those_of_the_machine),
                                       cmocka_unit_test(what_a_survey_found_goes_into_the_configuration),
                                       cmocka_unit_test(a_surveys_flow_outweighs_the_tolerance),
                                       cmocka_unit_test(a_surveys_leakage_is_found_beside_a_null),
                                       cmocka_unit_test(what_the_pressures_do_not_show_is_no_number),
                                       cmocka_unit_test(samples_lost_in_every_pass_are_said),
                                       cmocka_unit_test(proposed_sines_keep_to_every_limit_and_reach_what_is_wanted)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
