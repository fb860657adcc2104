/* Method C on recordings of a known machine: motions in closed form, forces by inverse dynamics of
 * another machine than the configured one, separate dry friction for each leg and direction. The
 * result must not depend on the configuration. */
#include "support.h"

#include "agreement.h"
#include "inverse_dynamics.h"
#include "kinematics.h"
#include "leg_friction.h"
#include "method_c.h"
#include "nominal.h"
#include "parts.h"
#include "units.h"

enum { RATE = 500, RAMP = RATE / 2, SAMPLES = RAMP + 5 * RATE };

struct rig {
    struct params configured, machine;
    struct kinematics kinematics;
    struct inverse_dynamics inverse;
    double dry[LEGS][2], nominal[DOFS][DOFS];
    double unwanted; /* motion of the other axes, relative to their amplitudes */
    double noise_m, noise_pa;
    double step_m, step_pa;     /* resolution of the readings; 0: infinite */
    double presliding_m;        /* a seal deflects this far before it slides (Dahl); 0: Coulomb */
    double seal_n[LEGS], last_m[LEGS];
    double slow_share, slow_mps; /* excess of dry friction at rest, and the speed at which it fades
                                  * (Stribeck) */
    double load_mu;             /* coefficient of friction under the load (A1 - A2) (P1 + P2) / 2 */
    double pressure_pa[DOFS];   /* pressure of the rod side, per test */
    double error[SYSTEMATICS];  /* systematic errors of the sensors: gains, zeros, skew */
    double compliance_m_per_n;  /* of each leg between its sensor and its joints */
    double skew_s[DOFS];        /* skew of each test beside the common one */
    uint64_t seed;
};

/* Prepares a machine whose payload is a fifth lighter than configured and has other inertias. */
static void rig_init(struct rig *r, double dry_n) {
    static const double neutral[DOFS] = {0};
    struct error error;
    memset(r, 0, sizeof *r);
    r->seed = 5, r->unwanted = 0.05;
    config_default(&r->configured);
    r->configured.sensors.enabled = false;
    r->machine = r->configured;
    r->machine.payload.mass_kg *= 0.8;
    r->machine.payload.inertia_xx_kg_m2 *= 1.3;
    r->machine.payload.inertia_zz_kg_m2 *= 0.9;
    for (int d = 0; d < DOFS; d++) r->pressure_pa[d] = 3e6;
    for (int k = 0; k < LEGS; k++) {
        r->machine.hydraulics.viscous_n_s_per_m[k] = 0.0;
        for (int s = 0; s < 2; s++) r->dry[k][s] = dry_n * (1.0 + 0.5 * random_unit(&r->seed));
    }
    assert_int_equal(kinematics_init(&r->kinematics, &r->machine, &error), 0);
    nominal_matrix(&r->machine, &r->kinematics, neutral, r->nominal);
    inverse_dynamics_init(&r->inverse, &r->machine, 0.0, 0.0);
}

/* Computes a pose: the tested axis moves, the others slightly and out of phase, so that couplings
 * and friction mix as on a real machine. */
static void pose_at(const struct rig *r, int dof, double t_s, double pose[DOFS]) {
    for (int i = 0; i < DOFS; i++) {
        double w = 2.0 * PI * r->configured.tests.hz[dof], share = i == dof ? 1.0 : r->unwanted;
        pose[i] = share * r->configured.tests.amplitude[i] * sin(w * t_s - (i == dof ? 0.0 : 0.7 * (i + 1)));
    }
}

static void legs_at(const struct rig *r, int dof, double t_s, double leg[LEGS][3]) {
    static const double step_s = 1e-4;
    double length[3][LEGS];
    for (int j = 0; j < 3; j++) {
        double pose[DOFS];
        pose_at(r, dof, t_s + (j - 1) * step_s, pose);
        ik_lengths(&r->kinematics, pose, length[j]);
    }
    for (int k = 0; k < LEGS; k++) {
        leg[k][0] = length[1][k], leg[k][1] = (length[2][k] - length[0][k]) / (2.0 * step_s);
        leg[k][2] = (length[2][k] - 2.0 * length[1][k] + length[0][k]) / (step_s * step_s);
    }
}

/* Returns the force of Dahl's seal after the leg has moved: dF = (F_slide - F) |dx| / presliding,
 * exact for any step. */
static double seal(struct rig *r, int leg, double length_m, double rate) {
    double slides = rate > 0.0 ? r->dry[leg][0] : -r->dry[leg][1], moved = fabs(length_m - r->last_m[leg]);
    if (r->slow_mps > 0.0) slides *= 1.0 + r->slow_share * exp(-rate * rate / (r->slow_mps * r->slow_mps));
    if (!(r->presliding_m > 0.0)) return slides;
    r->last_m[leg] = length_m;
    return r->seal_n[leg] += (slides - r->seal_n[leg]) * (1.0 - exp(-moved / r->presliding_m));
}

static double rounded(double x, double step) { return step > 0.0 ? step * round(x / step) : x; }

