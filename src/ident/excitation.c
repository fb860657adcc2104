#include "excitation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "force.h"
#include "inverse_dynamics.h"
#include "kinematics.h"
#include "params.h"
#include "admit.h"
#include "reference.h"

/* The surveyed machine, as it is simulated. */
struct imagined {
    const struct loop_survey *survey;
    /* configuration with the tests asked for and the viscous friction found, without effects */
    struct params params;
    struct kinematics kinematics;
    struct cylinder_areas areas;
    struct inverse_dynamics dynamics;
    double follow[DOFS];            /* amplitude that each axis reaches, as a share of the
                                     * reference's amplitude */
    double dry_n[LEGS];
    double length_m[3][LEGS];       /* lengths of the last three cycles, oldest first */
    uint64_t random;
    struct measured_recording measured; /* the simulated recording as method C takes it
                                         * (measured.h) */
};

/* Uniform random number with mean zero and this standard deviation. */
static double noise(struct imagined *m, double std) {
    m->random = m->random * 6364136223846793005u + 1442695040888963407u;
    return sqrt(3.0) * std * (double)(int64_t)m->random / 9223372036854775808.0;
}

static int init(struct imagined *m, const struct loop_survey *survey, const struct params *params, const struct test_params *tests,
                uint64_t seed, struct error *error) {
    *m = (struct imagined){.survey = survey, .params = *params, .areas = cylinder_areas(&params->actuator), .random = seed};
    m->params.tests = *tests;
    for (int e = 0; e < EFFECTS_MAX; e++) m->params.effects[e].on = false;
    for (int i = 0; i < DOFS; i++) m->follow[i] = cabs(loop_survey_follow(survey, (enum dof)i, tests->hz[i]));
    for (int k = 0; k < LEGS; k++) {
        const struct method_c *c = &survey->inertia;
        double dry_n = 0.5 * (c->dry[k][0] + c->dry[k][1]), std = 0.5 * hypot(c->dry_std[k][0], c->dry_std[k][1]);
        m->dry_n[k] = dry_n > 2.0 * std ? dry_n : 0.0;
        m->params.hydraulics.viscous_n_s_per_m[k] = fmax(c->viscous[k], 0.0);
    }
    int status = kinematics_init(&m->kinematics, &m->params, error);
    inverse_dynamics_init(&m->dynamics, &m->params, 0.0, 0.0);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < LEGS; k++) m->length_m[i][k] = m->kinematics.neutral_length_m[k];
    return status;
}

/* Reads a length with noise and rounding. The survey's noise contains the rounding, which is
 * therefore subtracted from it first. */
static double read_length(struct imagined *m, int leg, double length_m) {
    double step_m = m->params.sensors.enabled ? m->params.sensors.position_resolution_m : 0.0;
    double jitter = sqrt(fmax(pow(m->survey->noise_m[leg], 2.0) - step_m * step_m / 12.0, 0.0)), read = length_m + noise(m, jitter);
    return step_m > 0.0 ? step_m * round(read / step_m) : read;
}

/* Makes the sample of the middle one of three cycles; the other two give the rates and
 * accelerations. Returns false if no pose has these lengths. */
static bool sample_of(struct imagined *m, double test_time_s, const double ref[DOFS], struct recording_sample *s) {
    struct inverse_dynamics_input in = {0};
    double dt_s = m->params.loop.period_s, force_n[LEGS];
    for (int k = 0; k < LEGS; k++) {
        double before_m = m->length_m[0][k], now_m = m->length_m[1][k], next_m = m->length_m[2][k];
        in.leg[k][0] = now_m, in.leg[k][1] = (next_m - before_m) / (2.0 * dt_s);
        in.leg[k][2] = (next_m - 2.0 * now_m + before_m) / (dt_s * dt_s);
    }
    if (!inverse_dynamics_step(&m->dynamics, &in, force_n)) return false;
    *s = (struct recording_sample){.test_time_s = test_time_s, .clock_s = test_time_s};
    memcpy(s->ref, ref, sizeof s->ref);
    for (int k = 0; k < LEGS; k++) {
        double rate = in.leg[k][1], dry_n = m->dry_n[k] * ((rate > 0.0) - (rate < 0.0)), rod_pa = m->survey->mean_pa[1][k];
        s->length_m[k] = read_length(m, k, in.leg[k][0]);
        s->p1_pa[k] = (force_n[k] + dry_n + m->areas.a2_m2[k] * rod_pa) / m->areas.a1_m2[k] + noise(m, m->survey->noise_pa[0][k]);
        s->p2_pa[k] = rod_pa + noise(m, m->survey->noise_pa[1][k]);
        s->force_n[k] = leg_force(&m->areas, k, s->p1_pa[k], s->p2_pa[k]);
    }
    return true;
}

/* Simulates one test, its ramp-in and evaluated part, and adds it in the form that recording_add()
 * gives it. */
