#include "weighing.h"

#include <math.h>
#include <string.h>

#include "numeric.h"
#include "params.h"

static const double STEP_M = 1e-5; /* step of difference quotients of the geometry: well above
                                    * rounding, and so small that lengths are linear over it */
static const double SPAN_S = 0.02; /* time over which a leg's sense of motion is found: the leg
                                    * moves by many of its sensor's steps, in a small part of a
                                    * period */
static const double COURSE = 0.2;  /* relative error of the mean dry friction, because its course
                                    * near a reversal is unknown */
static const double LIKELY = 0.2;  /* a weight is refused if its reading is off by more than this
                                    * share of the weight, which exceeds any sensor's error, or if
                                    * the standard deviation exceeds this share */
static const double NO_DRIFT = 5.0; /* a zero does not drift by more than this many standard
                                     * deviations; a larger change of a pressure at rest has another
                                     * cause */
static const double BROKEN_OFF = 0.01; /* a test is left out if its numbers of samples in the two
                                        * logs differ by more than this share */

void weighing_init(struct weighing *w, const struct params *params) {
    *w = (struct weighing){.on = true, .area = cylinder_areas(&params->actuator)};
    w->span = (int)fmin(fmax(round(SPAN_S / params->loop.period_s), 1.0), WEIGHING_SPAN);
    kinematics_place(&w->kinematics, params);
}

/* Returns the sums of this test, which are added if the test is new; NULL if there is no room. */
static struct weighing_test *place(struct weighing *w, const struct cycle *c) {
    int i = 0;
    while (i < w->tests && (w->test[i].test != c->test || w->test[i].dof != c->dof)) i++;
    if (i == WEIGHING_TESTS) return NULL;
    if (i == w->tests) w->test[w->tests++] = (struct weighing_test){.test = c->test, .dof = c->dof};
    return &w->test[i];
}

/* Finds the upward force of each leg on the platform for one unit of its force. Returns false if no
 * pose has these lengths. */
static bool lifts(const struct kinematics *k, const double length_m[LEGS], double pose[DOFS], double lift[LEGS]) {
    double j[LEGS][DOFS];
    if (!fk_solve(k, length_m, pose).converged) return false;
    ik_jacobian(k, pose, j);
    for (int i = 0; i < LEGS; i++) lift[i] = -j[i][DOF_Z];
    return true;
}

/* Adds a cycle's lengths to the ring, and finds the sense of each leg's motion over the span: 1
 * extending, -1 retracting, 0 while the ring is not full. */
static void ways(struct weighing *w, const double length_m[LEGS], double way[LEGS]) {
    double *oldest = w->past_m[w->past % w->span];
    for (int k = 0; k < LEGS; k++) {
        double moved_m = length_m[k] - oldest[k];
        way[k] = w->past < w->span ? 0.0 : (moved_m > 0.0) - (moved_m < 0.0);
    }
    memcpy(oldest, length_m, LEGS * sizeof *length_m);
    w->past++;
}

void weighing_take(struct weighing *w, const struct cycle *c) {
    double lift[LEGS], way[LEGS], sum = 0.0;
    if (!w->on) return;
    if (c->phase == PHASE_SETTLE || c->test < 0) w->past = 0;
    bool begins = c->test >= 0 && (c->phase == PHASE_SETTLE || c->phase == PHASE_RAMP_IN);
    bool evaluated = c->test >= 0 && (c->phase == PHASE_EVALUATE || c->dof == DOF_NONE) && !c->in.flags;
    struct weighing_test *t = begins || evaluated ? place(w, c) : NULL;
    if (t) ways(w, c->in.length_m, way);
    if (t && begins) *t = (struct weighing_test){.test = c->test, .dof = c->dof};
    for (int k = 0; k < LEGS; k++) sum += c->in.p1_pa[k] + c->in.p2_pa[k] + c->in.length_m[k];
    if (!t || begins || !isfinite(sum) || !lifts(&w->kinematics, c->in.length_m, w->pose, lift)) return;
    t->samples++;
    for (int k = 0; k < LEGS; k++) {
        t->lift_n[0][k] += lift[k] * w->area.a1_m2[k] * c->in.p1_pa[k];
        t->lift_n[1][k] += lift[k] * w->area.a2_m2[k] * c->in.p2_pa[k];
        t->length_m[k] += c->in.length_m[k], t->way[k] += way[k];
    }
}

static const struct weighing_test *same_test(const struct weighing *w, const struct weighing_test *t) {
    for (const struct weighing_test *u = w->test; u < w->test + w->tests; u++)
        if (u->dof == t->dof && u->test == t->test && u->samples) return u;
    return NULL;
}

/* Sums of the tests that are in both recordings. */
struct difference {
    int tests;
    double kg, square_kg;             /* sums of the readings, and of their squares */
    double lift_n[2][LEGS], length_m[LEGS], way[LEGS];
};