static struct recording_sample sample_at(struct rig *r, int dof, double t_s) {
    struct recording_sample s = {.test_time_s = t_s, .clock_s = t_s};
    struct inverse_dynamics_input in = {0};
    double force_n[LEGS], bore = r->machine.actuator.piston_diameter_m[0], rod = r->machine.actuator.rod_diameter_m[0];
    double a1 = 0.25 * PI * bore * bore, a2 = a1 - 0.25 * PI * rod * rod;
    double older[LEGS][3];
    legs_at(r, dof, t_s, in.leg);
    legs_at(r, dof, t_s - r->error[SYSTEMATIC_SKEW] - r->skew_s[dof], older);
    assert_true(inverse_dynamics_step(&r->inverse, &in, force_n));
    for (int k = 0; k < LEGS; k++) {
        double rate = in.leg[k][1], load_m2 = copysign(0.5 * r->load_mu * (a1 - a2), rate), p2_pa = r->pressure_pa[dof];
        force_n[k] += 2000.0 * rate + seal(r, k, in.leg[k][0], rate);
        older[k][0] += r->compliance_m_per_n * force_n[k];
        double apart_m = older[k][0] - r->kinematics.neutral_length_m[k], p1_pa = (force_n[k] + (a2 + load_m2) * p2_pa) / (a1 - load_m2);
        s.length_m[k] = older[k][0] + r->error[SYSTEMATIC_LENGTH_ZERO + k] + r->error[SYSTEMATIC_LENGTH_GAIN + k] * apart_m +
                        r->noise_m * random_unit(&r->seed);
        s.p2_pa[k] = (1.0 + r->error[SYSTEMATIC_P2_GAIN + k]) * p2_pa + r->noise_pa * random_unit(&r->seed);
        s.p1_pa[k] = (1.0 + r->error[SYSTEMATIC_P1_GAIN + k]) * p1_pa + r->noise_pa * random_unit(&r->seed);
        s.length_m[k] = rounded(s.length_m[k], r->step_m);
        s.p1_pa[k] = rounded(s.p1_pa[k], r->step_pa), s.p2_pa[k] = rounded(s.p2_pa[k], r->step_pa);
        s.force_n[k] = a1 * s.p1_pa[k] - a2 * s.p2_pa[k];
    }
    return s;
}

static struct recording *record(struct rig *r, int tests) {
    static struct recording recording;
    struct error error;
    recording_init(&recording, &r->configured);
    recording.measured = (struct recording_measured){.force = true, .pressures = true};
    recording.tests = tests;
    for (int d = 0; d < tests; d++) {
        struct recording_test *t = &recording.test[d];
        double hz = r->configured.tests.hz[d];
        *t = (struct recording_test){.test = d, .dof = (enum dof)d, .frequency_hz = hz, .stated_hz = hz, .first = RAMP, .end = SAMPLES};
        for (int i = 0; i < SAMPLES; i++) {
            struct recording_sample s = sample_at(r, d, (double)i / RATE);
            assert_int_equal(recording_append(t, &s, &error), 0);
        }
    }
    assert_int_equal(measured_make(&recording, 0, &error), 0);
    return &recording;
}

/* The equations of one log, and their solution. */
struct log {
    struct equations equations;
    struct estimate estimate;
    struct method_c result;
};

static void solve(const struct rig *r, struct log *log) {
    struct error error;
    if (method_c_solve(&log->equations, &r->configured, &log->estimate, &log->result, &error)) fail_msg("%s", error.text);
}

/* Solves the tests from `first` on. */
static void find(struct rig *r, int first, int tests, struct log *log) {
    struct recording *recording = record(r, first + tests);
    struct error error;
    for (int i = 0; i < first; i++) recording_remove(recording, 0);
    if (method_c_equations(recording, &log->equations, &error)) fail_msg("%s", error.text);
    recording_free(recording);
    solve(r, log);
}

static struct method_c found(struct rig *r, int tests) {
    static struct log log;
    find(r, 0, tests, &log);
    return log.result;
}

static void dry_friction_of_each_leg_leaves_the_matrix_as_it_is(void **unused) {
    (void)unused;
    numbers_case();
    struct rig r;
    for (int friction = 0; friction < 2; friction++) {
        rig_init(&r, friction ? 150.0 : 0.0);
        struct method_c m = found(&r, DOFS);
        for (int i = 0; i < DOFS; i++)
            for (int j = 0; j < DOFS; j++) assert_close(m.matrix.mt[i][j], r.nominal[i][j], 2e-3 * sqrt(r.nominal[i][i] * r.nominal[j][j]));
        for (int k = 0; k < LEGS; k++) {
            /* a constant force, which the weight that was not configured causes */
            double constant = 0.5 * (m.dry[k][0] - m.dry[k][1]) - 0.5 * (r.dry[k][0] - r.dry[k][1]);
            assert_close(m.dry[k][0] - constant, r.dry[k][0], 2.0);
            assert_close(m.dry[k][1] + constant, r.dry[k][1], 2.0);
            assert_close(m.viscous[k], 2000.0, 40.0);
        }
    }
}

/* The friction is compared at rates far from a reversal, because eight harmonics of a step
 * overshoot it by up to a tenth of its height and ripple about it. */
static void force_less_what_the_found_matrix_needs_is_the_friction_found(void **unused) {
    (void)unused;
    slow_case();
    static struct log log;
    struct rig r;
    struct leg_friction f;
    struct error error;
    rig_init(&r, 150.0);
    struct recording *recording = record(&r, DOFS);
    assert_int_equal(method_c_equations(recording, &log.equations, &error), 0);
    solve(&r, &log);
    struct method_c m = log.result;
    assert_int_equal(leg_friction_find(&f, recording, &m, &error), 0);
    assert_int_equal(f.tests, DOFS);
    double worst_n = 0.0, mean_n = 0.0;
    for (int k = 0; k < LEGS; k++)
        for (int way = 0; way < 2; way++) {
            double sum_n = 0.0, step_n = m.dry[k][0] + m.dry[k][1];
            int points = 0;
            for (int i = 0; i < f.tests; i++) {
                const struct leg_friction_test *t = &f.test[i];
                double most_mps = 0.0;
                assert_true(t->cycle && t->points == PHASES);
                for (int j = 0; j < t->points; j++) most_mps = fmax(most_mps, fabs(t->rate_mps[k][j]));
                for (int j = 0; j < t->points; j++) {
                    double rate = t->rate_mps[k][j];
                    if ((rate < 0.0) != way || fabs(rate) < 0.5 * most_mps) continue;
                    double off_n = t->force_n[k][j] - m.viscous[k] * rate - (way ? -m.dry[k][1] : m.dry[k][0]);
                    sum_n += off_n, points++;
                    worst_n = fmax(worst_n, fabs(off_n) / step_n);
                }
            }
            assert_true(points > 100);
            mean_n = fmax(mean_n, fabs(sum_n / points) / step_n);
        }
    leg_friction_free(&f);
    recording_free(recording);
    print_message("friction drawn and found: apart by %.2f %% of the step on average, %.1f %% at most\n", 100.0 * mean_n, 100.0 * worst_n);
    assert_below(mean_n, 0.01);
    assert_below(worst_n, 0.1);
}