static int add_test(struct imagined *m, int place, struct recording *recording, struct error *error) {
    const struct test_params *t = &m->params.tests;
    enum dof dof = tests_single(t) ? t->order[place] : DOF_NONE;
    double hz = dof == DOF_NONE ? (double)NAN : t->hz[dof], amplitude = dof == DOF_NONE ? (double)NAN : t->amplitude[dof];
    struct recording_test *test = &recording->test[recording->tests++];
    struct reference r;
    struct reference_sample now = {0}, next = {0};
    *test = (struct recording_test){.test = place, .dof = dof, .frequency_hz = hz, .stated_hz = hz, .amplitude = amplitude, .first = -1};
    reference_test(&r, dof, NULL, t, m->params.loop.period_s);
    r.ticks = -1;
    for (int status = 0; next.phase != PHASE_RAMP_OUT; now = next) {
        double pose[DOFS];
        struct recording_sample s;
        next = reference_step(&r, t, m->params.loop.period_s);
        for (int i = 0; i < DOFS; i++) pose[i] = m->follow[i] * next.pose[i];
        memmove(m->length_m[0], m->length_m[1], 2 * sizeof m->length_m[0]);
        ik_lengths(&m->kinematics, pose, m->length_m[2]);
        if (now.phase != PHASE_RAMP_IN && now.phase != PHASE_EVALUATE) continue;
        if (!sample_of(m, now.test_time_s, now.pose, &s))
            return error_set(error, STATUS_USAGE, "no pose of this machine has these lengths");
        if ((status = recording_append(test, &s, error))) return status;
        if (test->first < 0 && (dof == DOF_NONE || now.phase == PHASE_EVALUATE)) test->first = test->count - 1;
        test->end = test->count;
    }
    return STATUS_OK;
}

/* Standard deviation of an entry of the matrix in per cent of sqrt(M_ii M_jj); infinite if it is
 * not determined. */
static double entry_pct(const struct method_result *m, int i, int j) {
    double pct = 100.0 * m->mt_std[i][j] / sqrt(m->mt[i][i] * m->mt[j][j]);
    return m->evaluated && isfinite(pct) ? pct : (double)INFINITY;
}

struct excitation excitation_of(int draws, const struct method_result *matrix) {
    struct excitation e = {0};
    double sum_pct[DOFS][DOFS] = {{0}}, largest_pct = 0.0;
    for (int draw = 0; draw < draws; draw++) {
        double worst_pct = 0.0, axis_pct[DOFS] = {0};
        for (int i = 0; i < DOFS; i++)
            for (int j = i; j < DOFS; j++) {
                double pct = entry_pct(&matrix[draw], i, j);
                sum_pct[i][j] += pct;
                axis_pct[i] = fmax(axis_pct[i], pct), axis_pct[j] = fmax(axis_pct[j], pct);
                worst_pct = fmax(worst_pct, pct);
            }
        e.worst_pct += worst_pct;
        for (int i = 0; i < DOFS; i++) e.axis_pct[i] += axis_pct[i];
    }
    e.worst_pct /= draws;
    for (int i = 0; i < DOFS; i++) e.axis_pct[i] /= draws;
    for (int i = 0; i < DOFS; i++)
        for (int j = i; j < DOFS; j++)
            if (sum_pct[i][j] > largest_pct) largest_pct = sum_pct[i][j], e.row = (enum dof)i, e.column = (enum dof)j;
    return e;
}

/* Simulates one recording of all tests and runs method C on it. */
static int identify(struct imagined *m, struct recording *recording, struct method_c *c, struct error *error) {
    int status = STATUS_OK;
    recording_init(recording, &m->params);
    recording->measured = (struct recording_measured){.force = true, .pressures = true, .reference = true};
    for (int i = 0; i < tests_count(&m->params.tests) && !status; i++) status = add_test(m, i, recording, error);
    recording_settle(recording);
    struct admission unused = {0};
    if (!status) status = measured_add(&m->measured, recording, error);
    if (!status) status = admit(recording, &m->measured, &unused, error);
    if (!status) status = method_c(&m->measured.recording, c, error);
    measured_free(&m->measured);
    recording_free(recording);
    return status;
}

/* Finds the variance that systematic errors (systematic.h) add to each entry. The variance is the
 * same in every draw, and finding it takes most of the time, so it is found only once, with the
 * first draw. */
static int find_systematic(struct imagined *m, const struct method_result *exact, struct recording *recording, struct method_c *c,
                           double variance[DOFS][DOFS], struct error *error) {
    int status = identify(m, recording, c, error);
    for (int i = 0; i < DOFS; i++)
        for (int j = 0; j < DOFS; j++) {
            double added_variance = pow(c->matrix.mt_std[i][j], 2.0) - pow(exact->mt_std[i][j], 2.0);
            /* NaN: the entry is not determined if such errors exist */
            variance[i][j] = isnan(added_variance) ? (double)INFINITY : fmax(added_variance, 0.0);
        }
    return status;
}

int excitation_predict(const struct loop_survey *survey, const struct params *params, const struct test_params *tests, int draws,
                       struct excitation *result, struct error *error) {
    struct imagined *m = malloc(sizeof *m);
    struct recording *recording = malloc(sizeof *recording);
    struct method_c *c = malloc(2 * sizeof *c);
    struct method_result *found = calloc((size_t)draws, sizeof *found);
    double systematic[DOFS][DOFS] = {{0}};
    *result = (struct excitation){0};
    int status = m && recording && c && found ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
    for (int draw = 0; draw < draws && !status; draw++) {
        status = init(m, survey, params, tests, (uint64_t)draw + 1, error);
        systematic_exclude(&m->params.model.tolerance);
        if (!status) status = identify(m, recording, c, error);
        if (!status && !draw) {
            status = init(m, survey, params, tests, (uint64_t)draw + 1, error);
            if (!status) status = find_systematic(m, &c->matrix, recording, c + 1, systematic, error);
        }
        for (int i = 0; i < DOFS && !status; i++)
            for (int j = 0; j < DOFS; j++) c->matrix.mt_std[i][j] = sqrt(pow(c->matrix.mt_std[i][j], 2.0) + systematic[i][j]);
        if (!status) found[draw] = c->matrix;
    }
    if (!status) *result = excitation_of(draws, found);
    free(found);
    free(m);
    free(recording);
    free(c);
    return status;
}
