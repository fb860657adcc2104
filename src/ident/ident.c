#include "ident.h"

#include <math.h>
#include <string.h>

#include "params.h"
#include "units.h"

enum { CHANNELS = 2 * DOFS };

/* Share of the evaluated part that a complete test must cover; less than 1, because recorded times
 * are rounded. */
static const double complete_share = 0.999;

const struct ident_entry ident_entries[IDENT_ENTRIES] = {
    {"mx", 0, 0, "kg"},      {"my", 1, 1, "kg"},     {"mz", 2, 2, "kg"},     {"Ixx", 3, 3, "kg m^2"}, {"Iyy", 4, 4, "kg m^2"},
    {"Izz", 5, 5, "kg m^2"}, {"Mt15", 0, 4, "kg m"}, {"Mt24", 1, 3, "kg m"}, {"Mt42", 3, 1, "kg m"},  {"Mt51", 4, 0, "kg m"},
};

double ident_error_pct(const struct identification *id, const struct method_result *method, const struct ident_entry *entry) {
    double nominal = id->nominal_mt[entry->row][entry->col];
    return 100.0 * (method->mt[entry->row][entry->col] - nominal) / nominal;
}

double ident_scale(const double mt[DOFS][DOFS], const struct ident_entry *entry) {
    return sqrt(fabs(mt[entry->row][entry->row] * mt[entry->col][entry->col]));
}

int ident_init(struct ident *id, const struct params *params, struct error *error) {
    static const double neutral[DOFS] = {0};
    const char *refusal = params_mechanism(params)->refuses.identify;
    if (refusal) return error_set(error, STATUS_USAGE, "%s", refusal);
    *id = (struct ident){.params = params, .areas = cylinder_areas(&params->actuator), .running = -1, .dof = DOF_NONE};
    int status = kinematics_init(&id->kinematics, params, error);
    if (status == STATUS_OK) nominal_matrix(params, &id->kinematics, neutral, id->result.nominal_mt);
    return status;
}

/* Finds the legs whose length this test moves by more than two of the sensor's steps, so that the
 * reading changes at least twice a period. */
static void find_moving(const struct ident *id, enum dof dof, bool moves[LEGS]) {
    double pose[DOFS] = {0}, high_m[LEGS], low_m[LEGS];
    pose[dof] = id->params->tests.amplitude[dof];
    ik_lengths(&id->kinematics, pose, high_m);
    pose[dof] = -pose[dof];
    ik_lengths(&id->kinematics, pose, low_m);
    for (int i = 0; i < LEGS; i++) moves[i] = fabs(high_m[i] - low_m[i]) > 2.0 * id->params->sensors.position_resolution_m;
}

static void open_test(struct ident *id, const struct cycle *c) {
    bool moves[LEGS];
    id->running = c->test;
    id->dof = c->dof;
    id->seen = id->excluded = 0;
    id->low = HUGE_VAL, id->high = -HUGE_VAL;
    id->off_samples = 0;
    memset(id->off_m, 0, sizeof id->off_m);
    id->first_s = c->test_time_s;
    memset(id->pose, 0, sizeof id->pose);
    double hz = id->params->tests.hz[c->dof];
    find_moving(id, c->dof, moves);
    witness_reset(&id->witness, hz, id->params->loop.period_s, moves);
    harmonics_reset(&id->fit, 2.0 * PI * hz, id->params->tests.harmonics, CHANNELS);
}

/* Computes pose and wrench of a sample. Returns why the sample is excluded, or REFUSED_NOT. */
static enum refusal measure(struct ident *id, const struct cycle *c, double values[CHANNELS], double force_n[LEGS]) {
    enum refusal why = refusal_of(c, LEGS);
    if (why) return why;
    if (!isfinite(c->test_time_s)) return REFUSED_NO_NUMBER;
    if (!fk_solve(&id->kinematics, c->in.length_m, id->pose).converged) return REFUSED_NO_POSE;
    for (int i = 0; i < LEGS; i++) force_n[i] = leg_force(&id->areas, i, c->in.p1_pa[i], c->in.p2_pa[i]);
    memcpy(values, id->pose, sizeof id->pose);
    wrench_from_forces(&id->kinematics, id->pose, force_n, values + DOFS);
    for (int i = 0; i < CHANNELS; i++)
        if (!isfinite(values[i])) return REFUSED_NO_NUMBER;
    return REFUSED_NOT;
}

/* Adds the differences between a good sample's lengths and the lengths in its reference pose. Adds
 * nothing if the reference is not complete. */
static void compare_reference(struct ident *id, const struct cycle *c) {
    double asked_m[LEGS];
    for (int i = 0; i < DOFS; i++)
        if (!isfinite(c->ref[i])) return;
    ik_lengths(&id->kinematics, c->ref, asked_m);
    for (int i = 0; i < LEGS; i++) id->off_m[i] += c->in.length_m[i] - asked_m[i];
    id->off_samples++;
}

static void take(struct ident *id, const struct cycle *c) {
    double values[CHANNELS], force_n[LEGS] = {0};
    id->refused = measure(id, c, values, force_n);
    id->seen++;
    if (isfinite(c->ref[id->dof])) id->low = fmin(id->low, c->ref[id->dof]), id->high = fmax(id->high, c->ref[id->dof]);
    id->last_s = c->test_time_s;
    witness_add(&id->witness, c->test_time_s - id->first_s, &c->in, force_n, !id->refused);
    if (!id->refused) {
        harmonics_add(&id->fit, c->test_time_s, values);
        compare_reference(id, c);
    } else id->excluded++;
}