/* An off-centre weight tips the platform when it tilts, by a moment that is no inertia. */
static void the_payload_is_found_with_its_centre(void **unused) {
    (void)unused;
    numbers_case();
    static const double centre[3] = {0.03, -0.02, 0.04};
    struct rig r;
    rig_init(&r, 80.0);
    int place = effect_find("payload_center_of_mass");
    r.machine.effects[place].on = true;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < LEGS; k++) r.machine.effects[place].value[i][k] = centre[i];
    inverse_dynamics_init(&r.inverse, &r.machine, 0.0, 0.0);
    struct payload p = found(&r, DOFS).payload;
    const struct payload_params *body = &r.machine.payload;
    assert_true(p.evaluated && p.possible);
    assert_close(p.value[PAYLOAD_MASS], body->mass_kg, 0.005 * body->mass_kg);
    for (int i = 0; i < 3; i++) assert_close(p.value[PAYLOAD_CENTER + i], centre[i], 0.5e-3);
    assert_close(p.value[PAYLOAD_INERTIA], body->inertia_xx_kg_m2, 0.01 * body->inertia_zz_kg_m2);
    assert_close(p.value[PAYLOAD_INERTIA + 1], body->inertia_yy_kg_m2, 0.01 * body->inertia_zz_kg_m2);
    assert_close(p.value[PAYLOAD_INERTIA + 2], body->inertia_zz_kg_m2, 0.01 * body->inertia_zz_kg_m2);
    for (int i = 3; i < 6; i++) assert_close(p.value[PAYLOAD_INERTIA + i], 0.0, 0.01 * body->inertia_zz_kg_m2);
}

/* A motion along x determines the mass for a motion along z too, because the payload is one
 * body. */
static void what_no_test_tells_is_no_number(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r, 100.0);
    r.unwanted = 0.0, r.noise_m = 15e-6, r.noise_pa = 1e4;
    struct method_c m = found(&r, 1);
    assert_close(m.matrix.mt[0][0], r.nominal[0][0], 0.02 * r.nominal[0][0]);
    assert_true(isnan(m.matrix.mt[DOF_PSI][DOF_PSI]) && isnan(m.matrix.mt_std[DOF_PSI][DOF_PSI]));
    assert_close(m.matrix.mt[DOF_Z][DOF_Z], r.nominal[DOF_Z][DOF_Z], 0.02 * r.nominal[DOF_Z][DOF_Z]);
    r.configured.model.tolerance.rigidity = 1.0;
    m = found(&r, 1);
    assert_true(isnan(m.matrix.mt[DOF_Z][DOF_Z]));
}

/* In a single test of one axis all legs move in step, so only harmonics, which noise hides,
 * distinguish dry friction from inertia. */
static void friction_that_no_test_tells_is_no_number(void **unused) {
    (void)unused;
    numbers_case();
    struct rig r;
    rig_init(&r, 100.0);
    r.unwanted = 0.0, r.noise_m = 15e-6, r.noise_pa = 1e5;
    struct method_c one = found(&r, 1), all = found(&r, DOFS);
    int open = 0;
    for (int k = 0; k < LEGS; k++)
        for (int s = 0; s < 2; s++) {
            assert_true(isnan(one.dry[k][s]) == isnan(one.dry_std[k][s]) && !isnan(all.dry[k][s]));
            open += isnan(one.dry[k][s]);
        }
    assert_true(open == 2 * LEGS);
    assert_true(one.payload.evaluated && !one.payload.whole && isnan(one.payload.value[PAYLOAD_INERTIA + 2]) && all.payload.whole);
    assert_true(one.matrix.condition_number > 10.0 * all.matrix.condition_number && all.matrix.condition_number >= 1.0);
}

/* Returns the mean square of all entries' errors in units of their stated deviations. */
static double mean_square(const struct method_c *m, const struct rig *r) {
    enum { ENTRIES = DOFS * (DOFS + 1) / 2 };
    double sum = 0.0;
    for (int i = 0; i < DOFS; i++)
        for (int j = i; j < DOFS; j++) sum += pow((m->matrix.mt[i][j] - r->nominal[i][j]) / m->matrix.mt_std[i][j], 2.0);
    return sum / ENTRIES;
}

/* Variance of an entry by shared errors, each in the unit that it has in `sum`. Attenuation is left
 * out: it is a hundredth of the noise and depends on each log's sizes of basis functions. */
static double common_variance(const struct estimate *e, int c, const struct estimate *sum) {
    double variance = 0.0;
    for (int j = 0; j < COMMON_ATTENUATION; j++) variance += pow(estimate_common(e, j, c, sum->compliance_prior), 2.0);
    return variance;
}

/* Four logs of one motion quarter the noise's variance. They do not reduce the effect of joints
 * within their tolerance, which is so narrow that the logs hardly improve on it. */
static void repeats_shrink_the_noise_and_not_what_they_have_in_common(void **unused) {
    (void)unused;
    numbers_case();
    enum { LOGS = 4 };
    static struct log log[LOGS], sum;
    /* means over the logs, because their scatters and the scales of their basis functions differ */
    double noise[MATRIX_ENTRIES] = {0}, common[MATRIX_ENTRIES] = {0};
    struct rig r;
    rig_init(&r, 100.0);
    r.noise_m = 15e-6, r.noise_pa = 2e4;
    r.configured.model.tolerance.rigidity = 100.0, r.configured.model.tolerance.joints_m = 1e-4;
    sum.equations = (struct equations){0};
    for (int i = 0; i < LOGS; i++) {
        find(&r, 0, DOFS, &log[i]);
        equations_add(&sum.equations, &log[i].equations);
    }
    solve(&r, &sum);
    for (int i = 0; i < LOGS; i++)
        for (int c = 0; c < MATRIX_ENTRIES; c++)
            noise[c] += log[i].estimate.noise[c][c] / LOGS, common[c] += common_variance(&log[i].estimate, c, &sum.estimate) / LOGS;
    for (int c = 0; c < MATRIX_ENTRIES; c++) {
        assert_close(sum.estimate.noise[c][c], noise[c] / LOGS, 0.15 * noise[c] / LOGS);
        double variance = common_variance(&sum.estimate, c, &sum.estimate);
        assert_true(variance > 0.7 * common[c] && variance < 1.25 * common[c]);
    }
    assert_below(mean_square(&sum.result, &r), 2.0);
}