static void subtract(const struct weighing *without, const struct weighing *with, double gravity_mps2, struct difference *d) {
    *d = (struct difference){0};
    for (const struct weighing_test *t = without->test; t < without->test + without->tests; t++) {
        const struct weighing_test *u = t->samples ? same_test(with, t) : NULL;
        double kg = 0.0;
        if (!u || fabs((double)u->samples / (double)t->samples - 1.0) > BROKEN_OFF) continue;
        for (int k = 0; k < LEGS; k++) {
            double side_n[2];
            for (int s = 0; s < 2; s++) {
                side_n[s] = u->lift_n[s][k] / (double)u->samples - t->lift_n[s][k] / (double)t->samples;
                d->lift_n[s][k] += side_n[s];
            }
            d->length_m[k] += t->length_m[k] / (double)t->samples;
            d->way[k] += u->way[k] / (double)u->samples - t->way[k] / (double)t->samples;
            kg += (side_n[0] - side_n[1]) / gravity_mps2;
        }
        d->tests++, d->kg += kg, d->square_kg += square(kg);
    }
}

/* Returns the change of the weight's reading, N, for one metre of `changed`, which is a length in
 * length_m or a coordinate of a joint in k; 0 if no pose has these lengths. */
static double turned(struct kinematics *k, const double length_m[LEGS], double *changed, const double force_n[LEGS],
                     const double lift[LEGS]) {
    double before = *changed, pose[DOFS] = {0}, other[LEGS], sum = 0.0;
    *changed = before + STEP_M;
    bool found = lifts(k, length_m, pose, other);
    *changed = before;
    for (int i = 0; i < LEGS && found; i++) sum += force_n[i] * (other[i] - lift[i]) / STEP_M;
    return sum;
}

/* Variance of the reading, N^2, by the uncertainty of the lengths' zeros and of the joints. */
static double geometry_variance(const struct params *params, const double length_m[LEGS], double lift_n[2][LEGS]) {
    const struct tolerance_params *t = &params->model.tolerance;
    struct kinematics k;
    double length[LEGS], pose[DOFS] = {0}, lift[LEGS], force_n[LEGS], variance = 0.0;
    kinematics_place(&k, params);
    memcpy(length, length_m, sizeof length);
    if (!lifts(&k, length, pose, lift)) return 0.0;
    for (int i = 0; i < LEGS; i++) force_n[i] = (lift_n[0][i] - lift_n[1][i]) / lift[i];
    for (int i = 0; i < LEGS; i++) {
        variance += square(t->length_zero_m * turned(&k, length, &length[i], force_n, lift));
        for (int axis = 0; axis < 3; axis++) {
            variance += square(t->joints_m) / 3.0 * square(turned(&k, length, &k.upper[i][axis], force_n, lift));
            variance += square(t->joints_m) / 3.0 * square(turned(&k, length, &k.lower[i][axis], force_n, lift));
        }
    }
    return variance;
}

/* Finds the part of the reading, kg, that the drift of the zeros between the logs causes, and the
 * variance of this part. The drift is the change of the readings at rest, weighted against its
 * prior of mean zero. Without rests the drift counts as zero, with the prior's variance. */
static double drift_kg(const struct weighing_log *without, const struct weighing_log *with, const struct params *params,
                       const double lift[LEGS], double *variance_kg2) {
    const struct cylinder_areas *area = &with->sums->area;
    const struct rest_found *before = without->rest, *after = with->rest;
    double prior = square(params->model.tolerance.pressure_drift_pa), sum_n = 0.0, variance_n2 = 0.0;
    bool rested = before->samples >= REST_LEAST && after->samples >= REST_LEAST;
    for (int s = 0; s < 2; s++)
        for (int k = 0; k < LEGS && prior > 0.0; k++) {
            double per_pa = lift[k] * (s ? -area->a2_m2[k] : area->a1_m2[k]);
            double noise = square(before->zero_std_pa[s][k]) + square(after->zero_std_pa[s][k]);
            double trust = rested ? prior / (prior + noise) : 0.0;
            sum_n += per_pa * trust * (after->zero_pa[s][k] - before->zero_pa[s][k]);
            variance_n2 += square(per_pa) * prior * (1.0 - trust);
        }
    *variance_kg2 = variance_n2 / square(params->payload.gravity_mps2);
    return sum_n / params->payload.gravity_mps2;
}

/* Finds the part of the reading, kg, by dry friction, and the variance of this part. */
static double friction_kg(const struct method_c *m, const double lift[LEGS], const double way[LEGS], double gravity_mps2,
                          double *variance_kg2) {
    double sum_n = 0.0, variance_n2 = 0.0;
    for (int k = 0; k < LEGS; k++) {
        double dry_n = 0.5 * (m->dry[k][0] + m->dry[k][1]), std_n = 0.5 * hypot(m->dry_std[k][0], m->dry_std[k][1]);
        sum_n += lift[k] * way[k] * dry_n;
        variance_n2 += square(lift[k] * way[k] * std_n);
    }
    *variance_kg2 = (variance_n2 + square(COURSE * sum_n)) / square(gravity_mps2);
    return sum_n / gravity_mps2;
}

/* Subtracts drift and friction from the reading, and finds its standard deviation. scatter_kg2:
 * variance of one test's reading. */