/* Makes room for a test's result. A second test of an axis replaces the first, because the machine
 * may have been changed in between. */
static struct test_result *append(struct identification *r, enum dof dof) {
    int kept = 0;
    for (int i = 0; i < r->tests; i++)
        if (r->test[i].dof != dof) r->test[kept++] = r->test[i];
        else r->replaced[dof]++;
    r->tests = kept + 1;
    return &r->test[kept];
}

static void summarize(struct test_result *t) {
    const double *own = t->pose[t->dof];
    t->achieved_amplitude = hypot(own[0], own[1]);
    t->phase_deg = deg_from_rad(atan2(own[1], own[0]));
}

/* Amplitude of an axis's own test: that of the recorded reference, or the configured one while
 * there is no complete test of this axis with a reference. */
static double own_amplitude(const struct ident *id, enum dof dof) {
    for (int i = 0; i < id->result.tests; i++) {
        const struct test_result *t = &id->result.test[i];
        if (t->dof == dof && !t->refused && t->asked_amplitude > 0.0) return t->asked_amplitude;
    }
    return id->params->tests.amplitude[dof];
}

/* Computes the unwanted motion of all tests again, because each test that ends may bring the
 * amplitude of one more axis. */
static void find_unwanted(struct ident *id) {
    for (int dof = 0; dof < DOFS; dof++) {
        double amplitude = own_amplitude(id, (enum dof)dof);
        for (int i = 0; i < id->result.tests; i++) {
            struct test_result *t = &id->result.test[i];
            t->unwanted_pct[dof] = dof == (int)t->dof ? 0.0 : 100.0 * hypot(t->pose[dof][0], t->pose[dof][1]) / amplitude;
        }
    }
}

static void find_farthest(const struct ident *id, struct test_result *t) {
    for (int i = 0; i < LEGS && id->off_samples > 0; i++) {
        double off_m = id->off_m[i] / (double)id->off_samples;
        if (fabs(off_m) > fabs(t->off_m)) t->off_m = off_m, t->off_leg = i;
    }
}

static void close_test(struct ident *id) {
    const struct test_params *p = &id->params->tests;
    struct test_result *t = append(&id->result, id->dof);
    struct harmonics_fit fit;
    bool solved = harmonics_solve(&id->fit, &fit);
    /* n samples cover n loop periods, though the first and the last are n - 1 loop periods
     * apart. */
    double step_s = (id->last_s - id->first_s) / (double)(id->seen - 1), span_s = step_s * (double)id->seen;
    enum refusal why = !(span_s >= complete_share * p->duration_s) ? REFUSED_INCOMPLETE : solved ? REFUSED_NOT : REFUSED_UNDETERMINED;
    *t = (struct test_result){.test = id->running,
                              .dof = id->dof,
                              .asked_amplitude = id->high >= id->low ? 0.5 * (id->high - id->low) : (double)NAN,
                              .frequency_hz = p->hz[id->dof],
                              .amplitude = p->amplitude[id->dof],
                              .samples = id->fit.samples,
                              .excluded = id->excluded,
                              .step_s = step_s,
                              .witness = witness_says(&id->witness),
                              .refused = why};
    for (int i = 0; i < DOFS; i++) {
        t->pose[i][0] = fit.sine[i][0], t->pose[i][1] = fit.cosine[i][0];
        t->wrench[i][0] = fit.sine[DOFS + i][0], t->wrench[i][1] = fit.cosine[DOFS + i][0];
        t->pose_rms[i] = fit.rms[i], t->wrench_rms[i] = fit.rms[DOFS + i];
        t->pose_std[i] = fit.std[i], t->wrench_std[i] = fit.std[DOFS + i];
    }
    summarize(t);
    find_farthest(id, t);
    find_unwanted(id);
    id->running = -1;
}

bool ident_end(struct ident *id) {
    bool ended = id->running >= 0;
    if (ended) close_test(id);
    return ended;
}

bool ident_feed(struct ident *id, const struct cycle *c) {
    bool evaluated = c->phase == PHASE_EVALUATE && c->test >= 0 && c->dof >= DOF_X && c->dof <= DOF_PSI;
    id->refused = REFUSED_NOT;
    bool same = evaluated && c->test == id->running && c->dof == id->dof;
    bool ended = !same && ident_end(id);
    if (evaluated && !same) open_test(id, c);
    if (evaluated) take(id, c);
    return ended;
}

bool ident_solve(struct ident *id) {
    struct identification *r = &id->result;
    const struct test_result *axis[DOFS] = {0};
    bool all = true;
    for (int i = 0; i < r->tests; i++)
        if (!r->test[i].refused) axis[r->test[i].dof] = &r->test[i];
    for (int i = 0; i < DOFS; i++) all = all && axis[i];
    r->method_a = r->modified_a = r->method_b = (struct method_result){0};
    if (!all) return false;
    r->method_a = method_a(axis);
    r->modified_a = method_modified_a(&r->method_a, r->nominal_mt);
    r->method_b = method_b(axis);
    return r->method_a.evaluated && r->method_b.evaluated;
}