static void what_one_log_leaves_open_another_gives(void **unused) {
    (void)unused;
    numbers_case();
    enum { LOGS = 3 };
    static struct log log[LOGS], sum;
    struct rig r;
    rig_init(&r, 100.0);
    r.unwanted = 0.0, r.noise_m = 15e-6, r.noise_pa = 2e4;
    sum.equations = (struct equations){0};
    for (int i = 0; i < LOGS; i++) {
        find(&r, 2 * i, 2, &log[i]);
        assert_true(isnan(mean_square(&log[i].result, &r)));
        equations_add(&sum.equations, &log[i].equations);
    }
    solve(&r, &sum);
    assert_below(mean_square(&sum.result, &r), 2.0); /* fails on NaN */
}

static struct agreement agreement_of(const struct rig *r, int logs, const struct log *log) {
    struct agreement_log of[AGREEMENT_LOGS];
    struct agreement a;
    struct error error;
    for (int i = 0; i < logs; i++) of[i] = (struct agreement_log){&log[i].equations, &log[i].estimate, &log[i].result};
    if (agreement_find(logs, of, &r->configured, &a, &error)) fail_msg("%s", error.text);
    return a;
}

/* The mean chi-square of four trios is its number of degrees of freedom, to a fifth: the mean has a
 * deviation of 6 %, and the rows' noise is less well known. */
static void logs_that_differ_by_noise_agree(void **unused) {
    (void)unused;
    long_case();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    enum { LOGS = 3, TRIOS = 4 };
    static struct log log[LOGS];
    double ratio = 0.0;
    struct rig r;
    rig_init(&r, 100.0);
    r.noise_m = 15e-6, r.noise_pa = 2e4;
    for (int trio = 0; trio < TRIOS; trio++) {
        for (int i = 0; i < LOGS; i++) find(&r, 0, DOFS, &log[i]);
        struct agreement a = agreement_of(&r, LOGS, log);
        assert_int_equal(a.degrees, (LOGS - 1) * UNKNOWN_SPRING);
        assert_true(a.agree);
        ratio += a.chi_square / a.degrees / TRIOS;
    }
    print_message("chi-square over its degrees of freedom, %d trios of logs: %.2f\n", TRIOS, ratio);
    assert_close(ratio, 1.0, 0.2);
}

static void a_leg_that_rubs_in_one_log_is_named(void **unused) {
    (void)unused;
    slow_case();
    enum { LOGS = 3, LEG = 2 };
    static struct log log[LOGS];
    struct rig r;
    rig_init(&r, 100.0);
    r.noise_m = 15e-6, r.noise_pa = 2e4;
    for (int i = 0; i < LOGS; i++) {
        r.dry[LEG][0] += i == 1 ? 40.0 : 0.0, r.dry[LEG][1] += i == 1 ? 40.0 : 0.0;
        find(&r, 0, DOFS, &log[i]);
        r.dry[LEG][0] -= i == 1 ? 40.0 : 0.0, r.dry[LEG][1] -= i == 1 ? 40.0 : 0.0;
    }
    struct agreement a = agreement_of(&r, LOGS, log);
    bool used[AGREEMENT_LOGS][AGREEMENT_VALUES] = {{0}};
    struct agreement_place worst;
    assert_true(!a.agree && a.probability < 1e-9 && agreement_worst(&a, used, &worst));
    assert_int_equal(worst.log, 1);
    assert_int_equal((worst.value - UNKNOWN_DRY) / 2, LEG);
    assert_true(a.deviation[1][worst.value] > 0.0);
    for (int c = 0; c < MATRIX_ENTRIES; c++) assert_false(a.apart[1][c]);
}

/* Two logs give one value, with noise of 3. The first held the compliance to a thousandth of 2e-8
 * m/N, and 2e-8 would change its value by 4; the second tells the compliance. Their difference of
 * 10 has the variance 2 * 3^2 + 4^2. */
static void logs_with_other_priors_of_the_compliance_are_compared_in_one_unit(void **unused) {
    (void)unused;
    static struct log log[2];
    struct rig r;
    rig_init(&r, 100.0);
    memset(log, 0, sizeof log);
    for (int l = 0; l < 2; l++) {
        for (int i = 0; i < DOFS * DOFS; i++) log[l].result.matrix.mt[i / DOFS][i % DOFS] = i ? (double)NAN : 0.0;
        for (int i = 0; i < LEGS; i++) log[l].result.viscous[i] = log[l].result.dry[i][0] = log[l].result.dry[i][1] = (double)NAN;
        for (int i = 0; i < DOFS; i++) log[l].result.spring[i] = (double)NAN;
        log[l].estimate.noise[0][0] = 9.0, log[l].estimate.compliance_prior = l ? 2e-8 : 2e-11;
    }
    log[0].estimate.value[0] = 10.0, log[0].estimate.common[SYSTEMATIC_COMPLIANCE][0] = 4e-3;
    struct agreement a = agreement_of(&r, 2, log);
    assert_int_equal(a.degrees, 1);
    assert_close(a.chi_square, 100.0 / 34.0, 1e-9);
}

/* A hundred parts of a long motion: the third and the last are bad, and from the 65th on one leg
 * has more friction. All count, in groups of eight. Eight draws of noise alternate, because the
 * same draw in every part would be a difference that no repeat reduces. */