static void correct(const struct weighing_log *without, const struct weighing_log *with, const struct params *params, struct weight weight,
                    const struct method_c *friction, const struct difference *d, double scatter_kg2, struct weighing_found *found) {
    double n = d->tests, gravity = params->payload.gravity_mps2, length_m[LEGS], way[LEGS], lift_n[2][LEGS], lift[LEGS], pose[DOFS] = {0};
    double drift_kg2 = 0.0, friction_kg2 = 0.0;
    for (int k = 0; k < LEGS; k++) {
        length_m[k] = d->length_m[k] / n, way[k] = d->way[k] / n;
        for (int s = 0; s < 2; s++) lift_n[s][k] = d->lift_n[s][k] / n;
        for (int s = 0; s < 2; s++) found->share[s][k] = (s ? -1.0 : 1.0) * lift_n[s][k] / (gravity * weight.kg);
    }
    if (!lifts(&with->sums->kinematics, length_m, pose, lift)) return;
    found->drift_kg = drift_kg(without, with, params, lift, &drift_kg2);
    found->friction_kg = friction_kg(friction, lift, way, gravity, &friction_kg2);
    found->reading_kg -= found->drift_kg + found->friction_kg, found->drift_std_kg = sqrt(drift_kg2);
    /* Student's t of n - 1 degrees of freedom has the variance (n - 1) / (n - 3). */
    double student = scatter_kg2 / n * (n - 1.0) / (n - 3.0), geometry = geometry_variance(params, length_m, lift_n) / square(gravity);
    found->std_kg = sqrt(student + geometry + drift_kg2 + friction_kg2 + square(weight.std_kg));
}

/* Refuses two logs whose pressures at rest differ by more than zeros can drift. */
static int check_rests(const struct rest_found *before, const struct rest_found *after, const struct params *params, struct error *error) {
    double prior = square(params->model.tolerance.pressure_drift_pa);
    if (before->samples < REST_LEAST || after->samples < REST_LEAST) return STATUS_OK;
    for (int s = 0; s < 2; s++)
        for (int k = 0; k < LEGS; k++) {
            double change_pa = after->zero_pa[s][k] - before->zero_pa[s][k];
            double noise = square(before->zero_std_pa[s][k]) + square(after->zero_std_pa[s][k]);
            if (square(change_pa) > square(NO_DRIFT) * (prior + noise))
                return error_set(error, STATUS_USAGE,
                                 "--weight: P%d of leg %d reads %.3g MPa more at rest in the second log; model.tolerance.pressure_drift_pa "
                                 "allows for %.3g MPa (standard deviation): let the chambers lose their pressure before either run begins",
                                 s + 1, k + 1, 1e-6 * change_pa, 1e-6 * params->model.tolerance.pressure_drift_pa);
        }
    return STATUS_OK;
}

static int check_friction(const struct method_c *m, struct error *error) {
    for (int k = 0; k < LEGS; k++)
        if (isnan(m->dry[k][0] + m->dry[k][1]))
            return error_set(error, STATUS_USAGE,
                             "--weight: the first log does not determine the dry friction of leg %d, which it takes to weigh: longer tests",
                             k + 1);
    return STATUS_OK;
}

int weighing_find(const struct weighing_log *without, const struct weighing_log *with, const struct params *params, struct weight weight,
                  const struct method_c *friction, struct weighing_found *found, struct error *error) {
    struct difference d;
    subtract(without->sums, with->sums, params->payload.gravity_mps2, &d);
    if (d.tests < WEIGHING_LEAST || !(params->payload.gravity_mps2 > 0.0))
        return error_set(error, STATUS_USAGE, "--weight: %d tests are complete in both logs, and it takes %d: record the same tests twice",
                         d.tests, WEIGHING_LEAST);
    int status = check_rests(without->rest, with->rest, params, error);
    if (!status) status = check_friction(friction, error);
    if (status) return status;
    double n = d.tests, scatter_kg2 = fmax(d.square_kg - square(d.kg) / n, 0.0) / (n - 1.0);
    *found = (struct weighing_found){.stated_kg = weight.kg, .reading_kg = d.kg / n, .tests = d.tests};
    correct(without, with, params, weight, friction, &d, scatter_kg2, found);
    if (!(found->std_kg < LIKELY * weight.kg))
        return error_set(error, STATUS_USAGE, "--weight %g: these logs weigh within +- %.2g kg: take more weight, or rests in both logs",
                         weight.kg, NUMERIC_95 * found->std_kg);
    if (fabs(found->reading_kg / weight.kg - 1.0) < LIKELY) return STATUS_OK;
    return error_set(error, STATUS_USAGE,
                     "--weight %g: the legs carry %.4g kg more in the second log than in the first: name the log without the weight "
                     "first, then the one with it, and its mass in kg",
                     weight.kg, found->reading_kg);
}

void weighing_note(const struct weighing_found *found, struct params *params) {
    memcpy(params->found.weight_p1, found->share[0], sizeof found->share[0]);
    memcpy(params->found.weight_p2, found->share[1], sizeof found->share[1]);
    params->found.weight_error = found->reading_kg / found->stated_kg - 1.0;
    params->found.weight_std = found->std_kg / found->stated_kg;
}