static void many_parts_are_joined_and_a_change_on_the_way_is_seen(void **unused) {
    (void)unused;
    slow_case();
    enum { ALL = 100, FROM = 64, LEG = 4, DRAWS = 8 };
    static struct equations part[2 * DRAWS];
    static struct log log, sum;
    static struct parts parts;
    struct agreement a;
    struct error error, good = {0}, bad = {.status = STATUS_USAGE};
    double expected[UNKNOWNS] = {0};
    struct rig r;
    rig_init(&r, 100.0);
    r.noise_m = 15e-6, r.noise_pa = 2e4;
    for (int i = 0; i < 2 * DRAWS; i++) {
        for (int s = 0; s < 2 && i == DRAWS; s++) r.dry[LEG][s] += 40.0;
        find(&r, 0, DOFS, &log);
        part[i] = log.equations;
    }
    assert_int_equal(parts_init(&parts, &error), 0);
    for (int i = 0; i < ALL; i++) {
        const struct equations *e = &part[i % DRAWS + (i < FROM ? 0 : DRAWS)];
        bool left_out = i == 2 || i == ALL - 1;
        parts_add(&parts, e, left_out ? &bad : &good);
        for (int c = 0; c < UNKNOWNS && !left_out; c++) expected[c] += e->product[c][c];
    }
    assert_int_equal(parts_sum(&parts, &r.configured, &sum.equations, &a, &error), 0);
    assert_true(parts.all == ALL && parts.left_out == 2 && a.logs > 2 && a.logs <= PARTS && !a.agree);
    for (int c = 0; c < UNKNOWNS; c++) assert_true(fabs(sum.equations.product[c][c] - expected[c]) <= 1e-9 * expected[c]);
    bool used[AGREEMENT_LOGS][AGREEMENT_VALUES] = {{0}};
    struct agreement_place worst;
    assert_true(agreement_worst(&a, used, &worst) && (worst.value - UNKNOWN_DRY) / 2 == LEG);
    parts_clear(&parts);
    assert_int_equal(parts.count, 0);
    parts_free(&parts);
}

/* The expected values are from tables for 5 % and one in a thousand. */
static void chi_square_is_that_of_tables(void **unused) {
    (void)unused;
    assert_close(agreement_chi_square_above(3.841459, 1), 0.05, 1e-7);
    assert_close(agreement_chi_square_above(5.991465, 2), 0.05, 1e-7);
    assert_close(agreement_chi_square_above(16.26624, 3), 1e-3, 1e-8);
    assert_close(agreement_chi_square_above(124.3421, 100), 0.05, 1e-7);
    assert_true(agreement_chi_square_above(0.0, 5) == 1.0);
    assert_below(agreement_chi_square_above(1e5, 39), 1e-300);
}

/* Covers machines with different noise and friction: none, Coulomb's, Dahl's. The 21 errors of a
 * machine are correlated, so the bounds are 0.5 to 1.5. */
static void the_stated_deviation_is_that_of_the_errors(void **unused) {
    (void)unused;
    slow_sweep();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    const int seeds = more_cases() ? 12 : 6;
    double square = 0.0, scatter = 0.0;
    for (int seed = 0; seed < seeds; seed++) {
        struct rig r;
        rig_init(&r, seed % 3 ? 100.0 : 0.0);
        r.presliding_m = seed % 3 == 2 ? 100e-6 : 0.0;
        r.seed = (uint64_t)seed + 77;
        r.noise_m = 15e-6, r.noise_pa = 2e4;
        struct method_c m = found(&r, DOFS);
        scatter += m.scatter / seeds;
        square += mean_square(&m, &r) / seeds;
    }
    print_message("errors of 21 entries, %d machines: %.2f deviations rms; rows scatter by %.2f of the noise\n", seeds, sqrt(square),
                  scatter);
    assert_below(square, 1.5);
    assert_below(0.4, square);
    assert_close(scatter, 1.0, 0.15);
}

/* Moves the joints by up to 1 mm in each coordinate from the configured places. */
static void move_joints(struct rig *r) {
    static const double most_m = 1e-3, neutral[DOFS] = {0};
    int place = effect_find("geometry_error");
    r->configured.model.tolerance.joints_m = most_m;
    r->machine.effects[place].on = true;
    for (int k = 0; k < LEGS; k++)
        for (int i = 0; i < 3; i++) {
            double upper = most_m * random_unit(&r->seed), lower = most_m * random_unit(&r->seed);
            r->kinematics.upper[k][i] += upper, r->kinematics.lower[k][i] += lower;
            r->machine.effects[place].value[i][k] = upper, r->machine.effects[place].value[3 + i][k] = lower;
        }
    nominal_matrix(&r->machine, &r->kinematics, neutral, r->nominal);
    inverse_dynamics_init(&r->inverse, &r->machine, 0.0, 0.0);
}

static void joints_within_their_tolerance_are_in_the_stated_deviation(void **unused) {
    (void)unused;
    long_case();
    if (SANITIZED) skip_because(MINUTES_UNDER_SANITIZERS);
    enum { MACHINES = 12 };
    double square = 0.0;
    for (int machine = 0; machine < MACHINES; machine++) {
        struct rig r;
        rig_init(&r, 0.0);
        r.seed = (uint64_t)machine + 5;
        move_joints(&r);
        struct method_c m = found(&r, DOFS);
        square += mean_square(&m, &r) / MACHINES;
    }
    print_message("joints off by up to 1 mm: errors of 21 entries, %d machines: %.2f deviations rms\n", MACHINES, sqrt(square));
    assert_below(square, 1.7);
    assert_below(0.3, square);
}

/* Asserts that exact sensors and all six tests give the matrix; coupling entries must agree to the
 * relative error `coupling`. */
static void assert_matrix_found(struct rig *r, double coupling) {
    struct method_c m = found(r, DOFS);
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) assert_close(m.matrix.mt[i][j], r->nominal[i][j], 0.01 * sqrt(r->nominal[i][i] * r->nominal[j][j]));
    assert_close(m.matrix.mt[0][4], r->nominal[0][4], coupling * r->nominal[0][4]);
    assert_close(m.matrix.mt[1][3], r->nominal[1][3], coupling * fabs(r->nominal[1][3]));
}

/* None of these lengths is among the fitted ones, but their combination leaves less than a
 * hundredth of 200 N. With Coulomb's law alone the matrix would be off by a quarter at 50 um, and
 * by more than itself at 200 um. */
static void a_seal_that_gives_before_it_slides_leaves_the_matrix_as_it_is(void **unused) {
    (void)unused;
    numbers_case();
    static const double give_m[] = {10e-6, 50e-6, 100e-6, 200e-6};
    for (int n = 0; n < (int)(sizeof give_m / sizeof give_m[0]); n++) {
        struct rig r;
        rig_init(&r, 200.0);
        r.presliding_m = give_m[n];
        assert_matrix_found(&r, 0.015);
    }
}

/* Accuracy required if the law of friction is not among the fitted ones. */
static const double UNASSUMED = 0.03;

/* None of these speeds is fitted; friction at rest is twice Coulomb's. */
static void friction_that_is_higher_at_low_speed_leaves_the_matrix_as_it_is(void **unused) {
    (void)unused;
    numbers_case();
    static const double slow_mps[] = {0.010, 0.016, 0.025, 0.040};
    for (int n = 0; n < (int)(sizeof slow_mps / sizeof slow_mps[0]); n++) {
        struct rig r;
        rig_init(&r, 100.0);
        r.slow_share = 1.0, r.slow_mps = slow_mps[n];
        assert_matrix_found(&r, UNASSUMED);
    }
}

/* Seals that are deflected, and friction that is higher at low speed, at once: the faster the leg,
 * the less the basis functions of seals have to compensate. */
static void a_seal_that_gives_and_slides_harder_at_low_speed_leaves_the_matrix_as_it_is(void **unused) {
    (void)unused;
    numbers_case();
    static const double give_m[] = {50e-6, 100e-6};
    for (int n = 0; n < (int)(sizeof give_m / sizeof give_m[0]); n++) {
        struct rig r;
        rig_init(&r, 100.0);
        r.slow_share = 0.5, r.slow_mps = 0.02, r.presliding_m = give_m[n];
        assert_matrix_found(&r, UNASSUMED);
    }
}

/* The mean pressures of the tests differ, and with them the constant part of the friction. */
static void friction_that_goes_with_the_pressures_leaves_the_matrix_as_it_is(void **unused) {
    (void)unused;
    numbers_case();
    struct rig r;
    rig_init(&r, 50.0);
    r.load_mu = 0.02;
    for (int d = 0; d < DOFS; d++) r.pressure_pa[d] = 4e6 + 0.4e6 * d;
    assert_matrix_found(&r, UNASSUMED);
}

extern const struct effect external_stiffness;

/* Hoses act as springs of 5 to 8 N/mm: at one frequency like an inertia of -K / w^2, which the
 * interval then includes; two frequencies separate them. */
static void springs_that_may_be_there_are_told_from_inertia_by_a_second_frequency(void **unused) {
    (void)unused;
    slow_case();
    static const double spring[DOFS] = {8e3, 6e3, 5e3, 1e3, 800.0, 1.5e3};
    static struct log one, other, both;
    struct rig r;
    rig_init(&r, 80.0);
    r.noise_m = 10e-6, r.noise_pa = 5e3;
    r.machine.effects[effect_find("external_stiffness")].on = true;
    for (int i = 0; i < DOFS; i++) r.machine.effects[effect_find("external_stiffness")].value[i][0] = spring[i];
    inverse_dynamics_init(&r.inverse, &r.machine, 0.0, 0.0);
    r.configured.model.tolerance.springs_n_per_m = 1e4, r.configured.model.tolerance.springs_nm_per_rad = 2e3;
    find(&r, 0, DOFS, &one);
    for (int i = 0; i < DOFS; i++) {
        assert_true(one.result.springs && isnan(one.result.spring[i]));
        assert_close(one.result.matrix.mt[i][i], r.nominal[i][i], 2.0 * one.result.matrix.mt_std[i][i]);
    }
    for (int i = 0; i < DOFS; i++) r.configured.tests.hz[i] = 2.0;
    find(&r, 0, DOFS, &other);
    both = one;
    equations_add(&both.equations, &other.equations);
    solve(&r, &both);
    for (int i = 0; i < DOFS; i++) {
        assert_close(both.result.matrix.mt[i][i], r.nominal[i][i], 3.0 * both.result.matrix.mt_std[i][i]);
        assert_close(both.result.matrix.mt[i][i], r.nominal[i][i], 0.02 * r.nominal[i][i]);
        assert_close(both.result.spring[i], spring[i], 3.0 * both.result.spring_std[i]);
        assert_below(both.result.spring_std[i], 0.1 * spring[i]);
    }
    /* springs that the configuration does not allow for are taken for inertia: 13 kg in x */
    r.configured.model.tolerance.springs_n_per_m = r.configured.model.tolerance.springs_nm_per_rad = 0.0;
    for (int i = 0; i < DOFS; i++) r.configured.tests.hz[i] = 4.0;
    find(&r, 0, DOFS, &one);
    assert_true(!one.result.springs && one.result.matrix.mt[0][0] < r.nominal[0][0] - 10.0);
}

/* Returns a nearly normal number of variance 1: a sum of uniform ones of variance 1/3 each. */
static double normal(uint64_t *seed) {
    double sum = 0.0;
    for (int i = 0; i < 12; i++) sum += random_unit(seed);
    return 0.5 * sum;
}

/* Gains, zeros and skew are drawn from their priors. With them in the estimate its deviations agree
 * with its errors, and without them they are far too small. */
static void sensors_within_their_tolerances_are_in_the_stated_deviation(void **unused) {
    (void)unused;
    long_case();
    enum { MACHINES = 6 };
    double square[2] = {0};
    for (int m = 0; m < MACHINES; m++) {
        struct rig r;
        rig_init(&r, 100.0);
        r.seed = 100 + (uint64_t)m, r.noise_m = 15e-6, r.noise_pa = 2e4;
        r.configured.sensors.enabled = true;
        double prior[SYSTEMATICS];
        systematic_priors(&r.configured, true, prior);
        for (int i = 0; i < SYSTEMATIC_LAG; i++) r.error[i] = prior[i] * normal(&r.seed);
        struct method_c with = found(&r, DOFS);
        r.configured.sensors.enabled = false;
        struct method_c without = found(&r, DOFS);
        square[0] += mean_square(&with, &r) / MACHINES, square[1] += mean_square(&without, &r) / MACHINES;
    }
    print_message("sensors within their tolerances: errors are %.2f deviations rms, %.2f without them in the estimate\n", sqrt(square[0]),
                  sqrt(square[1]));
    assert_below(sqrt(square[0]), 1.2);
    assert_true(sqrt(square[0]) > 0.5 && square[1] > 2.0 * square[0]);
}

/* Legs that give by 50 N/um read a motion that is too large by what the force compresses, the more
 * the higher the frequency, so two frequencies tell them from a mass. */
static void legs_that_give_do_not_weigh(void **unused) {
    (void)unused;
    numbers_case();
    struct rig r;
    static struct log log, sum;
    rig_init(&r, 0.0);
    r.noise_m = 15e-6, r.noise_pa = 2e4, r.compliance_m_per_n = 2e-8;
    r.configured.sensors.enabled = true;
    for (int allowed = 0; allowed < 2; allowed++) {
        sum.equations = (struct equations){0};
        r.configured.model.tolerance.compliance_m_per_n = allowed ? r.compliance_m_per_n : 0.0;
        for (int l = 0; l < 2; l++) {
            for (int d = 0; d < DOFS; d++) r.configured.tests.hz[d] = l ? 7.0 : 4.0;
            find(&r, 0, DOFS, &log);
            equations_add(&sum.equations, &log.equations);
        }
        solve(&r, &sum);
        const struct systematic_found *e = &sum.result.systematic[SYSTEMATIC_COMPLIANCE];
        print_message("compliance %.3g +- %.2g\n", e->value, e->std);
        double z = (sum.result.matrix.mt[0][0] - r.nominal[0][0]) / sum.result.matrix.mt_std[0][0];
        if (!allowed) {
            assert_true(fabs(z) > 4.0 && e->prior == 0.0);
            continue;
        }
        assert_below(fabs(z), 3.0);
        assert_close(e->value, r.compliance_m_per_n, 3.0 * e->std);
        assert_below(e->std, 0.3 * e->prior);
    }
}

/* Where legs do not give, the prior of their compliance is narrowed to nearly nothing or to what
 * chance shows, and the mass is hardly less sure. */
static void legs_that_do_not_give_cost_little(void **unused) {
    (void)unused;
    numbers_case();
    enum { MACHINES = 4 };
    for (int m = 0; m < MACHINES; m++) {
        struct rig r;
        rig_init(&r, 50.0);
        r.seed = 300 + (uint64_t)m;
        r.configured.sensors.enabled = true, r.noise_m = 15e-6, r.noise_pa = 2e4;
        struct method_c given = found(&r, DOFS);
        r.configured.model.tolerance.compliance_m_per_n = 0.0;
        struct method_c stiff = found(&r, DOFS);
        const struct systematic_found *e = &given.systematic[SYSTEMATIC_COMPLIANCE];
        double more = given.matrix.mt_std[0][0] / stiff.matrix.mt_std[0][0];
        print_message("legs that do not give: compliance %.3g +- %.2g, mx is less sure by a factor of %.2f\n", e->value, e->std, more);
        /* the deviation is that of the data, however far the prior was narrowed */
        assert_below(fabs(e->value), 3.0 * 5e-9);
        assert_true(e->std > 2e-9 && e->std < 8e-9);
        assert_below(more, 1.35);
    }
}

/* A recorder that is started anew for each test has another skew in each. Taken for one skew, these
 * would be inertia, by viscous friction that lags. */
static void skews_of_single_tests_are_in_the_stated_deviation(void **unused) {
    (void)unused;
    numbers_case();
    enum { MACHINES = 3 };
    double square[2] = {0};
    for (int m = 0; m < MACHINES; m++) {
        struct rig r;
        rig_init(&r, 50.0);
        r.seed = 200 + (uint64_t)m, r.noise_m = 15e-6, r.noise_pa = 2e4;
        r.configured.sensors.enabled = true;
        for (int d = 0; d < DOFS; d++) r.skew_s[d] = 1e-3 * normal(&r.seed);
        struct method_c with = found(&r, DOFS);
        r.configured.model.tolerance.skew_test_s = 0.0;
        struct method_c without = found(&r, DOFS);
        square[0] += mean_square(&with, &r) / MACHINES, square[1] += mean_square(&without, &r) / MACHINES;
    }
    print_message("skews of single tests: errors are %.2f deviations rms, %.2f with one skew for all\n", sqrt(square[0]), sqrt(square[1]));
    assert_below(sqrt(square[0]), 1.2);
    assert_true(square[1] > 2.0 * square[0]);
}

/* A gain far beyond its tolerance is found while the others are within theirs. */
static void a_wrong_gain_is_found(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r, 50.0);
    r.configured.sensors.enabled = true, r.noise_m = 5e-6, r.noise_pa = 5e3;
    r.error[SYSTEMATIC_P1_GAIN + 2] = 0.04;
    struct method_c m = found(&r, DOFS);
    for (int i = 0; i < SYSTEMATIC_LENGTH_GAIN; i++) {
        const struct systematic_found *e = &m.systematic[i];
        double z = fabs(e->value) / sqrt(e->prior * e->prior - e->std * e->std);
        if (i == SYSTEMATIC_P1_GAIN + 2) assert_true(z > 5.0 && e->value > 0.0);
        else if (e->std < 0.9 * e->prior) assert_below(z, 3.5);
    }
}

/* No motion shows a gain that all pressures have in common, because it scales masses and friction
 * alike; a known weight shows it. */
static void a_known_weight_finds_the_gain_that_all_pressures_have_in_common(void **unused) {
    (void)unused;
    numbers_case();
    struct rig r;
    const double gain = 0.006;
    rig_init(&r, 50.0);
    r.configured.sensors.enabled = true, r.noise_m = 5e-6, r.noise_pa = 5e3;
    for (int i = 0; i < SYSTEMATIC_LENGTH_GAIN; i++) r.error[i] = gain;
    struct method_c alone = found(&r, DOFS);
    for (int k = 0; k < LEGS; k++) r.configured.found.weight_p1[k] = 1.1 / LEGS, r.configured.found.weight_p2[k] = -0.1 / LEGS;
    r.configured.found.weight_error = gain, r.configured.found.weight_std = 2e-4;
    struct method_c weighed = found(&r, DOFS);
    for (int i = 0; i < 3; i++) {
        double truth = r.nominal[i][i];
        assert_close(alone.matrix.mt[i][i] / truth - 1.0, gain, 2e-3);
        assert_close(weighed.matrix.mt[i][i] / truth - 1.0, 0.0, 1.5e-3);
        assert_below(weighed.matrix.mt_std[i][i], 0.8 * alone.matrix.mt_std[i][i]);
    }
    for (int i = 0; i < SYSTEMATIC_LENGTH_GAIN; i++) assert_close(weighed.systematic[i].value, gain, 3.0 * weighed.systematic[i].std);
}

/* In twelve noisy logs of a small motion, the noise of the accelerations is in the columns of zeros
 * and joints, too. Over many logs the mean of that error becomes larger than chance. */
static void noise_of_small_motion_is_no_error_of_the_drawing(void **unused) {
    (void)unused;
    long_case();
    enum { LOGS = 12 };
    static struct log log, sum;
    struct rig r;
    rig_init(&r, 0.0);
    r.configured.sensors.enabled = true, r.noise_m = 60e-6, r.noise_pa = 2e4;
    for (int d = 0; d < DOFS; d++) r.configured.tests.amplitude[d] *= 0.3;
    sum.equations = (struct equations){0};
    for (int l = 0; l < LOGS; l++) {
        find(&r, 0, DOFS, &log);
        equations_add(&sum.equations, &log.equations);
    }
    solve(&r, &sum);
    double worst = 0.0;
    for (int i = SYSTEMATIC_LENGTH_ZERO; i < SYSTEMATICS; i++) {
        const struct systematic_found *e = &sum.result.systematic[i];
        double seen = e->prior * e->prior - e->std * e->std;
        if (e->prior > 0.0 && seen > 0.01 * e->prior * e->prior) worst = fmax(worst, fabs(e->value) / sqrt(seen));
    }
    print_message("noise in small motion: the worst error is %.1f deviations from zero\n", worst);
    assert_below(worst, 4.0);
}

/* Rounding errors that repeat in every cycle do not show in the scatter of the cycles. But the
 * samples show the step of the rounding, whatever the configuration states about the sensors. */
static void rounding_by_a_bus_is_no_misfit(void **unused) {
    (void)unused;
    struct rig r;
    rig_init(&r, 0.0);
    r.step_m = 5e-6, r.step_pa = 1e3;
    static struct log log;
    find(&r, 0, DOFS, &log);
    struct method_c m = log.result;
    print_message("lengths in steps of 5 um: residuals are %.2f times their noise\n", m.scatter);
    /* the noise repeats almost completely, so each test's rows count as one degree of freedom */
    assert_true(log.equations.repeating > 10.0 * 2.0 * log.equations.free);
    assert_true(m.scatter > 0.3);
    assert_below(m.scatter, 1.5); /* without the rounding's step this would be 57 */
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(springs_that_may_be_there_are_told_from_inertia_by_a_second_frequency),
                                       cmocka_unit_test(dry_friction_of_each_leg_leaves_the_matrix_as_it_is),
                                       cmocka_unit_test(a_seal_that_gives_before_it_slides_leaves_the_matrix_as_it_is),
                                       cmocka_unit_test(friction_that_is_higher_at_low_speed_leaves_the_matrix_as_it_is),
                                       cmocka_unit_test(a_seal_that_gives_and_slides_harder_at_low_speed_leaves_the_matrix_as_it_is),
                                       cmocka_unit_test(friction_that_goes_with_the_pressures_leaves_the_matrix_as_it_is),
                                       cmocka_unit_test(force_less_what_the_found_matrix_needs_is_the_friction_found),
                                       cmocka_unit_test(the_payload_is_found_with_its_centre),
                                       cmocka_unit_test(what_no_test_tells_is_no_number),
                                       cmocka_unit_test(friction_that_no_test_tells_is_no_number),
                                       cmocka_unit_test(repeats_shrink_the_noise_and_not_what_they_have_in_common),
                                       cmocka_unit_test(what_one_log_leaves_open_another_gives),
                                       cmocka_unit_test(logs_that_differ_by_noise_agree),
                                       cmocka_unit_test(a_leg_that_rubs_in_one_log_is_named),
                                       cmocka_unit_test(logs_with_other_priors_of_the_compliance_are_compared_in_one_unit),
                                       cmocka_unit_test(many_parts_are_joined_and_a_change_on_the_way_is_seen),
                                       cmocka_unit_test(chi_square_is_that_of_tables),
                                       cmocka_unit_test(the_stated_deviation_is_that_of_the_errors),
                                       cmocka_unit_test(joints_within_their_tolerance_are_in_the_stated_deviation),
                                       cmocka_unit_test(sensors_within_their_tolerances_are_in_the_stated_deviation),
                                       cmocka_unit_test(legs_that_give_do_not_weigh),
                                       cmocka_unit_test(legs_that_do_not_give_cost_little),
                                       cmocka_unit_test(skews_of_single_tests_are_in_the_stated_deviation),
                                       cmocka_unit_test(a_wrong_gain_is_found),
                                       cmocka_unit_test(a_known_weight_finds_the_gain_that_all_pressures_have_in_common),
                                       cmocka_unit_test(rounding_by_a_bus_is_no_misfit),
                                       cmocka_unit_test(noise_of_small_motion_is_no_error_of_the_drawing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
